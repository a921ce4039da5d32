// The prediction that residuals of heights are added to: the four-point filter of src/planet/upsample.h in whole quanta. One
// source for the workers (src/clipmap/residual.c) and the GPU; whole numbers, so that both have the same bits.
#ifndef SHARED_RESIDUAL
#define SHARED_RESIDUAL

#include "shared/dialect.glsl"

// Of four samples in a row, what lies a quarter of the way from the second to the third, rounded; numbers below nought by
// two's complement.
SHARED UINT SHARED_NAME(quarter_past)(UINT a, UINT b, UINT c, UINT d)
{
    UINT off = 29u * (c - b) - 9u * (a - b) - 3u * (d - b);
    return b + UINT_OF(INT(off + 64u) >> 7);
}

#endif
