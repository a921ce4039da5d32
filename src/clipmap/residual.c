#include "clipmap/residual.h"

#include <assert.h>
#include <math.h>

#include "geo/shared.h"
#include "planet/region.h"

float clip_residual_quantum(int zoom)
{
    const int least = -10; // heights up to 16 km have 24 bits
    int power = 5 - zoom;
    return ldexpf(1, power > least ? power : least);
}

void clip_residual_round(int zoom, float *heights, size_t count)
{
    float quantum = clip_residual_quantum(zoom), per_metre = 1 / quantum;
    for (size_t i = 0; i < count; i++) // adding 0 makes -0 a 0, as whole numbers have it
        heights[i] = rintf(heights[i] * per_metre) * quantum + 0.0f;
}

static bool in_range(float quanta)
{
    return fabsf(quanta) < 0x1p30f; // false for NaN
}

// Rows of the prediction: four rows of parents brought to a quarter before the third or after the
// second.
static bool predict_row(const float *parents, int stride, float per_metre, bool after,
                        uint32_t *out)
{
    for (int i = 0; i < stride; i++) {
        uint32_t h[4];
        for (int k = 0; k < 4; k++) {
            float quanta = parents[k * stride + i] * per_metre;
            if (!in_range(quanta)) return false;
            h[k] = (uint32_t)(int32_t)quanta;
        }
        out[i] =
            after ? quarter_past_f(h[0], h[1], h[2], h[3]) : quarter_past_f(h[3], h[2], h[1], h[0]);
    }
    return true;
}

static bool subtract_row(const uint32_t *taps, int odd, int count, float per_metre,
                         const float *heights, int16_t *out)
{
    for (int i = 0; i < count; i++) {
        int fine = i + odd;
        const uint32_t *t = taps + fine / 2 + fine % 2 - odd;
        uint32_t up = fine % 2 ? quarter_past_f(t[0], t[1], t[2], t[3])
                               : quarter_past_f(t[3], t[2], t[1], t[0]);
        float quanta = heights[i] * per_metre;
        if (!in_range(quanta)) return false;
        int32_t residual = (int32_t)((uint32_t)(int32_t)quanta - up);
        if (residual != (int16_t)residual) return false;
        out[i] = (int16_t)residual;
    }
    return true;
}

bool clip_residual_find(int zoom, window_rect rect, const float *heights, const float *parents,
                        int16_t *out)
{
    enum { MOST = 2048 / 2 + 4 }; // columns of the widest window's parents
    uint32_t taps[MOST];
    window_rect around = window_rect_parents(rect);
    int stride = (int)(around.col1 - around.col0), count = (int)(rect.col1 - rect.col0);
    float per_metre = 1 / clip_residual_quantum(zoom);
    int odd = (int)(rect.col0 & 1);
    assert(stride <= MOST);
    for (int64_t row = rect.row0; row < rect.row1; row++) {
        int64_t first = region_first_tap(row) - around.row0;
        if (!predict_row(parents + first * stride, stride, per_metre, row & 1, taps)) return false;
        if (!subtract_row(taps, odd, count, per_metre, heights, out)) return false;
        heights += count;
        out += count;
    }
    return true;
}
