// The part of a plan for which no work has been queued yet: disjoint rectangles, none of which
// wraps in the texture. Inside the clipmap room. Plain values. Any thread.
#ifndef PERIGEE_CLIPMAP_STRIPS_H
#define PERIGEE_CLIPMAP_STRIPS_H

#include "clipmap/window.h"

typedef struct clip_strips {
    window_rect
        rects[16];    // at most 4 of window_rect_missing, each cut once a direction where it wraps
    int first, count; // those before `first` are used up
} clip_strips;

// target minus held, in the order of window_rect_missing.
clip_strips clip_strips_missing(const window_shape *shape, window_rect target, window_rect held);

// The next strip, of at most max_rows rows; false when there is none.
bool clip_strips_take(clip_strips *strips, int max_rows, window_rect *out);

// Cuts away what lies outside `keep`; true when anything did.
bool clip_strips_clip(clip_strips *strips, window_rect keep);

// How many strips are left to take.
int clip_strips_left(const clip_strips *strips, int max_rows);

#endif
