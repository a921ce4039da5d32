// De-banding. Invariant: after every pass each height lies in the interval of its sample's code.
#include "planet/atlas.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/pool.h"
#include "base/vec.h"

// Codes: a grey, or that grey where it is a summit (PEAK) or a pit (PIT), or flat sea. STANDS_OUT:
// greys by which those differ from the mean of their eight neighbours; JPEG makes lesser ones of
// its own.
enum { PEAK = 256, PIT = 512, SEA = 768, CODES = 769, BAND_ROWS = 64, STANDS_OUT = 2 };

// Distances, in samples, at which the passes average; wide bands of one grey need the wide ones
// first.
static const int distances[] = {16, 8, 4, 2, 1, 1};
enum { PASSES = sizeof distances / sizeof *distances };

struct heights {
    atlas_params params;
    float low[CODES], high[CODES], start[CODES];
    uint16_t *codes;
    float *from, *to;
    int distance;
};

struct band {
    struct heights *heights;
    int row;
};

static void fill_tables(struct heights *h)
{
    const atlas_table *t = h->params.table;
    for (int g = 0; g < 256; g++) {
        float low = t->low[g], high = t->high[g];
        // Land on a coast stays above the sea, a hollow below it.
        if (g == ATLAS_SEA_GREY + 1) low = high / 8;
        if (g == ATLAS_SEA_GREY) high = low / 8;
        h->low[g] = h->low[PIT + g] = low;
        h->high[g] = h->high[PEAK + g] = high;
        h->low[PEAK + g] = h->high[PIT + g] = t->metres[g];
        h->start[g] = h->start[PEAK + g] = h->start[PIT + g] = t->metres[g];
    }
}

static uint16_t code_of(const struct heights *h, int x, int y)
{
    int width = h->params.width, height = h->params.height;
    size_t at = (size_t)y * (size_t)width + (size_t)x;
    if (h->params.sea && h->params.sea[at]) return SEA;
    int g = h->params.greys[at], higher = 0, lower = 0, sum = 0;
    for (int dy = -1; dy <= 1; dy++) {
        int ny = y + dy;
        if (ny < 0 || ny >= height) continue;
        for (int dx = -1; dx <= 1; dx++) {
            int nx = x + dx < 0 ? width - 1 : x + dx >= width ? 0 : x + dx;
            int n = h->params.greys[(size_t)ny * (size_t)width + (size_t)nx];
            higher += n > g;
            lower += n < g;
            sum += n - g;
        }
    }
    if (lower == 8 && sum <= -8 * STANDS_OUT) return (uint16_t)(PEAK + g);
    if (higher == 8 && sum >= 8 * STANDS_OUT) return (uint16_t)(PIT + g);
    return (uint16_t)g;
}

static void start_band(void *arg, int worker)
{
    (void)worker;
    struct band *b = arg;
    struct heights *h = b->heights;
    int last = b->row + BAND_ROWS < h->params.height ? b->row + BAND_ROWS : h->params.height;
    for (int y = b->row; y < last; y++) {
        size_t row = (size_t)y * (size_t)h->params.width;
        for (int x = 0; x < h->params.width; x++) {
            uint16_t code = code_of(h, x, y);
            h->codes[row + (size_t)x] = code;
            h->to[row + (size_t)x] = h->start[code];
        }
    }
}

static inline float hold(const struct heights *h, uint16_t code, float v)
{
    float low = h->low[code], high = h->high[code];
    return v < low ? low : v > high ? high : v;
}

static inline float blend(float a, float b, float c, float d, float e)
{
    return 0.0625f * (10 * c + 4 * (b + d) - (a + e));
}

// Row y + offset of the pass's input; beyond a pole the outermost row.
static const float *row_at(const struct heights *h, int y)
{
    int last = h->params.height - 1;
    y = y < 0 ? 0 : y > last ? last : y;
    return h->from + (size_t)y * (size_t)h->params.width;
}

// Columns as far apart on the ground as `distance` rows, at most a sixteenth of the circle.
static int columns_apart(const struct heights *h, int y)
{
    double from_equator = fabs((y + 0.5) / h->params.height - 0.5) * M_PI;
    double columns = round(h->distance / cos(from_equator));
    int most = h->params.width / 16;
    return columns < most ? (int)columns : most;
}

// (-1 4 10 4 -1)/16 in both directions at the pass's distance on the ground, which leaves cubic
// slopes and summits as they are and takes the finest steps away; held in the interval. `line` has
// room for 5/4 of a row.
static void smooth_row(const struct heights *h, int y, float *line)
{
    int width = h->params.width, d = h->distance, dx = columns_apart(h, y);
    const float *a = row_at(h, y - 2 * d), *b = row_at(h, y - d), *c = row_at(h, y);
    const float *e = row_at(h, y + d), *f = row_at(h, y + 2 * d);
    float *sums = line + 2 * dx;
    for (int x = 0; x < width; x++) sums[x] = blend(a[x], b[x], c[x], e[x], f[x]);
    for (int x = 0; x < 2 * dx; x++) {
        sums[-1 - x] = sums[width - 1 - x];
        sums[width + x] = sums[x];
    }
    const uint16_t *code = h->codes + (size_t)y * (size_t)width;
    float *to = h->to + (size_t)y * (size_t)width;
    for (int x = 0; x < width; x++)
        to[x] =
            hold(h, code[x],
                 blend(sums[x - 2 * dx], sums[x - dx], sums[x], sums[x + dx], sums[x + 2 * dx]));
}

static void smooth_band(void *arg, int worker)
{
    (void)worker;
    struct band *b = arg;
    struct heights *h = b->heights;
    float *line = NEW_ARRAY(float, (size_t)h->params.width * 5 / 4 + 4);
    for (int y = b->row; y < b->row + BAND_ROWS && y < h->params.height; y++)
        smooth_row(h, y, line);
    free(line);
}

static void run_bands(struct heights *h, struct pool *pool, pool_job job, struct band *bands)
{
    int count = 0;
    for (int row = 0; row < h->params.height; row += BAND_ROWS) {
        bands[count] = (struct band){h, row};
        pool_submit(pool, job, &bands[count++]);
    }
    pool_drain(pool);
}

static bool stopped(const struct heights *h, int passes)
{
    const atlas_params *p = &h->params;
    return p->progress && p->progress(p->user, (double)passes / (PASSES + 1));
}

status atlas_make_heights(const atlas_params *params, float *heights)
{
    struct heights *h = NEW(struct heights);
    h->params = *params;
    fill_tables(h);
    size_t count = (size_t)params->width * (size_t)params->height;
    float *other = malloc(count * sizeof *other);
    h->codes = malloc(count * sizeof *h->codes);
    status s = OK;
    if (!other || !h->codes) {
        log_error("out of memory for the heights of %d x %d samples", params->width,
                  params->height);
        s = ERR_MEMORY;
    } else {
        struct pool *pool = pool_create(params->threads, 256);
        struct band *bands = NEW_ARRAY(struct band, (size_t)(params->height / BAND_ROWS + 1));
        // The last pass must end in `heights`.
        h->from = PASSES % 2 ? heights : other;
        h->to = PASSES % 2 ? other : heights;
        run_bands(h, pool, start_band, bands);
        for (int i = 0; i < PASSES && !s; i++) {
            float *swap = h->from;
            h->from = h->to;
            h->to = swap;
            h->distance = distances[i];
            run_bands(h, pool, smooth_band, bands);
            if (stopped(h, i + 2)) s = ERR_CANCELLED;
        }
        free(bands);
        pool_destroy(&pool);
    }
    free(other);
    free(h->codes);
    free(h);
    return s;
}
