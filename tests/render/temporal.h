// What changes between two frames, and by how much a fixed point of the ground is off. Judged by
// the ray caster's camera and GeographicLib's conversions (src/reference), by nothing of
// src/render. Main thread only.
#ifndef PERIGEE_TESTS_RENDER_TEMPORAL_H
#define PERIGEE_TESTS_RENDER_TEMPORAL_H

#include "render/scene.h"

#include "planet/pyramid.h"

enum { TEMPORAL_WIDTH = 240, TEMPORAL_HEIGHT = 180 };
enum { TEMPORAL_PIXELS = TEMPORAL_WIDTH * TEMPORAL_HEIGHT };

// A planet seen by a view and by the reference at once.
typedef struct temporal_scene {
    perigee_planet *planet;
    perigee_view *view;
    struct planet_file *file;
    struct pyramid *pyramid;
    geo_ellipsoid ellipsoid;
} temporal_scene;

// Linear light, and metres along the view axis (NaN: sky), top row first.
typedef struct temporal_picture {
    float r[TEMPORAL_PIXELS], g[TEMPORAL_PIXELS], b[TEMPORAL_PIXELS], z[TEMPORAL_PIXELS];
} temporal_picture;

// By reference/flicker.h: geometry in pixels, colour in 1/255 of encoded light, the same pixels.
typedef struct temporal_change {
    double rms_px, p999_px, worst_px, rms, p999, worst;
    int compared, silhouette; // pixels that count; ground that does not
} temporal_change;

// Views are without air, as the reference is. `params` may be NULL.
temporal_scene temporal_open(const char *path, bool synthesis, const perigee_view_params *params);
void temporal_close(temporal_scene *scene);

// "analytic.planet", WGS84, 9.8 km a sample;
// "pebble.planet": the analytic heights on an ellipsoid of 100 km, so that their slopes (0.1) show
// in the light; "rough.planet": waves at every scale down to the samples, and strong synthesis
// below them. Made once, reused when they exist.
const char *temporal_analytic(void);
const char *temporal_pebble(void);
const char *temporal_rough(void);

// A frame when all data are there; the finest level drawn.
int temporal_see(const temporal_scene *scene, const perigee_camera *camera, temporal_picture *out);
// A frame as it is now, without waiting.
void temporal_see_now(const temporal_scene *scene, const perigee_camera *camera,
                      temporal_picture *out);
// The truth, bilinear in the samples of `zoom` (as reference_params has it).
void temporal_see_reference(const temporal_scene *scene, const perigee_camera *camera, int zoom,
                            temporal_picture *out);

// Of b against a. With ra and rb: of (b - rb) against (a - ra), what the reference's own change
// does not explain.
temporal_change temporal_compare(const temporal_scene *scene, const perigee_camera *camera,
                                 const temporal_picture *a, const temporal_picture *b,
                                 const temporal_picture *ra, const temporal_picture *rb);

// Where the point of the ground at lat, lon (rad) and height is drawn in the frame of `camera`,
// less where it is: pixels, along the vertical of the place. From the four pixels around it: 1 / z
// is linear on the screen over a plane. NaN where the point lies outside the picture, other ground
// hides it, it is near a silhouette or the ray grazes it (below 1 in 20).
double temporal_deviation(const temporal_scene *scene, const perigee_camera *camera,
                          const temporal_picture *frame, double lat, double lon, double height);

// Over a pole on one great circle without a turn of the picture: `angle` (degrees) beyond the north
// (sign 1) or south pole (-1), coming along the meridian lon; heading and position of the camera
// set.
void temporal_cross_pole(perigee_camera *camera, double sign, double lon, double angle);

// Ground, m above the ellipsoid, at degrees.
double temporal_ground(const temporal_scene *scene, double lat_deg, double lon_deg);

#endif
