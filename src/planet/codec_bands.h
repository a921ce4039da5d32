// The coefficients of a wavelet (wavelet.h), roughly: each as a whole number of steps, coded by
// what its neighbours and the coarser coefficient at its place were. The numbers are chosen
// together (trellis coded quantisation, Marcellin & Fischer 1990, as VVC has it: Schwarz et al.
// 2019): four states, of which two stand for even steps and two for odd ones and 0, and the parity
// of a number leads to the next; so the steps are half as wide as what is paid for. Any thread.
#ifndef PERIGEE_PLANET_CODEC_BANDS_H
#define PERIGEE_PLANET_CODEC_BANDS_H

#include "planet/codec_symbols.h"

// How coefficients are put back. shift: what is added to the amount of a number 1, and of greater
// ones, in 1/128 of a step. empty: of so many finest levels all coefficients are 0.
struct bands_scale {
    float step;
    signed char shift[2];
    unsigned char empty;
};

// coefficients: 256 x 256. scale->step is given, > 0; the rest is found. back: what the decoder
// will give. ERR_UNSUPPORTED when a coefficient is beyond the code.
status bands_encode(const float *coefficients, struct bands_scale *scale,
                    struct symbol_writer *writer, float *back);

// scale->empty is at most WAVELET_LEVELS. Any bytes give some coefficients.
void bands_decode(struct symbol_reader *reader, const struct bands_scale *scale,
                  float *coefficients);

#endif
