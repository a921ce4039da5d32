// Everything follows from two maps: a planet column to the server's columns, an exact power of two
// of them, and a latitude to the server's row.
#include "planet/tile_matrix.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "base/vec.h"

enum { MAX_RATIO_BITS = 2 }; // tiles side by side in longitude and latitude: at most 4

static int log2_of(int power)
{
    int bits = 0;
    while (power >> (bits + 1)) bits++;
    return bits;
}

// Samples around the equator at a level.
static double circle_of(const tile_matrix *m, int level)
{
    return ldexp(m->tile_size, level + (m->projection == MATRIX_GEOGRAPHIC));
}

// Continuous row of a latitude, 0 at the north edge.
//   source  Snyder 1987, eq. 7-7, sphere
static double row_of(const tile_matrix *m, int level, double lat)
{
    double circle = circle_of(m, level);
    if (m->projection == MATRIX_GEOGRAPHIC) return (M_PI / 2 - lat) / (2 * M_PI) * circle;
    if (lat >= M_PI / 2) return -INFINITY;
    if (lat <= -M_PI / 2) return INFINITY;
    return (0.5 - asinh(tan(lat)) / (2 * M_PI)) * circle;
}

static double lat_of(const tile_matrix *m, int level, double row)
{
    double circle = circle_of(m, level);
    if (m->projection == MATRIX_GEOGRAPHIC) return M_PI / 2 - row / circle * 2 * M_PI;
    return atan(sinh((0.5 - row / circle) * 2 * M_PI));
}

// Tile rows at a level.
static int rows_of(const tile_matrix *m, int level)
{
    (void)m;
    return 1 << level;
}

// The level whose columns are as wide as the planet tile's, or the nearest finer one.
static int level_of(const tile_matrix *m, tile_id id)
{
    int coalesce = log2_of(grid_coalesce(id.zoom, id.row));
    int size = log2_of(m->tile_size / 64) - 2; // against 256
    if (m->projection == MATRIX_PLANET) return id.zoom;
    if (m->projection == MATRIX_MERCATOR) return id.zoom + 1 - coalesce - size;
    int over = coalesce > MAX_RATIO_BITS ? coalesce - MAX_RATIO_BITS : 0;
    return id.zoom - over - size;
}

static int clamp_int(int x, int low, int high)
{
    return x < low ? low : x > high ? high : x;
}

// First column of the planet tile in the server's, and the server's columns to one of the planet's.
static void columns_of(const tile_matrix *m, tile_id id, int level, int64_t *first, int *ratio)
{
    int64_t circle = (int64_t)circle_of(m, level);
    int64_t planet = (int64_t)TILE_SIZE * grid_cols(id.zoom, id.row);
    *ratio = (int)(circle / planet);
    *first = (int64_t)id.col * TILE_SIZE * *ratio;
}

bool matrix_span(const tile_matrix *m, tile_id id, tile_span *out)
{
    int level = level_of(m, id);
    if (level > m->max_level) return false;
    if (m->projection == MATRIX_PLANET) {
        *out = (tile_span){level, id.col, id.col + 1, id.row, id.row + 1};
        return level >= m->min_level;
    }
    if (level < m->min_level) level = m->min_level;
    int64_t first;
    int ratio;
    columns_of(m, id, level, &first, &ratio);
    if (ratio < 1) return false;
    double west, south, east, north;
    grid_bounds(id, &west, &south, &east, &north);
    // A hair inside, so that an edge on an edge takes no tile beyond it.
    double top = row_of(m, level, north) / m->tile_size + 1e-9,
           bottom = row_of(m, level, south) / m->tile_size - 1e-9;
    int rows = rows_of(m, level);
    int64_t last = first + (int64_t)TILE_SIZE * ratio - 1;
    *out = (tile_span){.level = level,
                       .x0 = (int)(first / m->tile_size),
                       .x1 = (int)(last / m->tile_size) + 1,
                       .y0 = (int)clamp_double(floor(top), 0, rows),
                       .y1 = (int)clamp_double(ceil(bottom), 0, rows)};
    return (int64_t)(out->x1 - out->x0) * (out->y1 - out->y0) <= MATRIX_MAX_TILES;
}

int matrix_max_zoom(const tile_matrix *m)
{
    int zoom = GRID_MAX_ZOOM;
    for (tile_span span; zoom >= 0; zoom--) {
        tile_id id = {LAYER_HEIGHT, zoom, grid_rows(zoom) / 2, 0};
        if (matrix_span(m, id, &span)) break;
    }
    return zoom;
}

void matrix_bounds(const tile_matrix *m, int level, int x, int y, double *west, double *south,
                   double *east, double *north)
{
    if (m->projection == MATRIX_PLANET) {
        grid_bounds((tile_id){LAYER_HEIGHT, level, y, x}, west, south, east, north);
        return;
    }
    double width = m->tile_size / circle_of(m, level) * 2 * M_PI;
    *west = x * width - M_PI;
    *east = *west + width;
    *north = lat_of(m, level, (double)y * m->tile_size);
    *south = lat_of(m, level, (double)(y + 1) * m->tile_size);
}

// The rows of the raster, and their weights, that one row of the planet tile is made of.
struct taps {
    int first, count;
    double first_weight, last_weight; // of the others: 1
};

// Parts of rows stand for their whole rows' values, which moves the mean: moved back to `middle` by
// the outer two. Two rows become the linear interpolation.
static struct taps centred(struct taps t, double middle)
{
    double n = t.count, inner = n - 2, all = t.first_weight + t.last_weight + inner;
    double mean = (t.first_weight * 0.5 + t.last_weight * (n - 0.5) + inner * n / 2) / all;
    double move = (middle - t.first - mean) * all / (n - 1);
    t.first_weight -= move;
    t.last_weight += move;
    return t;
}

static struct taps taps_of(const tile_matrix *m, tile_id id, const tile_span *span, int row)
{
    double step = grid_step_lat(id.zoom), north, lat;
    lat = grid_lat(id.zoom, (int64_t)TILE_SIZE * id.row + row);
    north = lat + step / 2;
    double offset = (double)span->y0 * m->tile_size;
    double a = row_of(m, span->level, north) - offset,
           b = row_of(m, span->level, north - step) - offset;
    int rows = (span->y1 - span->y0) * m->tile_size;
    if (b - a < 1 - 1e-6) { // wider than ours: linear between centres, and on beyond the outermost
        double at = row_of(m, span->level, lat) - offset - 0.5;
        double low = clamp_double(floor(at), 0, rows - 2);
        return (struct taps){(int)low, 2, 1 - (at - low), at - low};
    }
    a = fmax(a, 0);
    b = fmin(b, rows);
    if (!(b - a > 1e-6)) return (struct taps){0};
    int first = (int)floor(a + 1e-9), last = (int)ceil(b - 1e-9) - 1;
    first = clamp_int(first, 0, rows - 1);
    last = clamp_int(last, first, rows - 1);
    if (first == last) return (struct taps){first, 1, 1, 1};
    return centred((struct taps){first, last - first + 1, first + 1 - a, b - last}, (a + b) / 2);
}

static double weight_of(const struct taps *t, int i)
{
    return i == 0 ? t->first_weight : i == t->count - 1 ? t->last_weight : 1;
}

// First column of the raster for the planet tile, and columns to one.
static int raster_columns(const tile_matrix *m, tile_id id, const tile_span *span, int *ratio)
{
    int64_t first;
    columns_of(m, id, span->level, &first, ratio);
    return (int)(first - (int64_t)span->x0 * m->tile_size);
}

static float mean_height(const float *raster, int width, const struct taps *t, int col, int ratio)
{
    double sum = 0, weights = 0, all = 0;
    for (int i = 0; i < t->count; i++) {
        const float *row = raster + (size_t)(t->first + i) * (size_t)width + (size_t)col;
        double w = weight_of(t, i);
        for (int c = 0; c < ratio; c++) {
            all += w;
            if (isnan(row[c])) continue;
            sum += w * (double)row[c];
            weights += w;
        }
    }
    return weights > 0.5 * all ? (float)(sum / weights) : NAN;
}

void matrix_resample_heights(const tile_matrix *m, tile_id id, const tile_span *span,
                             const float *raster, float *out)
{
    int width = (span->x1 - span->x0) * m->tile_size, ratio;
    if (m->projection == MATRIX_PLANET) {
        memcpy(out, raster, sizeof *out * TILE_SIZE * TILE_SIZE);
        return;
    }
    int first = raster_columns(m, id, span, &ratio);
    for (int row = 0; row < TILE_SIZE; row++) {
        struct taps t = taps_of(m, id, span, row);
        for (int col = 0; col < TILE_SIZE; col++)
            out[row * TILE_SIZE + col] =
                t.count ? mean_height(raster, width, &t, first + col * ratio, ratio) : NAN;
    }
}

// IEC 61966-2-1.
static float linear_of(int code)
{
    float e = (float)code / 255;
    return e <= 0.04045f ? e / 12.92f : powf((e + 0.055f) / 1.055f, 2.4f);
}

static int code_of(float l)
{
    float e = l <= 0.0031308f ? l * 12.92f : 1.055f * powf(l, 1 / 2.4f) - 0.055f;
    return (int)(clamp_double((double)e, 0, 1) * 255 + 0.5);
}

// Encoded and multiplied by the coverage.
static void put_pixel(const float light[3], float coverage, float all, uint8_t *out)
{
    int a = all > 0 ? clamp_int((int)(coverage / all * 255 + 0.5f), 0, 255) : 0;
    for (int c = 0; c < 3; c++)
        out[c] = a ? (uint8_t)((code_of(light[c] / coverage) * a + 127) / 255) : 0;
    out[3] = (uint8_t)a;
}

static void mean_pixel(const uint8_t *raster, int width, const struct taps *t, int col, int ratio,
                       const float linear[256], uint8_t *out)
{
    float light[3] = {0}, coverage = 0, all = 0;
    for (int i = 0; i < t->count; i++) {
        const uint8_t *p = raster + ((size_t)(t->first + i) * (size_t)width + (size_t)col) * 4;
        float w = (float)weight_of(t, i);
        for (int c = 0; c < ratio; c++, p += 4) {
            float a = w * (float)p[3] / 255;
            for (int k = 0; k < 3; k++) light[k] += a * linear[p[k]];
            coverage += a;
            all += w;
        }
    }
    put_pixel(light, coverage, all, out);
}

// One row of the raster alone is taken as it is: there and back through linear light is exact, but
// slow.
static void copy_pixel(const uint8_t *p, uint8_t *out)
{
    for (int c = 0; c < 3; c++) out[c] = (uint8_t)((p[c] * p[3] + 127) / 255);
    out[3] = p[3];
}

void matrix_resample_pixels(const tile_matrix *m, tile_id id, const tile_span *span,
                            const uint8_t *raster, uint8_t *out)
{
    int width = (span->x1 - span->x0) * m->tile_size, ratio = 1, first = 0;
    bool own = m->projection == MATRIX_PLANET;
    float linear[256];
    for (int i = 0; i < 256; i++) linear[i] = linear_of(i);
    if (!own) first = raster_columns(m, id, span, &ratio);
    for (int row = 0; row < TILE_SIZE; row++) {
        struct taps t = own ? (struct taps){row, 1, 1, 1} : taps_of(m, id, span, row);
        for (int col = 0; col < TILE_SIZE; col++, out += 4) {
            size_t at = ((size_t)t.first * (size_t)width + (size_t)(first + col * ratio)) * 4;
            if (t.count == 1 && ratio == 1) copy_pixel(raster + at, out);
            else if (t.count)
                mean_pixel(raster, width, &t, first + col * ratio, ratio, linear, out);
            else memset(out, 0, 4);
        }
    }
}
