// The functions of shaders/shared in C, twice: name_f in float, as the GPU computes them, and
// name_d in double. Contracts stand at the functions.
//
// Pure functions. Any thread.
#ifndef PERIGEE_GEO_SHARED_H
#define PERIGEE_GEO_SHARED_H

#include <math.h>

#define real           float
#define SHARED_NAME(f) f##_f
#include "geo/shared_functions.inc"

#define real           double
#define SHARED_NAME(f) f##_d
#include "geo/shared_functions.inc"

#endif
