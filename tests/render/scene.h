// What the render tests share: an analytic planet imported through the real path, a headless
// context, and a plain camera model of their own (no src/geo, no src/render), so that what is
// rendered is judged by independent arithmetic.
#ifndef PERIGEE_TESTS_RENDER_SCENE_H
#define PERIGEE_TESTS_RENDER_SCENE_H

#include "check.h"

#include "perigee.h"
#include "analytic_planet.h"

enum { SCENE_WIDTH = 320, SCENE_HEIGHT = 240 };

// A map as a plane: x up, y east, z north of its latitude and longitude 0, which are metres over
// `radius`.
typedef struct scene_map {
    double radius, south, north, west, east;  // m; rad
    double (*height)(double lat, double lon); // its slope below 1
    double height_min, height_max;            // m
} scene_map;

// From here on the planets opened are flat, and what follows speaks of that map; the other one is
// the whole map of the analytic planet. NULL, at first: the globe.
void scene_set_flat(const scene_map *map);
extern const scene_map scene_analytic_map;
const scene_map *scene_flat(void);

// The analytic planet (made once a process tree: reused when it exists) opened; fails the test when
// it cannot be.
perigee_planet *scene_planet(void);

// A view of it; params may be NULL.
perigee_view *scene_view(perigee_planet *planet, const perigee_view_params *params);

// Binds a framebuffer of the size.
void scene_bind(int width, int height);

// Sets the camera, waits for all data and renders into a framebuffer of the scene's size.
void scene_render(perigee_view *view, const perigee_camera *camera, int width, int height);

// ECEF ray of a pixel centre: origin, and a direction of length 1 along the view axis.
void scene_ray(const perigee_camera *camera, int width, int height, double x_px, double y_px,
               double origin[3], double direction[3]);

// Geodetic latitude, longitude (rad) and height of an ECEF point on WGS84, by fixed-point
// iteration.
void scene_geodetic(const double ecef[3], double *lat, double *lon, double *height);

// Distance along the ray (in units of `direction`) to the terrain, NaN for sky and, flat, off the
// map: marching, then bisection.
double scene_trace(const double origin[3], const double direction[3]);

// sRGB encoding of linear light, 0 to 255: what a screen is given.
double scene_encoded(double light);

// The headless context around a program's tests: 0, or the exit status to leave with (77: no EGL);
// then the exit status.
int scene_open(void);
int scene_close(int failed);

#endif
