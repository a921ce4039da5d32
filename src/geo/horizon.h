// What of the planet can be seen from a camera, in angles from its nadir on the unit sphere of
// reduced latitude (Clasen & Hege 2006, 4.5 with the errata; exact in the scaled space where the
// ellipsoid is the unit sphere).
//
// Pure functions. Any thread.
#ifndef PERIGEE_GEO_HORIZON_H
#define PERIGEE_GEO_HORIZON_H

#include "geo/ellipsoid.h"

// Upper bound of the angle, measured on the unit sphere from the direction of D^-1 camera, at which
// terrain no higher than `summit` metres above the ellipsoid can show. camera in ECEF. pi when the
// camera is at or below the surface grown by `floor_height` (the lowest terrain, <= 0 where there
// are depressions). Over a plane the distance to the farthest corner of the map, in radii.
double geo_horizon_angle(geo_ellipsoid e, dvec3 camera, double floor_height, double summit);

// Size in metres of one pixel on a surface `distance` metres away, facing the camera (eq. 7
// corrected): 2 distance tan(fov_y / 2) / height_px.
double geo_pixel_size(double distance, double fov_y, int height_px);

#endif
