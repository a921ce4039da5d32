// Deterministic fractal detail below the data, in the terrain's own statistics (Losasso & Hoppe
// 2004, section 8): what one zoom adds to its upsampled parent is band-limited noise, its strength
// a share (`gain`) of the parent's local relief. The noise is a function of place and zoom alone
// (gradient noise on the unit sphere), so neighbouring tiles agree and the antimeridian and the
// poles are ordinary ground; flat water has no relief and stays flat. Any thread.
#ifndef PERIGEE_PLANET_SYNTHESIS_H
#define PERIGEE_PLANET_SYNTHESIS_H

#include "planet/patch.h"
#include "planet/planet_writer.h"

// The residual of a child tile: row-major 256 x 256 metres to be added to the upsampled heights; 0
// where `flat`. radius: of the planet, m. relief saturates at a slope of SYNTHESIS_MAX_SLOPE, so
// that detail upon detail stays terrain.
void synthesis_residual(const patch *p, double gain, double radius, const bool *flat,
                        float *residual);

// Local relief of the patch's samples: greatest less smallest of the 3 x 3 around each, saturated;
// PATCH_ROWS x p->cols, its outermost ring undefined.
void synthesis_relief(const patch *p, double radius, float *relief);

// Unit-rms gradient noise at a point of the unit sphere, for the samples of a zoom: exposed for its
// test.
float synthesis_noise(double x, double y, double z, int zoom);

// rms of what the finest zooms' tiles add to their upsampled parents, as a share of rms relief,
// over a spread of at most 200 tiles with relief; held within [0.02, 0.08]: beyond that, slopes
// would grow more than threefold over 14 zooms. 0.05 when nothing can be measured.
status synthesis_measure_gain(struct planet_writer *writer, int max_zoom, double radius,
                              double *gain);

#define SYNTHESIS_MAX_SLOPE 0.8

#endif
