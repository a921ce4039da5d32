// The persistent grid (Livny et al. 2008) on the ellipsoid: which rays a frame throws, as a grid of
// rows and columns that covers what the camera can see of the planet and nothing else, and the
// place on the planet under each of them.
//
// The sampling camera stands with the viewing camera and looks as it does, but never above the
// horizontal (their 3.2); x and y are its picture's, tangents of angles. A column is a plane
// through the camera and the pictures's y axis. It reaches as far as the picture or the planet
// does, whichever ends first, so that every sample lies on the planet: a sky shrinks the grid, and
// from space the columns are chords of the disc. Beyond the limb, where summits can show, a few
// rows go on. Where ground can rise into the picture from outside it, the columns go on that far
// (their eq. 3), as the heights of the discs around the camera tell. On a plane nothing ends at a
// limb: the columns end where the map's farthest corner is.
//
// Pure functions. Any thread.
#ifndef PERIGEE_GEO_SCREEN_GRID_H
#define PERIGEE_GEO_SCREEN_GRID_H

#include <stdbool.h>
#include <stdint.h>

#include "geo/camera.h"
#include "geo/focus.h"

#define BLOCK_DVEC4(name)              double name[4];
#define BLOCK_DVEC4_ARRAY(name, count) double name[count][4];

// What the shaders take of a frame's grid (std430).
struct grid_block {
#include "shared/grid_block.glsl"
};

#undef BLOCK_DVEC4
#undef BLOCK_DVEC4_ARRAY

// One column: the direction of its ray at y = 0, the ends of its rows and where it crosses the limb
// (GRID_NOWHERE: it does not), as numbers of grid_row.
struct grid_column {
    double ahead[3], low;
    double high, limb_low, limb_high, spare;
};

#define GRID_NOWHERE 1e30

enum { GRID_DISCS_MAX = 25 };

// Bounds of all heights within an angle of the place under the camera, m.
typedef struct grid_disc {
    double radius, low, high; // radius: rad, on a plane in radii
} grid_disc;

typedef struct grid_params {
    geo_ellipsoid ellipsoid;
    geo_camera camera;
    double aspect; // width / height of the picture
    const struct geo_focus *focus;
    int rows, columns; // vertices; at least 2 each
    double denser;     // 0: the same everywhere in the picture, below 1: denser in its middle
    grid_disc discs[GRID_DISCS_MAX]; // from the whole planet (radius pi) inwards
    int disc_count;                  // at least 1
    double ground_m; // height of what a narrow picture shows, below the camera; NaN: rays are
                     // thrown onto the lowest ground that the discs leave them. Where they land
                     // decides how good the grid is, never whether it covers what shows.
} grid_params;

// Sets up a frame's rays: the block, and one column for each of params->columns. False when no
// ground can be seen, or when the camera is not above the lowest ground under it.
bool grid_make(const grid_params *params, struct grid_block *block, struct grid_column *columns);

// Height of the lowest ground around the camera; the camera must be above it.
double grid_lowest_m(const grid_params *params);

// Direction of the ray of a row and a column, and the place under it: unit vectors u, e, n about
// the focus on the sphere of reduced latitude; on a plane 0 and the map's coordinates from the
// focus. The direction is not of unit length.
void grid_ray(const grid_params *params, const struct grid_block *block,
              const struct grid_column *column, int row, double direction[3], double place[3]);

#endif
