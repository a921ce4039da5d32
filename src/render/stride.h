// How many rings and columns are left out, where they would stand too close on the screen to show:
// where the camera is far from them against their own radius (from space, under an aircraft, around
// a far focus). By the place of camera and focus only, so that a frame does not depend on the path
// that led to it. A band draws every second, fourth or eighth
// ring as it needs; columns are left out of the whole frame alike. So neighbouring bands share the
// vertices of the ring between them, and nothing can crack.
//
// Nothing pops either: of the vertices drawn, every second ring and column slides onto the one
// before it while the stride is about to double, and is gone when it does (mesh/mesh.vert).
// Vertices that sank into the chord between their neighbours instead would leave the triangles'
// diagonals to jump.
//
// Pure functions. Any thread.
#ifndef PERIGEE_RENDER_STRIDE_H
#define PERIGEE_RENDER_STRIDE_H

#include "render/cells.h"
#include "render/gaze.h"

enum { STRIDE_COUNT = 4, STRIDE_MAX = 1 << (STRIDE_COUNT - 1) };

typedef struct ring_sight {
    double radius;     // of the planet, m
    double altitude;   // of the camera above the ellipsoid, m
    double pixel;      // angle of a pixel in the middle of the picture, rad
    double spacing_px; // vertices are left out while they stay so close and the chord between them
                       // keeps to the arc; 0: none is
    gaze gaze;
} ring_sight;

// One in `stride` is drawn, a power of two up to STRIDE_MAX; of those, every second one has slid
// onto the one before it by the share `slid`, which is 1 where the stride doubles.
typedef struct thinning {
    int stride;
    double slid;
} thinning;

// Of a band's rings: the largest stride that divides them and keeps the spacing.
thinning thin_rings(const ring_params *rings, const ring_sight *sight, int level, int band);

// Of a cell's columns: the largest stride that divides them and keeps the spacing from the level
// `last` out to the angle `reach` from the focus.
thinning thin_columns(const ring_params *rings, const ring_sight *sight, double reach, int last);

#endif
