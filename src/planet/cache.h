// Tiles in memory within a bound: counted references, least recently used tiles evicted. All tiles
// have one size, 256 KiB of samples. Any thread; the lock is never held while a tile is made.
#ifndef PERIGEE_PLANET_CACHE_H
#define PERIGEE_PLANET_CACHE_H

#include <stddef.h>

#include "planet/pyramid.h"

struct cache;

enum { CACHE_SAMPLE_BYTES = TILE_SIZE * TILE_SIZE * 4 };

// A tile's samples (float heights or RGBA) as they were made.
struct cache_made {
    float min, max; // of heights
    double until_s; // clock_now_s until which they stand; INFINITY but for a stand-in
};

// Makes a tile's samples. Runs outside the lock, and may acquire tiles of coarser zooms.
typedef status (*cache_make)(void *user, struct want *want, tile_id id, void *samples,
                             struct cache_made *made);

struct cache *cache_create(size_t bytes, cache_make make, void *user);
void cache_destroy(struct cache **cache); // no tile may be held

// Holds the tile until released. A tile that another thread is making is waited for: it is made
// once. Tiles beyond the bound exist only while every other one is held. A tile whose time is over
// is made again, once nobody holds it. The make's own status when it fails, ERR_PENDING included.
status cache_acquire(struct cache *cache, struct want *want, tile_id id, const pyramid_tile **out);

// Holds the tile if it is in memory and made; NULL otherwise. Never waits for a tile.
const pyramid_tile *cache_peek(struct cache *cache, tile_id id);

void cache_release(struct cache *cache, const pyramid_tile **tile);

// bytes: of all tiles now in memory; hits: acquisitions that made nothing.
void cache_counters(struct cache *cache, uint64_t *hits, uint64_t *bytes);

#endif
