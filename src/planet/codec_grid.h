// Height bodies on a grid of heights: every sample a whole number of quanta, stored without loss.
// A sample is predicted from its neighbours to the west, north and north-west (the median of the
// two and their plane: LOCO-I, Weinberger, Seroussi & Sapiro 2000, eq. 1); what is left is coded by
// the adaptive Rice coder of CCSDS 121.0-B (libaec). Integer arithmetic throughout: any machine
// gives the same bytes and the same samples. Any thread.
#ifndef PERIGEE_PLANET_CODEC_GRID_H
#define PERIGEE_PLANET_CODEC_GRID_H

#include <stdbool.h>
#include <stdint.h>

#include "planet/codec.h"

// A quantum is 2^exponent metres.
enum { GRID_EXPONENT_MIN = -12, GRID_EXPONENT_MAX = 8, GRID_COUNT_LIMIT = 1 << 23 };

// The whole number nearest to |v| < 2^31, ties to the even one: as rintf, but no call.
static inline int32_t grid_nearest(float v)
{
    const double shift = 0x1.8p52; // doubles of this size are the whole numbers
    return (int32_t)((double)v + shift - shift);
}

// Samples to whole quanta, the nearest (ties to even); what has no height gets that of the sample
// before it. False when a height is GRID_COUNT_LIMIT quanta or more, beyond which a float does not
// hold every one. *holes: some sample has no height.
bool grid_round(const float *samples, int exponent, int32_t *counts, bool *holes);

// The heights of counts, exact; limit as above.
void grid_heights(const int32_t *counts, int exponent, float *samples);

// counts: 256 x 256. holes: samples whose places that are not finite are holes; NULL: none.
status grid_encode(const int32_t *counts, int exponent, const float *holes, codec_blob *out);

bool grid_is_body(const void *data, size_t size);
// ERR_FORMAT, not logged, when the body is not of grid_encode's making. Needs grid_is_body.
status grid_decode(const void *data, size_t size, float *samples);

// Which samples are not finite: a bit each, compressed (Zstandard). Freed by the caller.
status holes_encode(const float *samples, codec_blob *out);
// Which of a body's samples are holes. ERR_FORMAT, not logged. Needs grid_is_body.
status grid_holes(const void *data, size_t size, unsigned char *mask);
// The mask of holes as codec_height_gaps has it. ERR_FORMAT, not logged.
status holes_decode_mask(const void *data, size_t size, unsigned char *mask);
// Makes the holes NaN. ERR_FORMAT, not logged.
status holes_decode(const void *data, size_t size, float *samples);

#endif
