// What of a level's window is sampled: all inside what is valid, grown towards it and faded in, so
// that nothing appears at once. Main only.
#ifndef PERIGEE_RENDER_SHOWN_H
#define PERIGEE_RENDER_SHOWN_H

#include "clipmap/clipmap.h"

struct shown {
    double row0, row1, col0, col1;
    int zoom, share;
    float fade;
};

bool shown_empty(const struct shown *s);
// All that is valid, for good.
bool shown_whole(const struct shown *s, const clipmap_level *state);

// Moves on by dt_s, to the end when it is negative. fade_s: time in which a level filled from
// nothing fades in; 0: at once. True when it changed.
bool shown_advance(struct shown *s, const clipmap_level *state, const window_shape *shape,
                   double fade_s, double dt_s);

// The level's samples have been recast (clipmap_set_recast): what was shown of them stays.
void shown_recast(struct shown *s, const window_shape *shape, const window *from, const window *to,
                  window_rect valid);

#endif
