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

// Every tile takes this long.
void fake_pyramid_slow(struct pyramid *pyramid, int microseconds);

// From now on tiles come only when they are delivered: pyramid_try answers ERR_PENDING before.
void fake_pyramid_late(struct pyramid *pyramid);

// Delivers up to `count` tiles that somebody still wants, by priority. Returns how many.
int fake_pyramid_deliver(struct pyramid *pyramid, int count);

// Tiles on their way, and how many of them nobody wants any more.
int fake_pyramid_under_way(struct pyramid *pyramid, int *stale);

int fake_pyramid_asked(struct pyramid *pyramid); // tiles asked for since creation
int fake_pyramid_held(struct pyramid *pyramid);  // acquired and not released

// The field itself: sample `index` (from longitude -pi, on the tile row's own step) of a sample
// row.
float fake_height(int zoom, int64_t row, int64_t index);
void fake_color(int zoom, int64_t row, int64_t index, uint8_t rgba[4]);

#endif
