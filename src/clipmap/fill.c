// clipmap_fill: window samples out of tiles. The rows of both agree; along a row the window's step
// and the tile row's step differ by a power of two. Invariant: a sample depends on (layer, zoom,
// share, row, column) only, never on the rectangle it is asked in; at most two tiles are held at a
// time.
#include <assert.h>
#include <math.h>
#include <pthread.h>
#include <string.h>

#include "clipmap/clipmap.h"

enum { LINEAR_STEPS = 16384 };

static uint16_t linear_of_srgb[256];         // linear light, 65535 at full
static uint8_t srgb_of_linear[LINEAR_STEPS]; // nearest code of (i + 1/2) / LINEAR_STEPS
static pthread_once_t tables_once = PTHREAD_ONCE_INIT;

// IEC 61966-2-1.
static void make_tables(void)
{
    for (int i = 0; i < 256; i++) {
        double e = i / 255.0;
        double l = e <= 0.04045 ? e / 12.92 : pow((e + 0.055) / 1.055, 2.4);
        linear_of_srgb[i] = (uint16_t)lround(l * 65535.0);
    }
    for (int i = 0; i < LINEAR_STEPS; i++) {
        double l = (i + 0.5) / LINEAR_STEPS;
        double e = l <= 0.0031308 ? l * 12.92 : 1.055 * pow(l, 1 / 2.4) - 0.055;
        srgb_of_linear[i] = (uint8_t)lround(e * 255.0);
    }
}

static uint8_t encode(uint32_t linear)
{
    return srgb_of_linear[linear * LINEAR_STEPS / 65536];
}

// Rows of the rectangle that lie in one tile row and on one side of a pole.
struct band {
    int64_t row0, row1;    // window rows
    int tile_row, y, dy;   // of row0 in its tile; dy = -1 beyond a pole
    int64_t turn;          // window columns to add: half the circle beyond a pole
    int64_t tile_circle;   // samples of the tile row around the globe
    int64_t window_circle; // window columns around the globe
};

struct filler {
    struct pyramid *pyramid;
    struct want *want; // NULL: wait for tiles
    enum tile_layer layer;
    int zoom;
    window_rect rect;
    void *samples;
    double until_s;
};

static struct band band_at(const struct filler *f, int64_t row, int64_t window_circle)
{
    int64_t rows = (int64_t)TILE_SIZE << f->zoom;
    struct band b = {.row0 = row, .dy = 1, .window_circle = window_circle};
    int64_t source = row, end = rows;
    if (row < 0) source = -1 - row, end = 0, b.dy = -1;
    if (row >= rows) source = 2 * rows - 1 - row, end = row + rows, b.dy = -1;
    assert(source >= 0 && source < rows);
    if (b.dy < 0) b.turn = window_circle / 2;
    b.tile_row = (int)(source / TILE_SIZE);
    b.y = (int)(source % TILE_SIZE);
    int64_t in_tile = b.dy > 0 ? TILE_SIZE - b.y : b.y + 1;
    b.row1 = row + in_tile;
    if (b.row1 > end) b.row1 = end;
    if (b.row1 > f->rect.row1) b.row1 = f->rect.row1;
    b.tile_circle = (int64_t)TILE_SIZE * grid_cols(f->zoom, b.tile_row);
    return b;
}

static status acquire(struct filler *f, const struct band *b, int64_t tile,
                      const pyramid_tile **out)
{
    int64_t tiles = b->tile_circle / TILE_SIZE;
    tile_id id = {f->layer, f->zoom, b->tile_row, (int)(tile % tiles)};
    status s =
        f->want ? pyramid_try(f->pyramid, id, f->want, out) : pyramid_acquire(f->pyramid, id, out);
    if (!s) f->until_s = fmin(f->until_s, (*out)->until_s);
    return s;
}

// First sample of window row `row`, column `col` of the result.
static size_t result_index(const struct filler *f, int64_t row, int64_t col)
{
    return (size_t)(row - f->rect.row0) * (size_t)(f->rect.col1 - f->rect.col0) +
           (size_t)(col - f->rect.col0);
}

static void average_heights(const float *in, int ratio, int count, float *out)
{
    for (int i = 0; i < count; i++, in += ratio) {
        float sum = 0;
        for (int j = 0; j < ratio; j++) sum += in[j];
        out[i] = sum / (float)ratio;
    }
}

// The mean of light, not of codes.
static void average_colors(const uint8_t *in, int ratio, int count, uint8_t *out)
{
    for (int i = 0; i < count; i++, out += 4) {
        uint32_t sum[4] = {0};
        for (int j = 0; j < ratio; j++, in += 4)
            for (int c = 0; c < 4; c++) sum[c] += linear_of_srgb[in[c]];
        for (int c = 0; c < 4; c++) out[c] = encode(sum[c] / (uint32_t)ratio);
    }
}

// One tile's part of a band whose window columns are `ratio` tile samples wide; x, count: first
// sample, columns.
static void reduce_tile(const struct filler *f, const struct band *b, const pyramid_tile *tile,
                        int x, int ratio, int64_t col, int count)
{
    int y = b->y;
    for (int64_t row = b->row0; row < b->row1; row++, y += b->dy) {
        size_t from = (size_t)y * TILE_SIZE + (size_t)x, to = result_index(f, row, col);
        if (f->layer == LAYER_HEIGHT) {
            float *out = (float *)f->samples + to;
            if (ratio == 1) memcpy(out, tile->heights + from, (size_t)count * sizeof *out);
            else average_heights(tile->heights + from, ratio, count, out);
        } else {
            uint8_t *out = (uint8_t *)f->samples + 4 * to;
            if (ratio == 1) memcpy(out, tile->rgba + 4 * from, (size_t)count * 4);
            else average_colors(tile->rgba + 4 * from, ratio, count, out);
        }
    }
}

static status reduce_band(struct filler *f, const struct band *b)
{
    int64_t ratio = b->tile_circle / b->window_circle;
    status pending = OK;
    assert(ratio <= TILE_SIZE); // a window column lies in one tile
    for (int64_t col = f->rect.col0; col < f->rect.col1;) {
        int64_t around = (col + b->turn) % b->window_circle;
        if (around < 0) around += b->window_circle;
        int64_t first = around * ratio, x = first % TILE_SIZE;
        int64_t count = (TILE_SIZE - x) / ratio;
        if (count > f->rect.col1 - col) count = f->rect.col1 - col;
        const pyramid_tile *tile;
        status s = acquire(f, b, first / TILE_SIZE, &tile);
        if (s && s != ERR_PENDING) return s;
        if (s) pending = s;
        else reduce_tile(f, b, tile, (int)x, (int)ratio, col, (int)count);
        if (!s) pyramid_release(f->pyramid, &tile);
        col += count;
    }
    return pending;
}

static void mix_heights(float a, float b, float t, float *out)
{
    *out = a + (b - a) * t;
}

static void mix_colors(const uint8_t *a, const uint8_t *b, float t, uint8_t *out)
{
    for (int c = 0; c < 4; c++) {
        float p = linear_of_srgb[a[c]], q = linear_of_srgb[b[c]];
        out[c] = a[c] == b[c] ? a[c] : encode((uint32_t)(p + (q - p) * t));
    }
}

// Columns [col, col + count) of a band finer than its tile row, `parts` columns a tile sample.
// `phase` counts columns from the centre of the tile's first sample; `next` is the tile to the
// right, read where a column lies beyond the centre of the last sample.
static void widen_tile(const struct filler *f, const struct band *b, const pyramid_tile *tile,
                       const pyramid_tile *next, int64_t parts, int64_t phase, int64_t col,
                       int64_t count)
{
    int y = b->y;
    for (int64_t row = b->row0; row < b->row1; row++, y += b->dy) {
        size_t line = (size_t)y * TILE_SIZE, to = result_index(f, row, col);
        for (int64_t i = 0; i < count; i++) {
            size_t x = (size_t)((phase + i) / parts);
            float t = (float)(((double)((phase + i) % parts) + 0.5) / (double)parts);
            const pyramid_tile *right = x + 1 < TILE_SIZE ? tile : next;
            size_t p = line + x, q = line + (x + 1) % TILE_SIZE;
            if (f->layer == LAYER_HEIGHT)
                mix_heights(tile->heights[p], right->heights[q], t, (float *)f->samples + to + i);
            else
                mix_colors(tile->rgba + 4 * p, right->rgba + 4 * q, t,
                           (uint8_t *)f->samples + 4 * (to + (size_t)i));
        }
    }
}

static status widen_band(struct filler *f, const struct band *b)
{
    int64_t parts = b->window_circle / b->tile_circle; // even: a power of two above 1
    int64_t tile_columns = parts * TILE_SIZE;
    status s = OK, pending = OK;
    for (int64_t col = f->rect.col0; col < f->rect.col1 && !s;) {
        // Column c lies at (c + 1/2) / parts tile samples; from the centre of sample 0, c - parts /
        // 2 whole columns.
        int64_t from_centre = (col + b->turn - parts / 2) % b->window_circle;
        if (from_centre < 0) from_centre += b->window_circle;
        int64_t index = from_centre / tile_columns, phase = from_centre % tile_columns;
        int64_t count = tile_columns - phase;
        if (count > f->rect.col1 - col) count = f->rect.col1 - col;
        bool crosses = phase + count > tile_columns - parts;
        const pyramid_tile *tile = NULL, *next = NULL;
        s = acquire(f, b, index, &tile);
        if (s == ERR_PENDING) pending = s, s = OK;
        if (!s && crosses) s = acquire(f, b, index + 1, &next);
        if (s == ERR_PENDING) pending = s, s = OK;
        if (!s && !pending) widen_tile(f, b, tile, next, parts, phase, col, count);
        if (next) pyramid_release(f->pyramid, &next);
        if (tile) pyramid_release(f->pyramid, &tile);
        col += count;
    }
    return s ? s : pending;
}

status clipmap_fill(struct pyramid *pyramid, enum tile_layer layer, const window_shape *shape,
                    const window *w, window_rect rect, void *samples)
{
    double until_s;
    return clipmap_try_fill(pyramid, layer, shape, w, rect, NULL, samples, &until_s);
}

status clipmap_try_fill(struct pyramid *pyramid, enum tile_layer layer, const window_shape *shape,
                        const window *w, window_rect rect, struct want *want, void *samples,
                        double *until_s)
{
    assert(layer == LAYER_HEIGHT || layer == LAYER_COLOR);
    pthread_once(&tables_once, make_tables);
    struct filler f = {pyramid, want, layer, w->zoom, rect, samples, INFINITY};
    int64_t circle = (int64_t)shape->cols << w->share;
    status s = OK, pending = OK;
    for (int64_t row = rect.row0; row < rect.row1 && !s;) {
        struct band b = band_at(&f, row, circle);
        s = b.tile_circle >= circle ? reduce_band(&f, &b) : widen_band(&f, &b);
        if (s == ERR_PENDING) pending = s, s = OK;
        row = b.row1;
    }
    *until_s = f.until_s;
    return s ? s : pending;
}
