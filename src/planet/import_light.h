// sRGB transfer function for 8-bit samples: pixels are filtered in linear light. Any thread.
#ifndef PERIGEE_PLANET_IMPORT_LIGHT_H
#define PERIGEE_PLANET_IMPORT_LIGHT_H

#include <stddef.h>

// In place: encoded values in [0, 255] (between codes: linear between their lights; outside:
// clamped) to linear light in [0, 1]. NaN stays.
void light_decode(float *samples, size_t count);

// The sRGB code nearest to a linear light; NaN gives 0. light_encode(light_decode(c)) = c for every
// code c.
unsigned char light_encode(float linear);

#endif
