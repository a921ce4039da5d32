// What the making of one source's tiles (pyramid_make.c) and the mixing of several (pyramid.c)
// share. Inside the planet room.
#ifndef PERIGEE_PLANET_PYRAMID_MAKE_H
#define PERIGEE_PLANET_PYRAMID_MAKE_H

#include <stdatomic.h>

#include "planet/cache.h"
#include "planet/synthesis.h"

enum { PYRAMID_SAMPLES = TILE_SIZE * TILE_SIZE };

struct pyramid {
    struct source *source;
    bool owned; // the source
    bool over;  // lies on others: has no ground of its own, and coverage where they have light
    enum synthesis synthesis;
    struct planet_meta own, meta; // of this source; of the whole stack
    struct cache *cache;
    atomic_uint_fast64_t decoded, synthesised, upsampled;
    struct pyramid **overs; // what lies on this one, lowest first
    float *opacity;         // of overs
    int over_count;
    struct cache *mixed;  // all of them together; NULL without overs
    atomic_bool given_up; // nobody waits any more
};

// Makes a tile of the pyramid's own source; `user` is the pyramid. A cache_make.
status pyramid_make_tile(void *user, struct want *want, tile_id id, void *samples,
                         struct cache_made *made);

// Least and greatest of the heights that are there; 0 when none is.
void pyramid_measure_range(const float *heights, struct cache_made *made);

#endif
