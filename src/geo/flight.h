// A recorded flight: key views joined by geodesics and a smooth zoom-and-pan in log altitude.
//
// Any thread once made.
#ifndef PERIGEE_GEO_FLIGHT_H
#define PERIGEE_GEO_FLIGHT_H

#include "geo/camera.h"

// One key view. Altitude is position.height, metres above the ellipsoid, > 0. fov_y <= 0 keeps that
// of the nearest earlier key, or else later key, that has one; when none has, flight_at gives 0 and
// the caller's default holds.
typedef struct flight_key {
    double time_s;
    geo_camera camera;
} flight_key;

struct flight;

// Keys in growing time, at least one, finite, |lat| <= pi/2, altitude > 0; copied. NULL when they
// are not (the caller has checked and reported).
struct flight *flight_create(geo_ellipsoid e, const flight_key *keys, int count);
void flight_destroy(struct flight **flight);

double flight_duration_s(const struct flight *flight);

// The camera at a time (the keys' own clock), clamped to the flight. Position runs along the
// geodesic between keys (GeographicLib), its progress and log altitude by monotone smooth
// interpolation through the keys, progress in proportion to altitude so that the picture moves
// evenly; heading is carried along the geodesic and turned the short way, so that a pole is crossed
// without a turn of the picture.
geo_camera flight_at(const struct flight *flight, double time_s);

#endif
