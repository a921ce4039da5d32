// A second opinion on rays, in long double and by the plainest means: samples read one by one,
// conversions by iteration, and steps along the ray that a bound of the terrain's slope allows.
#ifndef PERIGEE_TESTS_REFERENCE_ORACLE_H
#define PERIGEE_TESTS_REFERENCE_ORACLE_H

#include "planet/grid.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#define PI_L 3.14159265358979323846264338327950288L

typedef struct oracle {
    long double a, b;
    int zoom;
    float (*sample)(int zoom, int64_t row, int64_t col); // of the global grid
    long double slope;                                   // bound of |dh| / distance
    long double top;                                     // bound of h
    bool bicubic;                                        // false: bilinear
    bool plane; // of the scale a; the map ends at the poles and half a turn away
} oracle;

static inline void oracle_geodetic(const oracle *o, const long double p[3], long double *lat,
                                   long double *lon, long double *height)
{
    if (o->plane) {
        *lat = p[2] / o->a;
        *lon = p[1] / o->a;
        *height = p[0];
        return;
    }
    long double rho = hypotl(p[0], p[1]), e2 = 1 - o->b * o->b / (o->a * o->a);
    *lon = atan2l(p[1], p[0]);
    *lat = atan2l(p[2], rho * (1 - e2));
    for (int i = 0; i < 200; i++) {
        long double s = sinl(*lat), was = *lat;
        *lat = atan2l(p[2] + e2 * o->a / sqrtl(1 - e2 * s * s) * s, rho);
        if (fabsl(*lat - was) < 1e-19L) break;
    }
    long double s = sinl(*lat), c = cosl(*lat);
    *height = rho * c + p[2] * s - o->a * sqrtl(1 - e2 * s * s);
}

// Between h[1] and h[2]: straight; or by Hermite's cubic whose slopes at both ends are those of the
// chords from h[0] to h[2] and from h[1] to h[3].
static inline long double oracle_between(const oracle *o, const long double h[4], long double t)
{
    if (!o->bicubic) return h[1] + (h[2] - h[1]) * t;
    long double first = (h[2] - h[0]) / 2, last = (h[3] - h[1]) / 2, s = 1 - t;
    return h[1] * s * s * (1 + 2 * t) + h[2] * t * t * (1 + 2 * s) + first * t * s * s -
           last * t * t * s;
}

// One row; a row beyond a pole is the row as far before it, half a turn on.
static inline long double oracle_row(const oracle *o, int64_t row, long double lon)
{
    int64_t rows = (int64_t)256 << o->zoom;
    if (row < 0 || row >= rows) {
        row = row < 0 ? -1 - row : 2 * rows - 1 - row;
        lon += PI_L;
    }
    int64_t width = (int64_t)256 * grid_cols(o->zoom, (int)(row / 256));
    long double x = (lon / (2 * PI_L) + 0.5L) * (long double)width - 0.5L, k = floorl(x), h[4];
    for (int i = 0; i < 4; i++) {
        int64_t column = (((int64_t)k - 1 + i) % width + width) % width;
        h[i] = o->sample(o->zoom, row, column);
    }
    return oracle_between(o, h, x - k);
}

static inline long double oracle_height(const oracle *o, long double lat, long double lon)
{
    long double y = (PI_L / 2 - lat) / PI_L * (long double)((int64_t)256 << o->zoom) - 0.5L;
    long double k = floorl(y), h[4];
    for (int i = 0; i < 4; i++) h[i] = oracle_row(o, (int64_t)k - 1 + i, lon);
    return oracle_between(o, h, y - k);
}

static inline long double oracle_clear(const oracle *o, const double origin[3], const double dir[3],
                                       long double t)
{
    long double p[3], lat, lon, height;
    for (int i = 0; i < 3; i++) p[i] = origin[i] + t * (long double)dir[i];
    oracle_geodetic(o, p, &lat, &lon, &height);
    if (o->plane && (fabsl(lat) > PI_L / 2 || fabsl(lon) > PI_L)) return NAN;
    return height > o->top + 1 ? height - o->top : height - oracle_height(o, lat, lon);
}

// First t at which the ray is at or below the ground; NaN: none. *least: the smallest clearance met
// before.
static inline long double oracle_trace(const oracle *o, const double origin[3], const double dir[3],
                                       long double *least)
{
    long double t = 0, rate = 1 + o->slope, reach = 4 * o->a, step = 0, along = 0;
    for (int i = 0; i < 3; i++) {
        along -= (long double)origin[i] * dir[i];
    }
    reach += fmaxl(along, 0);
    *least = INFINITY;
    for (;;) {
        long double clear = oracle_clear(o, origin, dir, t);
        if (isnan(clear)) return NAN;
        if (clear <= 0) break;
        *least = fminl(*least, clear);
        step = fmaxl(clear / rate, 1e-4L);
        t += step;
        if (t > reach) return NAN;
    }
    if (t == 0) return 0;
    long double low = t - step, high = t;
    for (int i = 0; i < 90; i++) {
        long double middle = 0.5L * (low + high);
        if (oracle_clear(o, origin, dir, middle) > 0) low = middle;
        else high = middle;
    }
    return 0.5L * (low + high);
}

#endif
