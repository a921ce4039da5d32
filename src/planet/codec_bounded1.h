// Bodies within a bound as they were first made: a JPEG 2000 picture and corrections. For reading.
// Any thread.
#ifndef PERIGEE_PLANET_CODEC_BOUNDED1_H
#define PERIGEE_PLANET_CODEC_BOUNDED1_H

#include <stdbool.h>

#include "planet/codec.h"

bool bounded1_is_body(const void *data, size_t size);
// As bounded_decode. Needs bounded1_is_body.
status bounded1_decode(const void *data, size_t size, const float *predicted, float *samples);

#endif
