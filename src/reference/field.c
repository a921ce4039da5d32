#include "reference/field.h"

#include <math.h>
#include <stdlib.h>

#include "base/log.h"
#include "base/memory.h"
#include "reference/field_tiles.h"

enum {
    BOX_TILES = 4, // a box over more tiles is bounded by all that is in sight
    SCAN_TILES = 16
};

int field_zoom(const struct field *f)
{
    return f->params.zoom;
}

geo_ellipsoid field_ellipsoid(const struct field *f)
{
    return pyramid_meta(f->params.pyramid)->ellipsoid;
}

size_t field_tiles(const struct field *f)
{
    return f->tiles;
}

void field_range(const struct field *f, double *min, double *max)
{
    *min = f->min;
    *max = f->max;
}

double field_bend(const struct field *f)
{
    return f->bend;
}

int field_order(const struct field *f)
{
    return f->params.bicubic ? PATCH_CUBIC : PATCH_LINEAR;
}

static double deg(double rad)
{
    return rad * (180 / M_PI);
}

// The greatest of each block; of the depths, with `sign` -1.
static void reduce_tile(const float *heights, float sign, float *out)
{
    for (int k = FIELD_FINEST_BLOCK; k <= FIELD_COARSEST_BLOCK; k++) {
        int n = TILE_SIZE >> k, m = k == FIELD_FINEST_BLOCK ? 1 << k : 2;
        bool finest = k == FIELD_FINEST_BLOCK;
        const float *from = finest ? heights : out - 4 * n * n;
        float s = finest ? sign : 1;
        for (int i = 0; i < n * n; i++) {
            const float *block = from + (size_t)(i / n) * m * n * m + (size_t)(i % n) * m;
            float high = s * block[0];
            for (int j = 1; j < m * m; j++) high = fmaxf(high, s * block[j / m * n * m + j % m]);
            out[i] = high;
        }
        out += n * n;
    }
}

// How far each block's extreme lies above the lowest sample, or with `sign` -1 below the highest.
static status keep_extremes(const struct field_tile *t, const float *heights, float sign,
                            uint16_t **out)
{
    float extremes[FIELD_BLOCKS];
    uint16_t *kept = malloc(FIELD_BLOCKS * sizeof *kept);
    *out = kept;
    if (!kept) return ERR_MEMORY;
    reduce_tile(heights, sign, extremes);
    double unit = field_tile_unit(t), base = sign > 0 ? (double)t->min : -(double)t->max;
    for (int i = 0; i < FIELD_BLOCKS; i++)
        kept[i] = (uint16_t)fmin(ceil(((double)extremes[i] - base) / unit), 65535);
    return OK;
}

// Within the tile, less what rounding of the samples alone can make.
static float bend_of(const float *h, float magnitude)
{
    float most = 0;
    for (int r = 0; r < TILE_SIZE; r++, h += TILE_SIZE)
        for (int c = 1; c < TILE_SIZE - 1; c++) {
            most = fmaxf(most, fabsf(h[c - 1] - 2 * h[c] + h[c + 1]));
            if (r > 0 && r < TILE_SIZE - 1)
                most = fmaxf(most, fabsf(h[c - TILE_SIZE] - 2 * h[c] + h[c + TILE_SIZE]));
        }
    return fmaxf(0, most - 4 * magnitude * 0x1p-23f);
}

struct scan {
    struct field *field;
    size_t first, count;
};

static void scan_some(void *arg, int worker)
{
    struct scan *scan = arg;
    struct field *f = scan->field;
    (void)worker;
    for (size_t i = 0; i < scan->count && !f->error; i++) {
        struct field_tile *t = &f->tile[scan->first + i];
        const pyramid_tile *tile;
        status s = pyramid_acquire(f->params.pyramid, t->id, &tile);
        if (!s) {
            t->min = tile->min;
            t->max = tile->max;
            t->bend = bend_of(tile->heights, fmaxf(fabsf(t->min), fabsf(t->max)));
            bool flat = !(t->max > t->min);
            if (!flat) s = keep_extremes(t, tile->heights, 1, &t->maxima);
            if (!flat && !s && f->params.bicubic)
                s = keep_extremes(t, tile->heights, -1, &t->minima);
            pyramid_release(f->params.pyramid, &tile);
        }
        if (s) f->error = s;
    }
}

static void find_range(struct field *f)
{
    f->bend = 0;
    f->min = f->tiles ? INFINITY : 0;
    f->max = f->tiles ? -INFINITY : 0;
    for (size_t i = 0; i < f->tiles; i++) {
        f->min = fmin(f->min, f->tile[i].min);
        f->max = fmax(f->max, f->tile[i].max);
        f->bend = fmax(f->bend, f->tile[i].bend);
    }
    double beyond = patch_overshoot(field_order(f)) * (f->max - f->min);
    f->max += beyond;
    f->min -= beyond;
}

static status scan_tiles(struct field *f, struct pool *pool, const reference_progress *progress)
{
    size_t jobs = (f->tiles + SCAN_TILES - 1) / SCAN_TILES;
    struct scan *scans = NEW_ARRAY(struct scan, jobs + 1);
    bool cancelled = false;
    for (size_t i = 0; i < jobs && !cancelled && !f->error; i++) {
        size_t first = i * SCAN_TILES, left = f->tiles - first;
        scans[i] = (struct scan){f, first, left < SCAN_TILES ? left : SCAN_TILES};
        pool_submit(pool, scan_some, &scans[i]);
        cancelled = progress->report && progress->report(progress->user, (double)i / (double)jobs);
    }
    pool_drain(pool);
    free(scans);
    if (f->error == ERR_MEMORY)
        log_error("reference: out of memory for %zu tiles of zoom %d", f->tiles, f->params.zoom);
    if (f->error || cancelled) return f->error ? f->error : ERR_CANCELLED;
    find_range(f);
    return OK;
}

// Heights that ground made below the data, and between samples, may have.
static double first_slack(const struct field *f)
{
    const struct planet_meta *m = pyramid_meta(f->params.pyramid);
    double range = m->height_max - m->height_min, below = 100 + 0.1 * range;
    return below + patch_overshoot(field_order(f)) * (range + 2 * below);
}

static status report_count(const struct field *f, status s)
{
    if (s == ERR_ARGUMENT)
        log_error("reference: more than %d tiles of zoom %d are in sight (--zoom: a coarser one, "
                  "or auto)",
                  FIELD_MAX_TILES, f->params.zoom);
    else if (s) log_error("reference: out of memory for the tiles of zoom %d", f->params.zoom);
    return s;
}

// For heights in [low, high]; when the ground in sight goes beyond them, again with more.
static status find_tiles(struct field *f, struct pool *pool, const reference_progress *progress)
{
    const struct planet_meta *m = pyramid_meta(f->params.pyramid);
    double slack = first_slack(f), low, high;
    status s;
    do {
        low = m->height_min - slack;
        high = m->height_max + slack;
        field_forget_tiles(f);
        s = report_count(f, field_list_tiles(f, low, high));
        if (!s) s = scan_tiles(f, pool, progress);
        slack *= 4;
    } while (!s && (f->min < low || f->max > high));
    return s;
}

size_t field_count_tiles(const field_params *params)
{
    struct field f = {.params = *params};
    const struct planet_meta *m = pyramid_meta(params->pyramid);
    double slack = first_slack(&f);
    status s = field_list_tiles(&f, m->height_min - slack, m->height_max + slack);
    size_t count = s ? SIZE_MAX : f.tiles;
    field_forget_tiles(&f);
    return count;
}

status field_create(const field_params *params, struct pool *pool,
                    const reference_progress *progress, struct field **out)
{
    struct field *f = NEW(struct field);
    f->params = *params;
    status s = find_tiles(f, pool, progress);
    if (s) field_destroy(&f);
    *out = f;
    return s;
}

void field_destroy(struct field **field)
{
    if (!*field) return;
    field_forget_tiles(*field);
    free(*field);
    *field = NULL;
}

// Of samples: none exceeds `high`, and when the field is bicubic none lies below `low`.
struct extremes {
    double low, high;
};

static const struct extremes no_samples = {INFINITY, -INFINITY};

static void widen(struct extremes *e, struct extremes by)
{
    e->low = fmin(e->low, by.low);
    e->high = fmax(e->high, by.high);
}

static int greatest(const uint16_t *blocks, int n, int r0, int r1, int c0, int c1)
{
    int most = 0;
    for (int r = r0; r <= r1; r++)
        for (int c = c0; c <= c1; c++) most = blocks[r * n + c] > most ? blocks[r * n + c] : most;
    return most;
}

// Samples [r0, r1] x [c0, c1] of one tile, by the blocks of a size that few cover.
static struct extremes tile_extremes(const struct field_tile *t, int r0, int r1, int c0, int c1)
{
    int k = FIELD_FINEST_BLOCK, n = TILE_SIZE >> FIELD_FINEST_BLOCK;
    size_t at = 0;
    struct extremes e = {t->min, t->max};
    while (k < FIELD_COARSEST_BLOCK && ((r1 >> k) - (r0 >> k) > 2 || (c1 >> k) - (c0 >> k) > 2)) {
        at += (size_t)n * (size_t)n;
        n >>= 1;
        k++;
    }
    double unit = field_tile_unit(t);
    r0 >>= k;
    r1 >>= k;
    c0 >>= k;
    c1 >>= k;
    if (t->maxima) e.high = t->min + greatest(t->maxima + at, n, r0, r1, c0, c1) * unit;
    if (t->minima) e.low = t->max - greatest(t->minima + at, n, r0, r1, c0, c1) * unit;
    return e;
}

static const struct field_tile *tile_at(const struct field *f, const struct field_row *r,
                                        int64_t col)
{
    int at = field_wrap(col - r->first, r->cols);
    int32_t found = at < r->count ? f->index[r->at + (size_t)at] : -1;
    return found < 0 ? NULL : &f->tile[found];
}

// Samples of rows [r0, r1] of one tile row that matter between two longitudes. A tile that was not
// read is not below any ray in sight, however the box reaches over it.
static struct extremes row_extremes(const struct field *f, int tile_row, int r0, int r1,
                                    double west, double east)
{
    struct extremes e = no_samples;
    int i = tile_row - f->first_row, beside = field_order(f) / 2 - 1;
    if (i < 0 || i >= f->rows) return e;
    const struct field_row *r = &f->row[i];
    double width = (double)r->cols * TILE_SIZE;
    int64_t c0 = (int64_t)floor((west / 360 + 0.5) * width - 0.5) - beside,
            c1 = (int64_t)floor((east / 360 + 0.5) * width - 0.5) + 1 + beside;
    if (c1 - c0 >= (int64_t)BOX_TILES * TILE_SIZE) return (struct extremes){f->min, f->max};
    for (int64_t c = c0; c <= c1;) {
        int64_t tile = (c >= 0 ? c : c - TILE_SIZE + 1) / TILE_SIZE, first = tile * TILE_SIZE;
        int64_t last = first + TILE_SIZE - 1 < c1 ? first + TILE_SIZE - 1 : c1;
        const struct field_tile *t = tile_at(f, r, tile);
        if (t) widen(&e, tile_extremes(t, r0, r1, (int)(c - first), (int)(last - first)));
        c = last + 1;
    }
    return e;
}

// Rows [r0, r1]. Beyond a pole the field goes on as the rows as far before it on the opposite
// meridian: at most two.
static struct extremes rows_extremes(const struct field *f, int64_t r0, int64_t r1, double west,
                                     double east)
{
    int64_t rows = (int64_t)grid_rows(f->params.zoom) * TILE_SIZE;
    struct extremes e = no_samples;
    if (r0 < 0) e = row_extremes(f, 0, 0, (int)(-1 - r0), west + 180, east + 180);
    if (r1 >= rows)
        widen(&e,
              row_extremes(f, (int)(rows / TILE_SIZE) - 1, (int)((2 * rows - 1 - r1) % TILE_SIZE),
                           TILE_SIZE - 1, west + 180, east + 180));
    r0 = r0 < 0 ? 0 : r0;
    r1 = r1 >= rows ? rows - 1 : r1;
    for (int64_t r = r0; r <= r1;) {
        int64_t tile = r / TILE_SIZE, last = tile * TILE_SIZE + TILE_SIZE - 1;
        if (last > r1) last = r1;
        widen(&e, row_extremes(f, (int)tile, (int)(r % TILE_SIZE), (int)(last % TILE_SIZE), west,
                               east));
        r = last + 1;
    }
    return e;
}

double field_max(const struct field *f, const field_box *box)
{
    double step = deg(grid_step_lat(f->params.zoom));
    int beside = field_order(f) / 2 - 1;
    int64_t r0 = (int64_t)floor((90 - box->north) / step - 0.5) - beside,
            r1 = (int64_t)floor((90 - box->south) / step - 0.5) + 1 + beside;
    if (r1 - r0 >= (int64_t)BOX_TILES * TILE_SIZE) return f->max;
    struct extremes e = rows_extremes(f, r0, r1, box->west, box->east);
    if (!(e.high >= e.low)) return -INFINITY;
    return fmin(f->max, e.high + patch_overshoot(field_order(f)) * (e.high - e.low));
}
