// Rows first, then columns. Written so that compilers turn the inner loops into vector code.
#include "planet/upsample.h"

#include <assert.h>
#include <math.h>
#include <string.h>

// Weights by increasing place of the sample, for a point a quarter sample before the third, and
// after the second.
static const float before[4] = {-3.0f / 128, 29.0f / 128, 111.0f / 128, -9.0f / 128};
static const float after[4] = {-9.0f / 128, 111.0f / 128, 29.0f / 128, -3.0f / 128};

enum { ROW_FLOATS = REGION_MAX_COLS * REGION_MAX_CHANNELS };

static float four(const float *s, int stride, const float w[4])
{
    return w[0] * s[0] + w[1] * s[stride] + w[2] * s[2 * stride] + w[3] * s[3 * stride];
}

static void double_plain_row(const float *restrict s, int pairs, float *restrict out)
{
    for (int k = 0; k < pairs; k++) {
        out[2 * k] = four(s + k, 1, before);
        out[2 * k + 1] = four(s + k + 1, 1, after);
    }
}

void upsample_row(const float *src, int channels, int odd, int cols, float *out)
{
    int pairs = (cols + odd) / 2;
    if (channels == 1 && !odd) {
        double_plain_row(src, pairs, out);
        if (cols % 2) out[cols - 1] = four(src + pairs, 1, before);
        return;
    }
    for (int k = 0; k < cols; k++) {
        int fine = k + odd;
        const float *s = src + (size_t)(fine / 2 + fine % 2) * (size_t)channels;
        for (int c = 0; c < channels; c++)
            out[k * channels + c] = four(s + c, channels, fine % 2 ? after : before);
    }
}

// The rows of the parent around a row of the child.
struct taps {
    const float *first; // of four rows
    bool south;         // of the second; else north of the third
};

static struct taps taps_of(const region *parent, const float *field, int stride,
                           const region *child, int row)
{
    int64_t at = child->row + row, first = region_first_tap(at) - parent->row;
    assert(first >= 0 && first + 4 <= parent->rows);
    return (struct taps){field + (size_t)first * (size_t)stride, at % 2 != 0};
}

static bool same_columns(const region *parent, const region *child)
{
    return 2 * parent->coalesce == child->coalesce;
}

// Column of the parent, from its first, whose sample lies at the child's column i or, where columns
// are doubled, next west of it.
static int west_of(const region *child, bool same, int i)
{
    if (same) return i + 1;
    int fine = i + (int)(child->col & 1);
    return fine / 2 + fine % 2 + 1;
}

static void keep_flat(const region *parent, const region *child, struct taps taps,
                      float *restrict out, bool *restrict flat)
{
    const float *a = taps.first + parent->stride, *b = a + parent->stride;
    bool same = same_columns(parent, child), level[REGION_MAX_COLS];
    for (int i = 0; i < parent->cols - 1; i++)
        level[i] = (a[i] == b[i]) & (a[i] == a[i + 1]) & (a[i] == b[i + 1]);
    for (int i = 0; i < child->cols; i++) {
        int west = west_of(child, same, i);
        flat[i] = level[west] | (same & level[west - same]);
        out[i] = flat[i] ? a[west] : out[i];
    }
}

void upsample_child_row(const region *parent, const region *child, int row, float *out, bool *flat)
{
    float rows[ROW_FLOATS];
    int n = parent->cols * parent->channels, stride = parent->stride;
    struct taps taps = taps_of(parent, parent->data, stride, child, row);
    const float *s = taps.first, *w = taps.south ? after : before;
    for (int i = 0; i < n; i++)
        rows[i] = w[0] * s[i] + w[1] * s[i + stride] + w[2] * s[i + 2 * stride] +
                  w[3] * s[i + 3 * stride];
    if (same_columns(parent, child))
        memcpy(out, rows + child->channels, sizeof *out * (size_t)(child->cols * child->channels));
    else upsample_row(rows, child->channels, (int)(child->col & 1), child->cols, out);
    if (child->channels == 1) keep_flat(parent, child, taps, out, flat);
}

void upsample_linear_row(const region *parent, const float *field, const region *child, int row,
                         float *out)
{
    float rows[REGION_MAX_COLS];
    struct taps taps = taps_of(parent, field, parent->cols, child, row);
    const float *a = taps.first + parent->cols, *b = a + parent->cols;
    float south = taps.south ? 0.25f : 0.75f, north = 1.0f - south;
    for (int i = 0; i < parent->cols; i++) rows[i] = north * a[i] + south * b[i];
    if (same_columns(parent, child)) {
        memcpy(out, rows + 1, sizeof *out * (size_t)child->cols);
        return;
    }
    for (int i = 0; i < child->cols; i++) {
        int west = west_of(child, false, i);
        float east = (i + child->col) & 1 ? 0.25f : 0.75f;
        out[i] = (1.0f - east) * rows[west] + east * rows[west + 1];
    }
}

static float lesser(float a, float b)
{
    return b < a ? b : a;
}

void upsample_least_row(const region *parent, const region *child, int row, float *out)
{
    float least[REGION_MAX_COLS], pairs[REGION_MAX_COLS];
    size_t n = (size_t)parent->stride;
    const float *s = taps_of(parent, parent->data, parent->stride, child, row).first;
    bool same = same_columns(parent, child);
    for (size_t i = 0; i < n; i++) {
        float a = lesser(INFINITY, s[i]), b = lesser(INFINITY, s[i + n]);
        a = lesser(a, s[i + 2 * n]);
        least[i] = lesser(lesser(a, b), s[i + 3 * n]);
    }
    for (size_t i = 0; i + 1 < n; i++) pairs[i] = lesser(least[i], least[i + 1]);
    for (int i = 0; i < child->cols; i++) {
        int west = west_of(child, same, i);
        out[i] = lesser(pairs[west - 1], same ? pairs[west] : pairs[west + 1]);
    }
}
