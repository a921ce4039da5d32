// Which tiles an import makes: at each zoom those that a source of that zoom or finer touches
// inside the bounds.
#ifndef PERIGEE_PLANET_IMPORT_PLAN_H
#define PERIGEE_PLANET_IMPORT_PLAN_H

#include "planet/import_raster.h"

// West, south, east, north in rad; east > west, at most 2 pi more. The whole globe: -pi, -pi/2, pi,
// pi/2.
typedef struct plan_bounds {
    double west, south, east, north;
} plan_bounds;

// Is a point inside? lon in any turn.
bool plan_bounds_hold(const plan_bounds *b, double lat, double lon);
bool plan_bounds_are_global(const plan_bounds *b);

struct plan_walk;

// Walks the tiles of one layer and zoom, on odd zooms from the north and west, on even ones from
// the south and east, so that a zoom begins where the finer one ended. The finest zoom of `grids`
// goes row by row, as rasters lie in their files. Others of 128 rows or more go by blocks of 8
// rows, column by column, so that the children that a tile has in common with those before lie in a
// few columns, not in whole rows. `grids` is borrowed. reach: also those into which the filter
// carries what a finer source says, from so many of this zoom's rows away; 0 unless there may be
// tiles without a source in them.
struct plan_walk *plan_walk_begin(enum tile_layer layer, int zoom, const raster_grid *grids,
                                  int count, const plan_bounds *bounds, int reach);
bool plan_walk_next(struct plan_walk *walk, tile_id *id);
uint64_t plan_walk_left(const struct plan_walk *walk); // tiles still to come
// Leaves the walk its next `keep` tiles (at most what is left) and returns a walk of the rest.
struct plan_walk *plan_walk_split(struct plan_walk *walk, uint64_t keep);
void plan_walk_end(struct plan_walk **walk);

#endif
