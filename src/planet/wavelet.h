// The 9/7 wavelet of Cohen, Daubechies & Feauveau over 256 x 256 samples, by the lifting steps of
// Daubechies & Sweldens 1998 (7.7), five levels, mirrored at the borders. Floats whose order of
// operations is fixed: any machine with IEEE arithmetic gives the same bits. Pure. Any thread.
#ifndef PERIGEE_PLANET_WAVELET_H
#define PERIGEE_PLANET_WAVELET_H

#include "planet/grid.h"

enum { WAVELET_LEVELS = 5, WAVELET_BANDS = 3 * WAVELET_LEVELS + 1 };

// One band of coefficients: n x n of them from (row, col) on, inside the 256 x 256. level: 1 is the
// finest. tall, wide: of the differences between rows, between columns; neither: what is left of
// the samples themselves.
// norm: what a coefficient must be multiplied with for its square to be its part of the sum of the
// squares of all samples (nearly: the wavelet is not quite orthogonal).
struct wavelet_band {
    int row, col, n, level, tall, wide;
    float norm;
};

// The bands, coarse to fine; a band comes after the coarser one of its kind, at half its place.
void wavelet_bands(struct wavelet_band bands[WAVELET_BANDS]);

// samples: 256 x 256, row-major, to coefficients in place, and back. room: 256 x 256 of scratch.
void wavelet_forward(float *samples, float *room);
void wavelet_inverse(float *samples, float *room);

#endif
