// Heights of a window as what they add to the next coarser window's (Asirvatham & Hoppe 2005,
// 2.4.1-2): that one's samples, doubled by the four-point filter, are the prediction. All in whole
// quanta, so that who adds gets the bits of who subtracted. Pure. Any thread.
#ifndef PERIGEE_CLIPMAP_RESIDUAL_H
#define PERIGEE_CLIPMAP_RESIDUAL_H

#include <stddef.h>

#include "clipmap/window.h"

// What heights of a zoom are whole multiples of, m: 1/2400 of the samples' distance on the Earth,
// at least 2^-10, of which floats hold whole multiples up to 16 km. A power of two.
float clip_residual_quantum(int zoom);

// Rounds heights (m) to whole quanta.
void clip_residual_round(int zoom, float *heights, size_t count);

// Residuals of `rect`'s heights, in quanta, over those of window_rect_parents(rect), which are of
// the zoom before and of columns twice as wide; both rounded. False when one does not fit.
bool clip_residual_find(int zoom, window_rect rect, const float *heights, const float *parents,
                        int16_t *out);

#endif
