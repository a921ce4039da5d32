// A recorded flight: key views joined by geodesics and a smooth zoom-and-pan in log altitude. Any thread once made.
#ifndef PERIGEE_GEO_FLIGHT_H
#define PERIGEE_GEO_FLIGHT_H

#include "geo/camera.h"

// One key view. fov_y <= 0 keeps the flight's default. `altitude` is position.height, metres above the ellipsoid, > 0.
typedef struct flight_key {
    double time_s;
    geo_camera camera;
} flight_key;

struct flight;

// Keys in growing time, at least one; copied. NULL when they are not (the caller has checked and reported).
struct flight *flight_create(geo_ellipsoid e, const flight_key *keys, int count);
void flight_destroy(struct flight **flight);

double flight_duration_s(const struct flight *flight);

// The camera at a time, clamped to the flight. Position runs along the geodesic between keys (GeographicLib), its
// progress and log altitude by monotone smooth interpolation through the keys; heading is carried along the geodesic and
// turned the short way, so that a pole is crossed without a turn of the picture.
geo_camera flight_at(const struct flight *flight, double time_s);

#endif
