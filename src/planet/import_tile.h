// One tile of an import: the pyramid of what is finer, the sources of its own zoom, encoded.
// The workshop is shared; each worker index uses its own raster handles and room.
//
// Sources are ordered by priority, then zoom, then as given; those of one priority and zoom are one
// mosaic. A mosaic's edges are blended into what lies below over the feather's width
// (import_blend.h), an input's into the other inputs of its mosaic where they overlap; edges of
// holes in heights only into sources of the same zoom, as the join knows the rest
// (import_border.h).
//
// Heights: a tile holds the filtered children where they are, elsewhere the sources of exactly this
// zoom; coarser sources come in at their own zoom, so what they alone cover is NaN here, and a
// coarser source that lies on top leaves NaN where it has data. Where children cover a sample in
// part they are mixed with this zoom's sources. Colour and night have no NaN in the file: the
// coarser sources are painted in, and where none has data it is black.
#ifndef PERIGEE_PLANET_IMPORT_TILE_H
#define PERIGEE_PLANET_IMPORT_TILE_H

#include "planet/codec.h"
#include "planet/import_base.h"
#include "planet/import_cache.h"
#include "planet/import_plan.h"

struct workshop;

typedef struct workshop_params {
    const import_input *inputs; // of one layer, borrowed
    const raster_grid *grids;   // of the inputs, borrowed
    int count, workers;
    geo_ellipsoid ellipsoid;
    plan_bounds bounds;
    int feather;      // width of blended edges, in rows of the upper mosaic; 0: none
    double feather_m; // width of the seams at borders, as in import_params
    double quantum;   // of heights, as in quantum.h
    struct import_cache *cache;
    struct import_base *base; // a planet that lies below all inputs, borrowed; NULL: none
} workshop_params;

struct workshop *workshop_create(const workshop_params *params);
void workshop_destroy(struct workshop **workshop);

// A tile made. body: empty (size 0) when no source has data in the tile; freed by the caller. min,
// max: of the heights of the tile and of all its descendants, 0 for pixels. uniform: one value
// throughout.
typedef struct made_tile {
    codec_blob body;
    float min, max;
    bool uniform;
} made_tile;

status workshop_make(struct workshop *workshop, int worker, tile_id id, made_tile *out);

// Of heights. Do borders of sources of this zoom or finer ones run through the tile, with coarser
// data below? Cheap; a few tiles beside a border count too.
bool workshop_has_border(const struct workshop *workshop, tile_id id);

// The finest zoom before the tile's that has data there; -1: none. Cheap.
int workshop_zoom_below(const struct workshop *workshop, tile_id id);

// Where the tile lies well inside the outlines of sources of its zoom or finer ones: bit (i % 8) of
// mask[i / 8].
status workshop_inside(struct workshop *workshop, int worker, tile_id id, unsigned char *mask);

// What coarser sources have given to a tile with some below it: of each sample the share, 0 where
// there is none, and their height. keep: the part of the rest that may stay; 0 where a tile of the
// next zoom, beyond the border, would be made of it.
status workshop_below(struct workshop *workshop, int worker, tile_id id, float *shares,
                      float *heights, float *keep);

// Width of blended edges in rows; 0: none.
int workshop_feather(const struct workshop *workshop);
// Of the finest of the sources.
int workshop_finest(const struct workshop *workshop);

// What the sources alone give to a tile, whatever is finer; NaN where there is nothing.
status workshop_look(struct workshop *workshop, int worker, tile_id id, float *planes, bool *any);

// A body as workshop_make gives. Heights are rounded to their grid.
status workshop_encode(struct workshop *workshop, int worker, tile_id id, float *planes,
                       codec_blob *out);

#endif
