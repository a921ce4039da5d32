// The convex hull of a few points of the plane. Inside the room.
//
// Pure functions. Any thread.
#ifndef PERIGEE_GEO_GRID_HULL_H
#define PERIGEE_GEO_GRID_HULL_H

#include <stdbool.h>

enum { GRID_HULL_MAX = 512 };

// Points as they were added; after grid_hull_close the lower chain from left to right and the upper
// chain likewise.
struct grid_hull {
    int count, lower_count, upper_count;
    double point[GRID_HULL_MAX][2], lower[GRID_HULL_MAX][2], upper[GRID_HULL_MAX][2];
};

// Further points than there is room for are left out.
void grid_hull_add(struct grid_hull *hull, double x, double y);
void grid_hull_close(struct grid_hull *hull);

// Bounds of the hull's y between two x; false when it has none there.
bool grid_hull_between(const struct grid_hull *hull, double left, double right, double *low,
                       double *high);

#endif
