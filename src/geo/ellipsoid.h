// The planet's reference ellipsoid of revolution and the three ways to say where a point is.
//   ECEF       metres, x to (lat 0, lon 0), y to (0, 90 E), z to the north pole
//   geodetic   latitude of the surface normal, longitude, height along the normal (rad, rad, m)
//   reduced    latitude b with tan b = (B/A) tan(lat): the ellipsoid is D u, D = diag(A, A, B), u
//   on the unit sphere
// Pure functions. Any thread.
#ifndef PERIGEE_GEO_ELLIPSOID_H
#define PERIGEE_GEO_ELLIPSOID_H

#include "base/vec.h"

// Semi-axes in metres, both > 0; equal for a sphere.
typedef struct geo_ellipsoid {
    double a, b;
} geo_ellipsoid;

#define GEO_WGS84 ((geo_ellipsoid){6378137.0, 6356752.314245179})

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

// lon moved by whole turns into [-pi, pi).
double geo_wrap_lon(double lon);

// Where a ray origin + t dir (t >= 0, dir unit, ECEF metres) first meets the ellipsoid grown by
// `height` (both axes). Returns t, or NaN when it misses. From inside, the exit.
double geo_ray_ellipsoid(geo_ellipsoid e, double height, dvec3 origin, dvec3 dir);

#endif
