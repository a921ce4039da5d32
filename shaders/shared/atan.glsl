// The arc tangent, the same on every device: GLSL leaves the precision of its own undefined.
#ifndef SHARED_ATAN
#define SHARED_ATAN

#include "shared/dialect.glsl"

// atan(q) = q + q s (ATAN_1 + s (ATAN_2 + ...)), s = q q, 0 <= q <= 1. Minimax fit of the relative error (Remez exchange
// in 40 digits, coefficients rounded to float one by one, the rest fitted again): 1.7e-8.
#define ATAN_1 -0.333331525f
#define ATAN_2 0.199937686f
#define ATAN_3 -0.142110243f
#define ATAN_4 0.106658921f
#define ATAN_5 -0.0755198896f
#define ATAN_6 0.0432093292f
#define ATAN_7 -0.0163664315f
#define ATAN_8 0.00292033004f

// The angle of (x, y) from the x axis, rad, in [-pi, pi].
//   error   1.62e-7 relative in float, 1.4e-7 in the first octant; 1.7e-8 in double (tests/geo/test_shared.c)
//   edges   (0, 0) gives 0; the sign of y decides the half, so y = -1e-30 with x < 0 gives -pi, and y = 0 counts as above
SHARED real SHARED_NAME(atan_ratio)(real y, real x)
{
    real ax = x < 0.0f ? -x : x;
    real ay = y < 0.0f ? -y : y;
    real high = ax > ay ? ax : ay;
    real low = ax > ay ? ay : ax;
    real q = high > 0.0f ? low / high : REAL(0.0);
    real s = q * q;
    real p = ATAN_5 + s * (ATAN_6 + s * (ATAN_7 + s * ATAN_8));
    p = ATAN_1 + s * (ATAN_2 + s * (ATAN_3 + s * (ATAN_4 + s * p)));
    real angle = q + q * (s * p);
    if (ay > ax) angle = REAL(0.5) * SHARED_PI - angle;
    if (x < 0.0f) angle = SHARED_PI - angle;
    return y < 0.0f ? -angle : angle;
}

#endif
