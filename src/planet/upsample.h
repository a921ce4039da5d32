// From a patch of one zoom to a tile of the next: the four-point filter (-9, 111, 29, -3) / 128,
// which is the Catmull-Rom spline a quarter sample off, where cell centres of the finer zoom lie.
// Reproduces quadratics exactly; C1. Pure. Any thread.
#ifndef PERIGEE_PLANET_UPSAMPLE_H
#define PERIGEE_PLANET_UPSAMPLE_H

#include <stdbool.h>

#include "planet/patch.h"

// One row to twice the density: out[k], k in [0, cols), is fine column k + odd, where fine columns
// 0 and 1 lie a quarter sample west and east of the centre of src[2]. src: cols / 2 + 5 samples.
void upsample_row(const float *src, int channels, int odd, int cols, float *out);

// Heights of row `row` of the child. A child sample within four equal parent samples (two, where
// the grids share their longitudes) has exactly their height, so that flat water stays flat up to
// the shore; flat[i] says where, if flat is not NULL.
void upsample_height_row(const struct patch *p, int row, float out[TILE_SIZE],
                         bool flat[TILE_SIZE]);

// One row of a field given at the patch's samples, by bilinear interpolation.
void upsample_linear_row(const struct patch *p, const float *field, int row, float out[TILE_SIZE]);

// RGBA, rounded and held within [0, 255].
void upsample_rgba(const struct patch *p, uint8_t *out);

#endif
