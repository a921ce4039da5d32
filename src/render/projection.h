// From a camera to the numbers of a frame: the focus of the rings, the uniform block, the frustum,
// the levels in range. Pure functions. Any thread.
#ifndef PERIGEE_RENDER_PROJECTION_H
#define PERIGEE_RENDER_PROJECTION_H

#include "geo/camera.h"
#include "geo/focus.h"
#include "render/blocks.h"
#include "render/cells.h"

typedef struct projection {
    geo_ellipsoid ellipsoid;
    geo_camera camera;
    dvec3 camera_ecef;
    struct geo_focus focus; // of the rings
    dmat3 eye_from_meridian;
    int width, height;         // px
    double jitter_x, jitter_y; // px, by which the picture is moved
} projection;

// What is nearer than this along the view axis is cut off. Depth is reversed and a float, so that a
// near plane costs it nothing; at a field of view of 179 degrees and an aspect of 4 to 3 ground is
// seen at 1/191 of its distance along the axis. A power of two, for the shaders.
#define PROJECTION_NEAR_M 0x1p-13

// Not jittered. The focus: geodetic, rad, anywhere on the planet.
projection projection_make(geo_ellipsoid e, const geo_camera *camera, double focus_lat,
                           double focus_lon, int width, int height);

// Fills everything of the block but mode and layers.
void projection_fill_block(const projection *p, dvec3 sun_ecef, bool sky_glow,
                           struct view_block *block);

// lowest, summit: bounds of the planet's heights.
cell_view projection_cell_view(const projection *p, double lowest, double summit);

// Point of the meridian frame, relative to the camera, at pixel (x, y) (centre of the top left
// pixel: 0.5, 0.5) and distance z along the view axis.
dvec3 projection_unproject(const projection *p, double x_px, double y_px, double z);

// Width of a pixel at a metre, for choosing how fine to draw. At the picture's centre; for wider
// views than this as for it, because pixels there come to cover degrees while those at the border,
// where the nearest ground is, cover ever less.
#define PROJECTION_WIDE_FOV (120 * M_PI / 180)
double projection_pixel(const projection *p);

// Angle from the focus beyond which nothing shows; at most pi.
double projection_reach(const cell_view *view);

// Coarsest level that can be seen (by the horizon) and finest that is worth drawing: its samples
// (`rows` across its diameter) are no wider than a pixel on the ground `distance` metres away.
int projection_first_level(const cell_view *view);
int projection_last_level(const projection *p, double distance, double rows, int levels);
// How long ago, in octaves of the distance, the last level came in; INFINITY: it is the finest or
// the coarsest that there may be.
double projection_last_level_age(const projection *p, double distance, double rows, int levels);

#endif
