// What the files that make an import's tiles share. Private to import_tile.c and import_compose.c.
#ifndef PERIGEE_PLANET_IMPORT_WORKSHOP_H
#define PERIGEE_PLANET_IMPORT_WORKSHOP_H

#include <stdatomic.h>

#include "planet/filter.h"
#include "planet/import_blend.h"
#include "planet/import_outline.h"
#include "planet/import_resample.h"
#include "planet/import_tile.h"

enum { SAMPLES = TILE_SIZE * TILE_SIZE, MAX_CHANNELS = 3, MAX_OPEN = 64 };

struct opened {
    struct raster *raster;
    int input;
    unsigned long used;
};

// Sources of one priority and zoom: together one mosaic, whose inner borders are no seams.
struct mosaic {
    int first, count; // of workshop.order
    int zoom;
    struct outline *outline; // NULL: its border is no wide seam
};

// A picture under construction from the top down: sum of weight times value, the sum of the
// weights, of them those of sources of the tile's own zoom, what is left for what lies below, and
// what borders alone would leave.
struct stack {
    float sum[MAX_CHANNELS * SAMPLES], laid[SAMPLES], own[SAMPLES], left[SAMPLES], through[SAMPLES];
};

struct bench {
    struct workshop *workshop;
    struct opened open[MAX_OPEN];
    unsigned long clock;
    struct resample_room room;
    struct blend_room blend_room;
    struct filter_room filter_room;
    const cached_tile **held;
    int held_count, held_room;
    tile_id parent;        // the tile being made
    float lowest, highest; // of its children's ranges
    status failed;
    struct import_cache *cache;
    struct stack all, mosaic;
    // Planes of the tile, of one source, the coverage by children, the weights of the feather, and
    // of the border alone.
    float tile[MAX_CHANNELS * SAMPLES], source[MAX_CHANNELS * SAMPLES], coverage[SAMPLES],
        weights[SAMPLES], seams[SAMPLES];
    unsigned char pixels[MAX_CHANNELS * SAMPLES];
};

struct workshop {
    workshop_params params;
    int channels;
    int *order; // inputs from the bottom to the top
    struct mosaic *mosaics;
    int mosaic_count;
    struct blend *blend; // NULL: seams are not blended
    struct bench *benches;
    atomic_flag reported; // a read that failed has been logged
};

// Sorts the inputs into mosaics, and lays out their borders.
void compose_plan(struct workshop *w);
void compose_plan_deinit(struct workshop *w);

// The sources of this zoom (and, for pixels, of coarser ones) in b->tile, NaN where there is none.
// *any: a source of this zoom has data here.
status compose_sources(struct workshop *w, struct bench *b, tile_id id, bool *any);

// See workshop_has_border, workshop_zoom_below. What workshop_inside says: where b->all has
// more than the least weight. What workshop_below says, as the stack b->all: what sources of the
// tile's zoom or finer have is laid as the tile's own, of height 0; and the share that these keep.
bool compose_has_border(const struct workshop *w, tile_id id);
int compose_zoom_below(const struct workshop *w, tile_id id);
status compose_outlines(struct workshop *w, struct bench *b, tile_id id);
status compose_below(struct workshop *w, struct bench *b, tile_id id, float *kept);

#endif
