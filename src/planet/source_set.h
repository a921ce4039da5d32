// The sources that somebody named, opened by what they are, with the network and the disk cache
// that the remote ones share, and the pyramid over them.
#ifndef PERIGEE_PLANET_SOURCE_SET_H
#define PERIGEE_PLANET_SOURCE_SET_H

#include "planet/fetch.h"
#include "planet/plane_map.h"
#include "planet/pyramid.h"

struct source_set;

typedef struct source_set_params {
    bool flat; // the map as a plane; of a raster in a projected system, if the first source is one
    const char *disk_path; // of the cache of tiles; NULL: none
    uint64_t disk_bytes;   // 0: 1 GiB
    fetch_params fetch;    // `disk` is the set's
} source_set_params;

struct source_set *source_set_create(const source_set_params *params);
void source_set_destroy(struct source_set **set); // after its pyramid

// Adds one on top of the others. `name`: a planet file, a raster, a TileJSON by path or URL, or a
// URL template with {z} {x} {y}. `layer`: only this one of it, and what a raster or template is;
// LAYER_COUNT: all that it has. opacity in [0, 1]. Nothing is contacted but the URL of a TileJSON.
// Errors as of the parts, logged; ERR_NOT_FOUND and ERR_IO when the TileJSON cannot be had,
// ERR_ARGUMENT past PYRAMID_MAX_LAYERS or without the layer.
status source_set_add(struct source_set *set, const char *name, enum tile_layer layer,
                      double opacity);

// At least one source must have been added. params->flat is the set's.
status source_set_pyramid(struct source_set *set, const pyramid_params *params,
                          struct pyramid **out);

// The map that the sources lie on, when it is a projected raster's; else NULL.
struct plane_map *source_set_map(const struct source_set *set);

// NULL when none is remote.
struct fetcher *source_set_fetcher(const struct source_set *set);
struct disk_cache *source_set_disk(const struct source_set *set);

#endif
