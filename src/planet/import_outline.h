// The outer border of a mosaic, and how far inside it a sample lies, as the weight it has over what
// lies below: 0 at the border, 1 from the seam's width on, smooth between.
//
// The border is what the rasters' own outlines say, without those pieces that another raster of the
// mosaic covers or goes on at: a hole in the data is no border (import_blend.h). A step of height e
// laid over a width W is a slope of at most 1.5 e / W; e is the error of the coarser raster, of the
// size of its relief within a sample, so that over a width of one of its samples the seam is about
// as steep as the coarse ground itself. The width is at most half of what is left to the middle:
// of the radius of the greatest circle about a raster's centre that lies in the mosaic and reaches
// the piece within half a radius. So at least the middle half of a small mosaic is its own.
#ifndef PERIGEE_PLANET_IMPORT_OUTLINE_H
#define PERIGEE_PLANET_IMPORT_OUTLINE_H

#include "planet/import_raster.h"

struct outline;

// Is a point inside the raster?
bool outline_holds(const raster_grid *grid, double lat, double lon);

// Width wanted of a seam at a point of the border, in metres; 0: nothing lies below, no seam.
typedef double (*outline_width)(void *user, double lat, double lon);

// grids[order[0 .. count)] are one mosaic, borrowed for the call. radius: of the planet, metres.
struct outline *outline_create(const raster_grid *grids, const int *order, int count, double radius,
                               outline_width width, void *user);
void outline_destroy(struct outline **outline);

// Is the border within its width and `margin` metres of any of the tile's samples?
bool outline_meets(const struct outline *outline, tile_id id, double margin);

// Lowers weights (256 x 256) at the samples of a tile to the border's, which is laid farther in by
// `margin` metres, on both sides. Any thread. ERR_MEMORY.
status outline_lower(const struct outline *outline, tile_id id, double margin, float *weights);

#endif
