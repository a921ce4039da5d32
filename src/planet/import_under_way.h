// One import under way, and what it does by layers. Private to import.c and import_estimate.c.
#ifndef PERIGEE_PLANET_IMPORT_UNDER_WAY_H
#define PERIGEE_PLANET_IMPORT_UNDER_WAY_H

#include "planet/import.h"
#include "planet/import_crew.h"
#include "planet/import_inputs.h"

struct import {
    const import_params *params;
    const import_input *inputs;
    raster_grid *grids;
    int count;
    plan_bounds bounds;
    geo_ellipsoid ellipsoid;
    struct import_base *base; // the planet that is added to; NULL: none
    struct import_store *store;
    struct import_cache *kept; // heights made, for the join
    struct crew *crew;
    double began_s;
    uint64_t tiles, samples;
    double quantum;   // of the heights in the parts
    double max_error; // of those in the finished file; 0: none
};

// The settings checked, the bounds read, the grids of all inputs found. The caller closes `base`
// and frees `grids`, also after a failure.
status import_prepare(struct import *im);

// The inputs of one layer.
struct layer {
    enum tile_layer layer;
    import_input *inputs;
    raster_grid *grids;
    int count, max_zoom;
};

void layer_init(const struct import *im, enum tile_layer layer, struct layer *out);
void layer_deinit(struct layer *l);

// The tiles of one zoom, and how many there are.
struct plan_walk *layer_walk(const struct import *im, const struct layer *l, int zoom);
uint64_t layer_count(const struct import *im, const struct layer *l, int zoom);

struct workshop *layer_workshop(const struct import *im, const struct layer *l, int workers,
                                struct import_cache *cache);

#endif
