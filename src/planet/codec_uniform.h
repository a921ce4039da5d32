// Bodies of tiles that have one value throughout: 8 bytes. "PGU", the channels as a digit ('0':
// heights), then the height as a little-endian float or the pixel's bytes, filled up with zeros.
#ifndef PERIGEE_PLANET_CODEC_UNIFORM_H
#define PERIGEE_PLANET_CODEC_UNIFORM_H

#include <stdbool.h>

#include "planet/codec.h"

// False, and nothing done, when the samples differ or are not finite (or memory is out: the tile is
// then no smaller than others).
bool uniform_encode_height(const float *samples, codec_blob *out);
bool uniform_encode_pixels(const unsigned char *pixels, int channels, codec_blob *out);

// False, and nothing done, when the body is none of these.
bool uniform_decode_height(const void *data, size_t size, float *samples);
bool uniform_decode_pixels(const void *data, size_t size, int channels, unsigned char *pixels);

#endif
