// One gesture's effect on a camera: the geometry of dragging, zooming, turning and moving over the
// ellipsoid or a plane. Every function keeps the camera's altitude, pitch and roll unless it says
// otherwise, and leaves the camera alone when there is no finite answer. Pixels count from the top
// left corner. Pure functions. Any thread.
#ifndef PERIGEE_APP_CONTROL_POSE_H
#define PERIGEE_APP_CONTROL_POSE_H

#include <stdbool.h>

#include "geo/camera.h"

struct pose_screen {
    int width, height; // pixels, >= 1
};

// A point of the ground held under the cursor, in ECEF. Filled by pose_grab_make.
struct pose_grab {
    dvec3 point;
    double distance; // from the camera when it was taken
    bool far;  // the camera's ray meets the sphere through the point twice; this is the second time
    bool free; // near a pole: the globe turns as a ball; elsewhere the heading is held
};

// Unit direction of a pixel in the eye frame (x right, y up, z towards the viewer).
dvec3 pose_eye_ray(const geo_camera *c, struct pose_screen s, double x_px, double y_px);

// The same in ECEF.
dvec3 pose_ray(geo_ellipsoid e, const geo_camera *c, struct pose_screen s, double x_px,
               double y_px);

// Pixel of an ECEF point; false when it is not in front of the camera.
bool pose_project(geo_ellipsoid e, const geo_camera *c, struct pose_screen s, dvec3 point,
                  double *x_px, double *y_px);

struct pose_grab pose_grab_make(geo_ellipsoid e, const geo_camera *c, dvec3 point);

// Grabs where the eye ray meets the sphere of `radius` about the planet's centre, or comes closest
// to it.
struct pose_grab pose_grab_sphere(geo_ellipsoid e, const geo_camera *c, dvec3 eye_ray,
                                  double radius);

// Turns the camera about the planet's centre until the grabbed point lies on the eye ray. A ray
// over the limb, or one that would carry the camera much farther than the point was away, holds the
// nearest place that can be reached.
//   error   1e-6 px from 200 m to 2e7 m, poles included (tests/app/test_control.c)
void pose_drag(geo_ellipsoid e, geo_camera *c, struct pose_grab *grab, dvec3 eye_ray);

// Moves the camera to `factor` times its distance from the point, which stays on the eye ray.
// Changes the altitude.
void pose_zoom(geo_ellipsoid e, geo_camera *c, dvec3 point, dvec3 eye_ray, double factor);

// Swings the camera about a point that stays on the eye ray: `turn` about the point's normal
// (positive: the heading grows), `tilt` raises the pitch. The camera never rolls; where that makes
// the ray unreachable the point slides.
void pose_orbit(geo_ellipsoid e, geo_camera *c, dvec3 point, dvec3 eye_ray, double turn,
                double tilt);

// Turns the head: heading and pitch, the pitch within [-pi/2, pi/2].
void pose_look(geo_camera *c, double turn, double tilt);

// Moves along the ground, metres at the camera's altitude, right and ahead.
void pose_move(geo_ellipsoid e, geo_camera *c, double right, double ahead);

// Turns the head so that an ECEF point shows on the eye ray.
void pose_aim(geo_ellipsoid e, geo_camera *c, dvec3 point, dvec3 eye_ray);

bool pose_is_finite(const geo_camera *c);

#endif
