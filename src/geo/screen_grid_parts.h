// What the parts of the persistent grid's set-up share (screen_grid.c, screen_grid_columns.c).
// Inside the room.
//
// Pure functions. Any thread.
#ifndef PERIGEE_GEO_SCREEN_GRID_PARTS_H
#define PERIGEE_GEO_SCREEN_GRID_PARTS_H

#include "geo/grid_hull.h"
#include "geo/screen_grid.h"

enum { HALVINGS = 48 };

// A camera in the space of the unit sphere: a direction's x, y and depth by rows, and the direction
// of x, y and depth 1 by columns.
struct eye {
    dvec3 row[3], column[3];
};

struct setting {
    const grid_params *p;
    bool plane;
    double corner; // of a plane: distance of the map's farthest corner, in radii
    struct grid_block *block;
    struct eye view, sampling;
    double half_x, half_y; // of the picture
    dvec3 foot, up, axis;
    struct grid_hull hull; // in the sampling picture: what must be covered besides the picture
};

struct span {
    double low, high;
};

static inline bool span_empty(struct span s)
{
    return !(s.low <= s.high);
}

// The columns, once block, hull and cameras of the setting are there. False when there is nothing
// to sample.
bool grid_set_columns(const struct setting *setting, struct grid_column *columns);

#endif
