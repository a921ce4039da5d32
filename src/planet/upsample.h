// From the samples of one zoom to those of the next: the four-point filter (-9, 111, 29, -3) / 128,
// which is the Catmull-Rom spline a quarter sample off, where cell centres of the finer zoom lie.
// Reproduces quadratics exactly; C1. Pure. Any thread.
#ifndef PERIGEE_PLANET_UPSAMPLE_H
#define PERIGEE_PLANET_UPSAMPLE_H

#include <stdbool.h>

#include "planet/region.h"

// One row to twice the density: out[k], k in [0, cols), is fine column k + odd, where fine columns
// 0 and 1 lie a quarter sample west and east of the centre of src[2]. src: (cols + odd + 1) / 2 + 4
// samples.
void upsample_row(const float *src, int channels, int odd, int cols, float *out);

// Row `row` of `child` (counted from its first), all channels, from region_parent(child). A child
// sample of one channel that lies among four equal parent samples (or, where the grids share their
// longitudes, on the side of four) has exactly their value, so that flat water stays flat up to the
// shore; flat[i] says where.
void upsample_child_row(const region *parent, const region *child, int row, float *out, bool *flat);

// The same row of a field of one channel given at the parent's samples, by bilinear interpolation.
void upsample_linear_row(const region *parent, const float *field, const region *child, int row,
                         float *out);

// The lowest of the 4 x 4 parent samples around each sample of the row (4 x 3 where the grids share
// their longitudes); NaN is passed over.
void upsample_least_row(const region *parent, const region *child, int row, float *out);

#endif
