// What changes from one picture to the next beyond what the truth itself changes, pixel by pixel:
// where a picture's own difference from the truth stays the same, nothing flickers, however far it
// is. Of pictures A at two moments and the truth B of each,
//
//     moved  = |e2 - e1|                    e: geometric error of A against B (compare.h), px
//     colour = max over R, G, B of |(A2 - B2) - (A1 - B1)|  of sRGB-encoded light, in 1/255
//
// at pixels that are plain ground, without silhouettes, at both moments. Without a truth B is
// nothing: A's own change.
#ifndef PERIGEE_REFERENCE_FLICKER_H
#define PERIGEE_REFERENCE_FLICKER_H

#include "reference/compare.h"

// One moment, top row first. Colour: linear light, measured where all of it is there at both
// moments; `true_*` NULL: no truth.
typedef struct flicker_moment {
    const float *geometric_px; // e, as compare_maps has it; NULL: 0 everywhere
    const unsigned char *kind; // enum compare_kind; NULL: plain ground wherever e is not NaN
    const float *r, *g, *b;    // of A
    const float *true_r, *true_g, *true_b; // of B
} flicker_moment;

typedef struct flicker_result {
    compare_stat moved_px, color; // color.count is 0 without colours
} flicker_result;

// ERR_MEMORY, logged. Any thread.
status flicker_measure(const flicker_moment *before, const flicker_moment *after, int width,
                       int height, flicker_result *out);

#endif
