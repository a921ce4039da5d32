// A picture of 256 x 256 whole numbers, roughly: JPEG 2000 by its 5/3 wavelet (OpenJPEG), the least
// important bits left out. Integers throughout, so that what is decoded is the same on any machine.
// Any thread.
#ifndef PERIGEE_PLANET_CODEC_WAVELET_H
#define PERIGEE_PLANET_CODEC_WAVELET_H

#include <stdint.h>

#include "planet/codec.h"

// Values beyond this are refused.
enum { WAVELET_LIMIT = 1 << 22 };

// rms: about how far off the decoded values may be, > 0. ERR_UNSUPPORTED when the values are beyond
// the limit.
status wavelet_encode(const int32_t *values, double rms, codec_blob *out);
// ERR_FORMAT, not logged, when it is no such picture.
status wavelet_decode(const void *data, size_t size, int32_t *values);

#endif
