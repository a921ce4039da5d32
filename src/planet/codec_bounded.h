// Height bodies with a bound on the error: what a tile adds to its parent (Losasso & Hoppe 2004,
// section 7). The parent, as it is decoded, is doubled by the four-point filter (codec_predict.h);
// the wavelet coefficients of the difference to that are coded roughly (codec_bands.h), and where
// what comes out is farther off than the bound, it is corrected. The order of all operations on
// floats is fixed and everything is rounded to a grid of heights: any machine gives the same
// samples, and a checksum of them stands in the body. Any thread.
#ifndef PERIGEE_PLANET_CODEC_BOUNDED_H
#define PERIGEE_PLANET_CODEC_BOUNDED_H

#include <stdbool.h>

#include "planet/codec.h"

// Bounds that there are codes for, in metres.
#define BOUNDED_MIN_ERROR 0x1p-8
#define BOUNDED_MAX_ERROR 4096.0

// The grid on which heights stand under a bound: a quantum of 2^this metres, between 1/32 and 1/16
// of the bound.
int bounded_exponent(double max_error);

// samples: on the grid of the bound. predicted: of predict_tile. A body of the kind that is
// smallest: this one, or one of codec_grid.h or codec_uniform.h. decoded: what it decodes to, each
// within max_error - 2^exponent / 2 of its sample; holes stay holes. ERR_MEMORY.
status bounded_encode(const float *samples, const float *predicted, double max_error,
                      codec_blob *out, float *decoded);

bool bounded_is_body(const void *data, size_t size);
// ERR_FORMAT, not logged, when it is no such body or decodes to other samples than it was made of.
// Needs bounded_is_body.
status bounded_decode(const void *data, size_t size, const float *predicted, float *samples);

#endif
