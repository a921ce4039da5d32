// The functions of shaders/shared in C, twice: name_f in float, as the GPU computes them, and
// name_d in double. Contracts stand at the functions.
//
// Pure functions. Any thread.
#ifndef PERIGEE_GEO_SHARED_H
#define PERIGEE_GEO_SHARED_H

#include <math.h>
#include <stdint.h>
#include <string.h>

// x cut to 12 bits, so that a product of two such numbers is exact. In double nothing needs it.
static inline float leading_bits_f(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    bits &= 0xfffff000u;
    memcpy(&x, &bits, sizeof bits);
    return x;
}

static inline double leading_bits_d(double x)
{
    return x;
}

#define real           float
#define SHARED_NAME(f) f##_f
#include "geo/shared_functions.inc"

#define real           double
#define SHARED_NAME(f) f##_d
#include "geo/shared_functions.inc"

#endif
