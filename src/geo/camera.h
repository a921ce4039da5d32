// A camera over the planet and its eye frame: x right, y up, z towards the viewer (OpenGL's).
// Pure functions. Any thread.
#ifndef PERIGEE_GEO_CAMERA_H
#define PERIGEE_GEO_CAMERA_H

#include "geo/ellipsoid.h"

// heading clockwise from north; pitch 0 at the horizon plane, -pi/2 straight down; roll clockwise
// as seen by the camera. At a pole the heading counts from the meridian of `position.lon`, as
// everywhere.
typedef struct geo_camera {
    geodetic position;
    double heading, pitch, roll;
    double fov_y; // vertical field of view, in (0, pi)
} geo_camera;

// Rotation to the eye frame: eye_from_ecef * (p - camera position in ECEF).
dmat3 geo_eye_from_ecef(const geo_camera *c);

// heading, pitch, roll of an orientation at a position; the inverse of geo_eye_from_ecef. Looking
// exactly up or down, roll is 0 and the heading carries the turn.
void geo_camera_orient(geo_camera *c, dmat3 eye_from_ecef);

// The same rotation over any body.
dmat3 geo_eye_over(geo_ellipsoid e, const geo_camera *c);

#endif
