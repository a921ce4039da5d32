// One zoom of the pyramid from the next finer one, by a filter that is circular on the ground
// (Clasen & Hege 2006, 4.3).
//
// A parent sample is the weighted mean of the child samples whose great-circle chord d to it is
// less than FILTER_REACH parent rows; the weight is the child's area times
// exp(-d^2 / (2 (FILTER_SIGMA rows)^2)) less the same at the rim, so that it ends at 0: standard
// deviation 0.42 rows, 80 % passed at a quarter and 40 % at a half cycle a parent sample. Distance
// is taken on the unit sphere of geodetic latitude, so the circle is round to the planet's
// flattening. Tiles of any width, the antimeridian and the poles need no special case: across a
// pole the same sum over whole rows of children holds.
// Measured (tests/planet/test_filter.c): noise of 0.2 to 0.4 cycles a sample comes out with the
// same rms within 0.4 % at the equator, 80 N, on the antimeridian and at the pole.
// Pure. Any thread.
#ifndef PERIGEE_PLANET_FILTER_H
#define PERIGEE_PLANET_FILTER_H

#include <stdbool.h>
#include <stddef.h>

#include "planet/grid.h"

#define FILTER_SIGMA 0.45
#define FILTER_REACH 1.35

// Samples of a stored child: `channels` planes of 256 x 256, NaN where there is no data; NULL when
// it is not stored. *has_nan says whether there is any NaN. Must stay valid until filter_parent
// returns.
typedef const float *(*filter_fetch)(void *user, tile_id child, bool *has_nan);

// Child sample rows beyond the first and last of a tile's children that its filter reaches.
enum { FILTER_MARGIN = 3, FILTER_LINES = 2 * TILE_SIZE + 2 * FILTER_MARGIN };

// Room that grows as needed, and what tiles side by side have in common; zero to begin with. One
// thread at a time.
struct filter_room {
    int zoom, row; // whose taps are there
    struct filter_taps *taps;
    float *weights, *strip, *phases;
    size_t taps_used, taps_size, weights_used, weights_size, held_size;
    size_t first[TILE_SIZE + 1]; // of the taps of each sample row
    struct filter_span {
        int64_t start;
        int count;
    } spans[FILTER_LINES];
};

void filter_room_deinit(struct filter_room *room);

// planes: channels x 256 x 256, the mean of the children that have data, NaN where none has.
// coverage: 256 x 256, the share of the filter's weight that had data, in [0, 1]. The layer of
// `parent` is passed on to `fetch`.
void filter_parent(tile_id parent, int channels, filter_fetch fetch, void *user,
                   struct filter_room *room, float *planes, float *coverage);

#endif
