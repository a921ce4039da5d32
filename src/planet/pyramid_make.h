// What the making of one source's tiles (pyramid_make.c) and the mixing of several (pyramid.c)
// share. Inside the planet room.
#ifndef PERIGEE_PLANET_PYRAMID_MAKE_H
#define PERIGEE_PLANET_PYRAMID_MAKE_H

#include <stdatomic.h>

#include "planet/cache.h"
#include "planet/import_blend.h"
#include "planet/synthesis.h"

enum { PYRAMID_SAMPLES = TILE_SIZE * TILE_SIZE };

struct pyramid {
    struct source *source;
    bool owned; // the source
    bool over;  // lies on others: has no ground of its own, and coverage where they have light
    enum synthesis synthesis;
    struct planet_meta own, meta; // of this source; of the whole stack
    struct cache *cache;
    struct blend *edges; // of stored samples
    atomic_uint_fast64_t decoded, synthesised, upsampled;
    struct pyramid **overs; // what lies on this one, lowest first
    float *opacity;         // of overs
    int over_count;
    struct cache *mixed;  // all of them together; NULL without overs
    atomic_bool given_up; // nobody waits any more
};

// One tile on its way to being made.
struct making {
    struct pyramid *pyramid;
    struct want *want;
    double until_s;
};

// May the tile be stored? A layer that the stack leaves out has no zoom.
bool pyramid_may_hold(const struct pyramid *p, tile_id id);

// Reads a stored tile. *found is false when it is not stored or cannot be read.
status pyramid_read_stored(struct making *m, tile_id id, void *out, bool *found);

// Where stored heights end, what is shown beyond them begins in what the zoom before says: there
// the residual comes in over so many samples, zoom by zoom, as far on the ground as each is coarse.
// Else every zoom between that of the data and the coarser one beyond would begin with a step
// (42 m between samples of 150 m, tests/planet/test_import_border.c).
enum { PYRAMID_FADE_ROWS = 8, PYRAMID_FADE_MASKS = 512 };

// Does the rectangle lie so near to a tile of heights that may be stored?
bool pyramid_beside_stored(const struct pyramid *p, const region *r);

// The share of its residual that each sample has, rows x cols of `r`.
status pyramid_fade(struct making *m, const region *r, float *share);

// Makes a tile of the pyramid's own source; `user` is the pyramid. A cache_make.
status pyramid_make_tile(void *user, struct want *want, tile_id id, void *samples,
                         struct cache_made *made);

// Least and greatest of the heights that are there; 0 when none is.
void pyramid_measure_range(const float *heights, struct cache_made *made);

#endif
