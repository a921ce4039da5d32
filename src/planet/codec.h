// Tile bodies: heights as OpenEXR (one float channel "Z", ZIP), colour and night as JPEG, either as
// 8 bytes when they have one value throughout (codec_uniform.h). Any thread; each call owns its
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
// ERR_FORMAT (not logged: the caller knows which tile) when the body is not such an image.
status codec_height_decode(const void *data, size_t size, float *samples);

// channels: 3 (colour, RGB) or 1 (night). quality 1-100.
status codec_pixels_encode(const unsigned char *pixels, int channels, int quality, codec_blob *out);
status codec_pixels_decode(const void *data, size_t size, int channels, unsigned char *pixels);

#endif
