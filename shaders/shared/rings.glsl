// The coordinates of a ring vertex.
#ifndef SHARED_RINGS
#define SHARED_RINGS

#include "shared/dialect.glsl"

// n~ or e~: the ring's radius times the column's cosine or sine of azimuth. Each is the sum of two numbers, the first of 12 bits,
// so that its product is exact and only the last sum rounds.
SHARED real SHARED_NAME(ring_coordinate)(real radius, real radius_low, real along, real along_low)
{
    return radius * along + (radius * along_low + radius_low * (along + along_low));
}

#endif
