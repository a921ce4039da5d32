// How far the persistent grid's vertices stray from the uniform grid on the screen when they are
// lifted to the ground: the Hausdorff distance of Livny et al. 2008, 6.1. The uniform grid is the
// rays thrown, the mesh the vertices over the places they meet, lifted by the heights of a file,
// each at the level of detail of their 3.4; both in double and projected by the viewing camera. The
// distance is from one set's vertices in the picture to the nearest of the other's, in or out of
// it; hidden vertices count. Rays past the limb meet nothing: such vertices can be the nearest, but
// none is asked for theirs. Main thread only.
#ifndef PERIGEE_BENCH_GRID_DISTORTION_H
#define PERIGEE_BENCH_GRID_DISTORTION_H

#include <stdbool.h>

#include "geo/screen_grid.h"
#include "planet/pyramid.h"

enum { DISTORTION_WIDTH = 640, DISTORTION_HEIGHT = 480 };

struct point {
    double x, y; // px from the picture's middle; NaN behind the camera
    bool beyond; // its ray passes the limb
};

struct scene {
    grid_params p; // its focus is set by distortion()
    struct geo_focus focus;
    struct pyramid *pyramid; // NULL: the same height everywhere
    double constant_m;
    int finest; // zoom
};

// From the uniform grid to the mesh, which its gaps make great, and back.
struct ways {
    double gap, stray; // px
};

bool in_picture(struct point p);

// Both sets, row by row, and their distances. Exits when no ground can be seen or read.
struct ways distortion(struct scene *s, struct point *uniform, struct point *mesh);

#endif
