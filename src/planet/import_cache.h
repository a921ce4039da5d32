// Tiles of the file being written, for the filter: a bounded cache of what was just made and of
// what is decoded, each tile by one thread at a time. Any thread.
#ifndef PERIGEE_PLANET_IMPORT_CACHE_H
#define PERIGEE_PLANET_IMPORT_CACHE_H

#include <stdbool.h>

#include "planet/import_store.h"

struct import_cache;

// One tile held: `channels` float planes (heights; pixels in linear light), NULL when it is not
// stored.
typedef struct cached_tile {
    tile_id id;
    float *planes;
    bool has_nan;
    float min, max; // of the heights of the tile and of its descendants
} cached_tile;

// `bytes`: bound of what is kept beyond the tiles that are held.
struct import_cache *import_cache_create(struct import_store *store, size_t bytes);
void import_cache_destroy(struct import_cache **cache);

// ERR_NOT_FOUND does not occur: a tile that is not stored has no planes. Errors of decoding are
// logged.
status import_cache_acquire(struct import_cache *cache, tile_id id, const cached_tile **out);
void import_cache_release(struct import_cache *cache, const cached_tile *tile);

// The heights of a tile that is there; false when it is not.
bool import_cache_copy(struct import_cache *cache, tile_id id, float *heights);
// The tile, which nobody holds, is another from now on.
void import_cache_drop(struct import_cache *cache, tile_id id);

// Keeps a tile of heights that is about to be stored, as it will be decoded.
void import_cache_add(struct import_cache *cache, tile_id id, const float *heights, float min,
                      float max);

#endif
