// The body that a reference is cast against: the ellipsoid, by GeographicLib, or a plane. Places in
// degrees and metres, points in the body's axes (geo/ellipsoid.h). Any thread.
#ifndef PERIGEE_REFERENCE_BODY_H
#define PERIGEE_REFERENCE_BODY_H

#include "base/vec.h"
#include "geo/ellipsoid.h"

dvec3 body_point(geo_ellipsoid e, double lat_deg, double lon_deg, double height);
void body_locate(geo_ellipsoid e, dvec3 point, double *lat_deg, double *lon_deg, double *height);

// Unit vectors at a place, and metres a radian at height h: of latitude, of the way to the east,
// and of longitude. On a plane its scale.
typedef struct body_frame {
    dvec3 east, north, up;
    double meridian; // radius of curvature
    double per_lat, per_east, per_lon;
} body_frame;

body_frame body_frame_at(geo_ellipsoid e, double lat_deg, double lon_deg, double height);

// Where the sun stands over a camera while it is always day: perigee.h has it.
dvec3 body_noon(geo_ellipsoid e, dvec3 camera);

// No ground is farther from the point.
double body_reach(geo_ellipsoid e, dvec3 point);

// The part of a ray from `from` metres to `to` that is over the map; all of it on an ellipsoid.
// False: none.
bool body_over_map(geo_ellipsoid e, dvec3 origin, dvec3 dir, double *from, double *to);

#endif
