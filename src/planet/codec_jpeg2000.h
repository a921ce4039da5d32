// Pictures of 256 x 256 whole numbers as JPEG 2000 by its 5/3 wavelet (OpenJPEG): integers
// throughout, so that what is decoded is the same on any machine. Any thread.
#ifndef PERIGEE_PLANET_CODEC_JPEG2000_H
#define PERIGEE_PLANET_CODEC_JPEG2000_H

#include <stdint.h>

#include "planet/codec.h"

// ERR_FORMAT, not logged, when it is no such picture.
status jpeg2000_decode(const void *data, size_t size, int32_t *values);

#endif
