// Rows first, then columns. Written so that compilers turn the inner loops into vector code.
#include "planet/upsample.h"

#include <assert.h>
#include <string.h>

// Weights by increasing place of the sample, for a point a quarter sample before the third, and
// after the second.
static const float before[4] = {-3.0f / 128, 29.0f / 128, 111.0f / 128, -9.0f / 128};
static const float after[4] = {-9.0f / 128, 111.0f / 128, 29.0f / 128, -3.0f / 128};

enum { MAX_CHANNELS = 4, ROW_FLOATS = PATCH_MAX_COLS * MAX_CHANNELS };

static float four(const float *s, int stride, const float w[4])
{
    return w[0] * s[0] + w[1] * s[stride] + w[2] * s[2 * stride] + w[3] * s[3 * stride];
}

void upsample_row(const float *src, int channels, int odd, int cols, float *out)
{
    for (int k = 0; k < cols; k++) {
        int fine = k + odd;
        const float *s = src + (size_t)(fine / 2 + fine % 2) * channels;
        for (int c = 0; c < channels; c++)
            out[k * channels + c] = four(s + c, channels, fine % 2 ? after : before);
    }
}

// Patch row of the first of the four taps of a child row.
static int first_tap(int row)
{
    return row / 2 + row % 2;
}

// One row of the child in latitude, still in the patch's columns.
static void interpolate_rows(const struct patch *p, int row, float *restrict out)
{
    int n = p->cols * p->channels;
    const float *s = p->data + (size_t)first_tap(row) * n;
    const float *w = row % 2 ? after : before;
    for (int i = 0; i < n; i++)
        out[i] = w[0] * s[i] + w[1] * s[i + n] + w[2] * s[i + 2 * n] + w[3] * s[i + 3 * n];
}

static void interpolate_columns(const float *restrict s, float *restrict out)
{
    for (int k = 0; k < TILE_SIZE / 2; k++) {
        out[2 * k] =
            before[0] * s[k] + before[1] * s[k + 1] + before[2] * s[k + 2] + before[3] * s[k + 3];
        out[2 * k + 1] =
            after[0] * s[k + 1] + after[1] * s[k + 2] + after[2] * s[k + 3] + after[3] * s[k + 4];
    }
}

static void keep_flat(const struct patch *p, int row, float *restrict out, bool *restrict flat)
{
    const float *a = p->data + (size_t)(first_tap(row) + 1) * p->cols, *b = a + p->cols;
    if (p->lon_factor == 1) {
        for (int i = 0; i < TILE_SIZE; i++) {
            flat[i] = a[i + PATCH_MARGIN] == b[i + PATCH_MARGIN];
            if (flat[i]) out[i] = a[i + PATCH_MARGIN];
        }
        return;
    }
    bool level[PATCH_MAX_COLS]; // are the samples north and south equal, and those to the east?
    for (int i = 0; i < p->cols - 1; i++)
        level[i] = (a[i] == b[i]) & (a[i] == a[i + 1]) & (a[i] == b[i + 1]);
    for (int i = 0; i < TILE_SIZE; i++) {
        int west = first_tap(i) + 1;
        flat[i] = level[west];
        if (flat[i]) out[i] = a[west];
    }
}

void upsample_height_row(const struct patch *p, int row, float out[TILE_SIZE], bool flat[TILE_SIZE])
{
    float rows[ROW_FLOATS];
    bool unused[TILE_SIZE];
    assert(p->channels == 1);
    interpolate_rows(p, row, rows);
    if (p->lon_factor == 2) interpolate_columns(rows, out);
    else memcpy(out, rows + PATCH_MARGIN, TILE_SIZE * sizeof *out);
    keep_flat(p, row, out, flat ? flat : unused);
}

void upsample_linear_row(const struct patch *p, const float *field, int row, float out[TILE_SIZE])
{
    float rows[ROW_FLOATS];
    const float *a = field + (size_t)(first_tap(row) + 1) * p->cols, *b = a + p->cols;
    float south = row % 2 ? 0.25f : 0.75f, north = 1.0f - south;
    for (int i = 0; i < p->cols; i++) rows[i] = north * a[i] + south * b[i];
    if (p->lon_factor == 1) {
        memcpy(out, rows + PATCH_MARGIN, TILE_SIZE * sizeof *out);
        return;
    }
    for (int k = 0; k < TILE_SIZE / 2; k++) {
        out[2 * k] = 0.25f * rows[k + 1] + 0.75f * rows[k + 2];
        out[2 * k + 1] = 0.75f * rows[k + 2] + 0.25f * rows[k + 3];
    }
}

static uint8_t to_byte(float v)
{
    return v <= 0.0f ? 0 : v >= 255.0f ? 255 : (uint8_t)(v + 0.5f);
}

void upsample_rgba(const struct patch *p, uint8_t *out)
{
    float rows[ROW_FLOATS], fine[TILE_SIZE * MAX_CHANNELS];
    assert(p->channels == MAX_CHANNELS);
    for (int row = 0; row < TILE_SIZE; row++) {
        interpolate_rows(p, row, rows);
        const float *samples = rows + PATCH_MARGIN * MAX_CHANNELS;
        if (p->lon_factor == 2) {
            upsample_row(rows, MAX_CHANNELS, 0, TILE_SIZE, fine);
            samples = fine;
        }
        for (int i = 0; i < TILE_SIZE * MAX_CHANNELS; i++) *out++ = to_byte(samples[i]);
    }
}
