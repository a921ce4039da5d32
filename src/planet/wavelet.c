// Lows stand before highs, in rows and in columns, and the lows of both hold the next level. The
// steps' scaling of lows and highs is left to the bands' norms.
#include "planet/wavelet.h"

#include <string.h>

enum { N = TILE_SIZE, HALF = N / 2 };

// Daubechies & Sweldens 1998, 7.7.
static const float alpha = -1.586134342059924f, beta = -0.052980118572961f,
                   gamma_ = 0.882911075530934f, delta = 0.443506852043971f;
#define ZETA 1.149604398860241

void wavelet_bands(struct wavelet_band bands[WAVELET_BANDS])
{
    double scale = 1;
    int at = WAVELET_BANDS;
    for (int level = 1; level <= WAVELET_LEVELS; level++) {
        int n = N >> level;
        bands[--at] = (struct wavelet_band){n, n, n, level, 1, 1, (float)(scale / (ZETA * ZETA))};
        bands[--at] = (struct wavelet_band){n, 0, n, level, 1, 0, (float)scale};
        bands[--at] = (struct wavelet_band){0, n, n, level, 0, 1, (float)scale};
        scale *= ZETA * ZETA;
    }
    bands[0] = (struct wavelet_band){0, 0, N >> WAVELET_LEVELS, WAVELET_LEVELS, 0, 0, (float)scale};
}

// A step along a row, of highs from the lows around them or of lows from the highs.
static void lift_highs(const float *restrict lows, float *restrict highs, int n, float weight)
{
    for (int i = 0; i < n - 1; i++) highs[i] += weight * (lows[i] + lows[i + 1]);
    highs[n - 1] += weight * (lows[n - 1] + lows[n - 1]);
}

static void lift_lows(float *restrict lows, const float *restrict highs, int n, float weight)
{
    lows[0] += weight * (highs[0] + highs[0]);
    for (int i = 1; i < n; i++) lows[i] += weight * (highs[i - 1] + highs[i]);
}

// A row of a step along columns.
static void lift_row(float *restrict to, const float *a, const float *b, int cols, float weight)
{
    for (int i = 0; i < cols; i++) to[i] += weight * (a[i] + b[i]);
}

static void lift_high_rows(float *p, int n, float weight)
{
    for (int i = 0; i < n; i++)
        lift_row(p + (n + i) * N, p + i * N, p + (i + 1 < n ? i + 1 : i) * N, 2 * n, weight);
}

static void lift_low_rows(float *p, int n, float weight)
{
    for (int i = 0; i < n; i++)
        lift_row(p + i * N, p + (n + (i ? i - 1 : 0)) * N, p + (n + i) * N, 2 * n, weight);
}

void wavelet_forward(float *samples, float *room)
{
    for (int n = HALF; n >= N >> WAVELET_LEVELS; n /= 2) {
        for (int y = 0; y < 2 * n; y++) {
            const float *row = samples + y * N;
            float *lows = room + (y % 2 ? n + y / 2 : y / 2) * N, *highs = lows + n;
            for (int i = 0; i < n; i++) {
                lows[i] = row[2 * i];
                highs[i] = row[2 * i + 1];
            }
            lift_highs(lows, highs, n, alpha);
            lift_lows(lows, highs, n, beta);
            lift_highs(lows, highs, n, gamma_);
            lift_lows(lows, highs, n, delta);
        }
        lift_high_rows(room, n, alpha);
        lift_low_rows(room, n, beta);
        lift_high_rows(room, n, gamma_);
        lift_low_rows(room, n, delta);
        for (int y = 0; y < 2 * n; y++)
            memcpy(samples + y * N, room + y * N, 2 * (size_t)n * sizeof *samples);
    }
}

void wavelet_inverse(float *samples, float *room)
{
    for (int n = N >> WAVELET_LEVELS; n <= HALF; n *= 2) {
        lift_low_rows(samples, n, -delta);
        lift_high_rows(samples, n, -gamma_);
        lift_low_rows(samples, n, -beta);
        lift_high_rows(samples, n, -alpha);
        for (int y = 0; y < 2 * n; y++) {
            float *lows = samples + y * N, *highs = lows + n;
            float *row = room + (y < n ? 2 * y : 2 * (y - n) + 1) * N;
            lift_lows(lows, highs, n, -delta);
            lift_highs(lows, highs, n, -gamma_);
            lift_lows(lows, highs, n, -beta);
            lift_highs(lows, highs, n, -alpha);
            for (int i = 0; i < n; i++) {
                row[2 * i] = lows[i];
                row[2 * i + 1] = highs[i];
            }
        }
        for (int y = 0; y < 2 * n; y++)
            memcpy(samples + y * N, room + y * N, 2 * (size_t)n * sizeof *samples);
    }
}
