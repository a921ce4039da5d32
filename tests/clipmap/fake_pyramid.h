// A pyramid without files: every tile is one of a few bodies of noise, chosen by a hash of its
// place. Heights are whole numbers below 4096, so that means and mixtures by powers of two are
// exact in float. Any thread.
#ifndef PERIGEE_TESTS_FAKE_PYRAMID_H
#define PERIGEE_TESTS_FAKE_PYRAMID_H

#include "planet/pyramid.h"

struct pyramid *fake_pyramid_create(void);
void fake_pyramid_destroy(struct pyramid **pyramid);

// The next `count` tiles asked for are refused with ERR_MEMORY.
void fake_pyramid_refuse(struct pyramid *pyramid, int count);

// From now on tiles are stand-ins, of other bodies, whose time is over at once; or no longer.
void fake_pyramid_stand_in(struct pyramid *pyramid, bool stand_in);

// Every tile takes this long.
void fake_pyramid_slow(struct pyramid *pyramid, int microseconds);

// From now on tiles come only when they are delivered: pyramid_try answers ERR_PENDING before.
void fake_pyramid_late(struct pyramid *pyramid);

// Delivers up to `count` tiles that somebody still wants, by priority. Returns how many.
int fake_pyramid_deliver(struct pyramid *pyramid, int count);

// Tiles on their way, and how many of them nobody wants any more.
int fake_pyramid_under_way(struct pyramid *pyramid, int *stale);

// A slow line: `slots` tiles in flight at once, each for so many ticks; the most wanted ones first
// and stopped when nobody wants them, or in the order of asking and to the end.
struct fake_line {
    int slots, ticks;
    bool first_come;
};

enum { FAKE_FLYING = 64 };

struct fake_traffic {
    int came, in_vain; // since it was zeroed; in vain: nobody wanted them any more
    int stopped;
    int flying_count; // now
    tile_id flying[FAKE_FLYING];
};

// After fake_pyramid_late: a tick of the line goes by.
void fake_pyramid_tick(struct pyramid *pyramid, const struct fake_line *line,
                       struct fake_traffic *traffic);

int fake_pyramid_asked(struct pyramid *pyramid); // tiles asked for since creation
int fake_pyramid_held(struct pyramid *pyramid);  // acquired and not released

// The field itself: sample `index` (from longitude -pi, on the tile row's own step) of a sample
// row.
float fake_height(int zoom, int64_t row, int64_t index);
void fake_color(int zoom, int64_t row, int64_t index, uint8_t rgba[4]);

#endif
