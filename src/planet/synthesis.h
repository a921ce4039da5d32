// Fractal detail below the data: what one zoom adds to the upsampled zoom before it. It is noise,
// one octave a zoom, times the local relief of the parent, and depends on place and zoom only.
#ifndef PERIGEE_PLANET_SYNTHESIS_H
#define PERIGEE_PLANET_SYNTHESIS_H

#include "planet/planet_writer.h"
#include "planet/region.h"

// Range of the gain that an import measures.
#define SYNTHESIS_GAIN_MIN 0.02
#define SYNTHESIS_GAIN_MAX 0.6

// Gradient noise on the unit sphere of geodetic latitude, mean 0, rms 1, of a cell twice the sample
// spacing of `zoom` in latitude, at `count` points of latitude `lat` whose longitudes have the
// given cosines and sines. C1.
//   error   rms within 0.011 of 1, mean within 0.015 of 0 over a tile
//   (tests/planet/test_synthesis.c) source  Perlin 1985, "An image synthesizer", with hashed
//   lattice gradients
void synthesis_noise(const double *cos_lon, const double *sin_lon, int count, int zoom, double lat,
                     float *out);

// Cosines and sines of a region's columns.
void synthesis_columns(const region *r, double *cos_lon, double *sin_lon);

// Local relief of a region of heights: rms difference of neighbouring samples over 3 x 3 of them,
// in metres a sample of the latitude spacing; 0 exactly where they are equal. `relief`: rows x
// cols; its outermost rows and columns are 0 and not meant.
void synthesis_relief(const region *r, float *relief);

// Relief to amplitude of the residual that the next zoom adds, in place. `gain` is
// planet_meta.synthesis_gain, used at the first zoom below the data and, where it is large, falling
// quickly to a steady one, so that slopes do not grow without end; `data_zoom` the finest zoom of
// all data, `radius` in metres.
void synthesis_amplitude(const region *r, double gain, int data_zoom, double radius, float *relief);

// Measures planet_meta.synthesis_gain on the finest three zooms of heights: rms of what tiles hold
// beyond their upsampled parents, over the rms of the parents' relief, within the range above; 0
// where there is nothing to measure. Reads at most 64 tiles a zoom and their parents.
status planet_measure_gain(struct planet_writer *writer, double *gain);

#endif
