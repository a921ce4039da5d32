// A frame's screen-space geometric error: each ninth pixel's point, its distance from the surface
// of the data along that surface's normal, projected to the screen (px). The surface is the tile
// pyramid's, bilinear in one zoom, so this tells the renderer's error in a second; src/reference is
// the judge that shares nothing (tests/reference/test_views.c says by how much the two differ).
// Main thread only.
#ifndef PERIGEE_BENCH_ERROR_JUDGE_H
#define PERIGEE_BENCH_ERROR_JUDGE_H

#include "app/views_file.h"
#include "perigee.h"
#include "planet/planet_file.h"
#include "planet/pyramid.h"

enum { ERROR_WIDTH = 1280, ERROR_HEIGHT = 960, ERROR_LEVELS = 24 };

struct error_judge {
    struct pyramid *pyramid;
    geo_ellipsoid e;
};

// Of the pixels measured. above: share of errors above a pixel.
struct error_stat {
    size_t count;
    double rms, p999, max, above;
};

struct error_result {
    struct error_stat all, level[ERROR_LEVELS]; // by the ring's level
    size_t ground;                              // pixels of the picture
};

// The view's camera over this ground, and the zoom of the data it is judged by.
perigee_camera error_camera(const struct error_judge *judge, const named_view *view);
int error_zoom(const named_view *view);

// Judges the view's last frame, of ERROR_WIDTH x ERROR_HEIGHT; false when it cannot be read.
bool error_judge_frame(const struct error_judge *judge, perigee_view *frame,
                       const perigee_camera *camera, int zoom, struct error_result *out);

#endif
