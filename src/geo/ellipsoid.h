// The planet's body, a reference ellipsoid of revolution or its map as a plane, and the ways to say
// where a point is.
//   ECEF       metres, x to (lat 0, lon 0), y to (0, 90 E), z to the north pole
//   geodetic   latitude of the surface normal, longitude, height along the normal (rad, rad, m)
//   reduced    latitude b with tan b = (B/A) tan(lat): the ellipsoid is D u, D = diag(A, A, B), u
//   on the unit sphere
// On a plane "ECEF" has x up, y east and z north of the map's origin, which are also ECEF's axes
// where an ellipsoid's map has it; latitude and longitude are the map's, metres over `a`.
// Pure functions. Any thread.
#ifndef PERIGEE_GEO_ELLIPSOID_H
#define PERIGEE_GEO_ELLIPSOID_H

#include <stdbool.h>

#include "base/vec.h"

// Semi-axes in metres, both > 0; equal for a sphere. With `north` > `south` a plane of this scale
// (a = b, metres a radian) instead: its map ends at these latitudes and longitudes; beyond is
// nothing.
typedef struct geo_ellipsoid {
    double a, b;
    double south, north, west, east; // rad, within pi/2 and pi, about 0; all 0: no plane
} geo_ellipsoid;

#define GEO_WGS84 ((geo_ellipsoid){.a = 6378137.0, .b = 6356752.314245179})

static inline bool geo_is_plane(geo_ellipsoid e)
{
    return e.north > e.south;
}

// The whole map of longitude and latitude as a plane, true to scale along the equator.
geo_ellipsoid geo_plane_of(geo_ellipsoid e);

typedef struct geodetic {
    double lat, lon, height;
} geodetic;

// ECEF position of a geodetic point. NaN when |lat| > pi/2.
dvec3 geo_ecef_from_geodetic(geo_ellipsoid e, geodetic p);

// Geodetic point of an ECEF position; lon in [-pi, pi], 0 on the axis. NaN at the centre.
geodetic geo_geodetic_from_ecef(geo_ellipsoid e, dvec3 p);

double geo_reduced_from_geodetic(geo_ellipsoid e, double lat);
double geo_geodetic_from_reduced(geo_ellipsoid e, double reduced);

// Outward unit normal at a geodetic latitude and longitude.
dvec3 geo_normal(double lat, double lon);

// Columns east, north, up in ECEF: ecef_from_enu * v. Defined at the poles by the given longitude.
dmat3 geo_ecef_from_enu(double lat, double lon);

// The same two on any body.
dvec3 geo_up_at(geo_ellipsoid e, double lat, double lon);
dmat3 geo_frame_at(geo_ellipsoid e, double lat, double lon);

// lon moved by whole turns into [-pi, pi).
double geo_wrap_lon(double lon);

// Where a ray origin + t dir (t >= 0, dir unit, ECEF metres) first meets the ellipsoid grown by
// `height` (both axes), or the plane at that height. Returns t, or NaN when it misses. From inside,
// the exit.
double geo_ray_ellipsoid(geo_ellipsoid e, double height, dvec3 origin, dvec3 dir);

#endif
