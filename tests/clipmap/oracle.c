#include "oracle.h"

#include <math.h>
#include <stdlib.h>

#include "fake_pyramid.h"

static const double PI = 3.14159265358979323846;

int64_t oracle_coalesce(int zoom, int64_t tile_row)
{
    int64_t rows = (int64_t)1 << zoom;
    int64_t from_pole = tile_row < rows / 2 ? tile_row + 1 : rows - tile_row;
    double cosine = zoom == 0 ? 1 : sin((double)from_pole * PI / (double)rows);
    int64_t c = 1;
    while (2 * c <= 2 * rows && (double)(2 * c) * cosine <= 1) c *= 2;
    return c;
}

// One window row in terms of the tile row it comes from.
struct sampled {
    int64_t row, turn, tile_circle, window_circle;
};

static struct sampled source_of(int cols, int zoom, int share, int64_t row)
{
    int64_t rows = (int64_t)256 << zoom;
    struct sampled s = {.row = row, .window_circle = (int64_t)cols << share};
    if (row < 0) s.row = -1 - row;
    if (row >= rows) s.row = 2 * rows - 1 - row;
    if (row != s.row) s.turn = s.window_circle / 2;
    s.tile_circle = 512 * ((int64_t)1 << zoom) / oracle_coalesce(zoom, s.row / 256);
    return s;
}

static int64_t modulo(int64_t a, int64_t n)
{
    return (a % n + n) % n;
}

// The weights of column `col`: tile samples [*first, *first + count) with weight 1 / count each, or
// two of them.
struct taps {
    int64_t first, count;
    double mix; // >= 0: weight of the second of two
};

static struct taps taps_of(const struct sampled *s, int64_t col)
{
    if (s->tile_circle >= s->window_circle) {
        int64_t ratio = s->tile_circle / s->window_circle;
        return (struct taps){(col + s->turn) * ratio, ratio, -1};
    }
    double place = ((double)modulo(col + s->turn, s->window_circle) + 0.5) *
                       (double)s->tile_circle / (double)s->window_circle -
                   0.5;
    return (struct taps){(int64_t)floor(place), 2, place - floor(place)};
}

static double weight(const struct taps *t, int64_t i)
{
    if (t->mix < 0) return 1.0 / (double)t->count;
    return i == 0 ? 1 - t->mix : t->mix;
}

void oracle_heights(int cols, int zoom, int share, int64_t row, int64_t col0, int64_t col1,
                    float *out)
{
    struct sampled s = source_of(cols, zoom, share, row);
    for (int64_t col = col0; col < col1; col++) {
        struct taps t = taps_of(&s, col);
        double sum = 0;
        for (int64_t i = 0; i < t.count; i++)
            sum += weight(&t, i) * fake_height(zoom, s.row, modulo(t.first + i, s.tile_circle));
        *out++ = (float)sum;
    }
}

static double linear(double e)
{
    return e <= 0.04045 ? e / 12.92 : pow((e + 0.055) / 1.055, 2.4);
}

static double encoded(double l)
{
    return l <= 0.0031308 ? 12.92 * l : 1.055 * pow(l, 1 / 2.4) - 0.055;
}

void oracle_colors(int cols, int zoom, int share, int64_t row, int64_t col0, int64_t col1,
                   double (*out)[4])
{
    struct sampled s = source_of(cols, zoom, share, row);
    for (int64_t col = col0; col < col1; col++, out++) {
        struct taps t = taps_of(&s, col);
        double sum[4] = {0};
        for (int64_t i = 0; i < t.count; i++) {
            uint8_t rgba[4];
            fake_color(zoom, s.row, modulo(t.first + i, s.tile_circle), rgba);
            for (int c = 0; c < 4; c++) sum[c] += weight(&t, i) * linear(rgba[c] / 255.0);
        }
        for (int c = 0; c < 4; c++) (*out)[c] = 255 * encoded(sum[c]);
    }
}
