// What a tile's parent says about it: the parent doubled by the four-point filter (upsample.h).
// Floats whose order of operations is fixed. Any thread.
#ifndef PERIGEE_PLANET_CODEC_PREDICT_H
#define PERIGEE_PLANET_CODEC_PREDICT_H

#include <stdint.h>

#include "planet/grid.h"

// predicted: 256 x 256 heights, all finite. parent: 256 x 256, NaN where there is no data; NULL:
// there is none, and all is 0. Beyond the parent's border it goes on along straight lines.
void predict_tile(tile_id id, const float *parent, float *predicted);

// The prediction in whole quanta of 2^exponent metres, within the grid's limit (codec_grid.h).
void predict_count(const float *predicted, int exponent, int32_t *counts);

// The XXH32 of 256 x 256 counts, the same whatever the machine's order of bytes.
uint32_t predict_checksum(const int32_t *counts);

#endif
