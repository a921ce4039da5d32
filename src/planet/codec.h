// Tile bodies: heights on a grid of whole quanta (codec_grid.h) or, every bit of their floats, as
// OpenEXR (one float channel "Z", ZIP); colour and night as JPEG; any as 8 bytes when they have one
// value throughout (codec_uniform.h). Any thread; each call owns its
// decoder. Bodies come from files: sizes are checked before they are used, nothing of them is
// trusted.
#ifndef PERIGEE_PLANET_CODEC_H
#define PERIGEE_PLANET_CODEC_H

#include <stddef.h>

#include "base/status.h"
#include "planet/grid.h"

// An encoded tile body on the heap; free with codec_blob_deinit.
typedef struct codec_blob {
    unsigned char *data;
    size_t size;
} codec_blob;

void codec_blob_deinit(codec_blob *blob);

// samples: 256 x 256, row-major. Lossless; NaN kept, infinities become NaN.
status codec_height_encode(const float *samples, codec_blob *out);
// The same of samples rounded to multiples of a quantum of 2^exponent metres, in place: each is at
// most half a quantum off. Heights that no such grid holds (2^23 quanta and more) are left as they
// are and stored as by codec_height_encode.
status codec_height_encode_grid(float *samples, int exponent, codec_blob *out);
// Either of them. ERR_FORMAT (not logged: the caller knows which tile) when the body is not such an
// image.
status codec_height_decode(const void *data, size_t size, float *samples);

// Where such a body has no heights: bit (i % 8) of mask[i / 8], i row-major. As
// codec_height_decode, but a tenth of the work where it can be.
status codec_height_gaps(const void *data, size_t size, unsigned char *mask);

// As codec_height_decode, also of bodies that hold what a tile adds to its parent
// (codec_bounded.h). parent: gives the heights of the tile above as they are stored, ERR_NOT_FOUND
// when it is not; what else it returns is passed on. It is called for such bodies only.
typedef status (*codec_parent)(void *user, tile_id id, float *heights);
status codec_height_decode_tile(tile_id id, const void *data, size_t size, codec_parent parent,
                                void *user, float *samples);

// channels: 3 (colour, RGB) or 1 (night). quality 1-100.
status codec_pixels_encode(const unsigned char *pixels, int channels, int quality, codec_blob *out);
// The same as JPEG whatever they are: for readers that know nothing else.
status codec_pixels_encode_jpeg(const unsigned char *pixels, int channels, int quality,
                                codec_blob *out);
status codec_pixels_decode(const void *data, size_t size, int channels, unsigned char *pixels);

#endif
