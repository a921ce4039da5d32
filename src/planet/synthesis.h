// Detail below the data: what one zoom adds to the upsampled zoom before it. One octave a zoom, as
// strong as the parent's own relief says, depending on place and zoom only. Plain: noise without
// direction. Eroded: ridges and gullies sharpen, and stripes run down the slopes of the parent,
// which has the gullies of all zooms before, so that they branch. The arithmetic of one sample is
// shaders/shared/synthesis.glsl.
#ifndef PERIGEE_PLANET_SYNTHESIS_H
#define PERIGEE_PLANET_SYNTHESIS_H

#include "planet/planet_writer.h"
#include "planet/region.h"

// Range of the gain that an import measures.
#define SYNTHESIS_GAIN_MIN 0.02
#define SYNTHESIS_GAIN_MAX 0.6

enum synthesis { SYNTHESIS_NONE, SYNTHESIS_ERODED, SYNTHESIS_PLAIN };

// The noise's lattice along a row of one latitude. A place in cells is (cos, sin of the longitude)
// times `scale` plus `shift`; hz: hash of the cell along the axis, z: place in it.
typedef struct synthesis_lattice {
    double scale, shift[2];
    uint32_t hz;
    float z;
} synthesis_lattice;

// kind: eroded ground has the stripes' lattice, plain ground the gradient noise's.
synthesis_lattice synthesis_lattice_of(enum synthesis kind, int zoom, double lat);

// From relief to amplitude, for what is made from parents of one zoom: synthesis_tempered() with
// `steep` and `least`, m a sample, times `share`. `gain` is planet_meta.synthesis_gain, used at the
// first zoom below the data and falling quickly to a steady one; `data_zoom` the finest zoom of all
// data; radius in metres.
typedef struct synthesis_scale {
    float steep, least, share;
} synthesis_scale;

synthesis_scale synthesis_scale_of(int parent_zoom, double gain, int data_zoom, double radius);

// Shape of a row of samples: how far a column's length on the ground is that of a row; and of
// squared differences between columns the weight beside those between rows, less where columns
// crowd together near a pole and rounding would count as relief, and the factor that brings them to
// the latitude spacing, with the weight in it.
typedef struct synthesis_shape {
    float shape, weight, factor;
} synthesis_shape;

synthesis_shape synthesis_shape_of(int zoom, int coalesce, int64_t row);

// What the noise needs for all rows of a region: cosines and sines of its columns.
typedef struct synthesis_columns {
    double cos_lon[REGION_MAX_COLS], sin_lon[REGION_MAX_COLS];
} synthesis_columns;

void synthesis_columns_of(const region *r, synthesis_columns *out);

// Gradient noise on the unit sphere of geodetic latitude, mean 0, rms 1, of a cell twice the sample
// spacing of `zoom` in latitude, at `count` points of latitude `lat`. C1.
//   error   rms within 0.011 of 1, mean within 0.015 of 0 over a tile
//   (tests/planet/test_synthesis.c)
void synthesis_noise(const synthesis_columns *columns, int count, int zoom, double lat, float *out);

// Stripes of a cell four times the sample spacing. east, north: components of the wave vector,
// cycles a cell, as synthesis_ground has them.
void synthesis_stripes(const synthesis_columns *columns, int count, int zoom, double lat,
                       const float *east, const float *north, float *out);

// How the parent's ground shapes the residual: fields at the parent's samples, rows x cols, whose
// outermost rows and columns are 0 and not meant.
typedef struct synthesis_ground {
    float *amplitude;    // rms of the residual, m; 0 exactly where the ground is level
    float *bend;         // mean of the neighbours less the sample, m
    float *east, *north; // wave vector of the stripes, cycles a cell, along the contour line
} synthesis_ground;

// Arguments as above. ERR_MEMORY. Plain noise has no bend and no wave vector: NULL.
status synthesis_ground_create(const region *parent, enum synthesis kind, double gain,
                               int data_zoom, double radius, synthesis_ground *out);
void synthesis_ground_destroy(synthesis_ground *ground);

// Adds the residual to a row of the child, upsampled; `share`: of its amplitude, at each sample,
// NULL: all of it. Samples that are `flat` or NaN stay as they are; no other becomes lower than the
// lowest of the parent's 4 x 4 samples around it.
void synthesis_add_row(const synthesis_ground *ground, const synthesis_columns *columns,
                       const region *parent, const region *child, int row, const bool *flat,
                       const float *share, float *out);

// Local relief of a region of heights: rms difference of neighbouring samples over 3 x 3 of them,
// in metres a sample of the latitude spacing; 0 exactly where they are equal.
void synthesis_relief(const region *r, float *relief);

// Relief as far as the residual follows it, in place: what the gain is a share of.
void synthesis_temper(const region *r, double radius, float *relief);

// Measures planet_meta.synthesis_gain on the finest three zooms of heights: rms of what tiles hold
// beyond their upsampled parents, over the rms of the parents' tempered relief, within the range
// above; 0 where there is nothing to measure. Reads at most 64 tiles a zoom and their parents.
// radius: of the body, metres. threads: that read tiles, 0: one for each processor; *gain does not
// depend on them. kept: by a worker, gives the heights of a tile as they are stored, so that it is
// not decoded, or false; NULL: there are none.
status planet_measure_gain(struct planet_writer *writer, double radius, int threads,
                           bool (*kept)(void *user, tile_id id, float *heights), void *user,
                           double *gain);

#endif
