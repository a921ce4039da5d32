#include "reference/field.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"

// Maxima of blocks of 4 x 4 samples, of 8 x 8, and so on to the whole tile.
enum {
    FINEST_BLOCK = 2,
    COARSEST_BLOCK = 8,
    TILE_MAXIMA = 64 * 64 + 32 * 32 + 16 * 16 + 8 * 8 + 4 * 4 + 2 * 2 + 1,
    MAX_TILES = 32768,
    BOX_TILES = 4 // a box over more tiles is bounded by the whole field
};

// Tiles [first, first + count) of a tile row, columns counted around the circle.
struct tile_row {
    int first, count, cols;
    size_t at;
};

struct field {
    struct pyramid *pyramid;
    int zoom, first_row, rows; // tile rows held
    struct tile_row *row;
    size_t tiles;
    float *maxima, *low;
    double min, max;
    _Atomic status error;
};

int field_zoom(const struct field *f)
{
    return f->zoom;
}

geo_ellipsoid field_ellipsoid(const struct field *f)
{
    return pyramid_meta(f->pyramid)->ellipsoid;
}

void field_range(const struct field *f, double *min, double *max)
{
    *min = f->min;
    *max = f->max;
}

static double deg(double rad)
{
    return rad * (180 / M_PI);
}

static int wrap(int64_t value, int64_t count)
{
    int64_t r = value % count;
    return (int)(r < 0 ? r + count : r);
}

// Half the angle of the cap on the unit sphere of reduced latitude. Heights in [low, high] lie
// there at radii in [1 + low / b, 1 + high / b]; a ray that comes below the first has met the
// ground.
static double cap_angle(geo_ellipsoid e, const double eye[3], double low, double high)
{
    double inner = 1 + fmin(low, 0) / e.b, outer = 1 + fmax(high, 0) / e.b;
    double r =
        sqrt((eye[0] * eye[0] + eye[1] * eye[1]) / (e.a * e.a) + eye[2] * eye[2] / e.b / e.b);
    return acos(fmin(1, inner / fmax(r, inner))) + acos(inner / outer) + 1e-6;
}

// Which tiles lie in the rectangle about the cap.
static void list_tiles(struct field *f, const double eye[3], double angle)
{
    geo_ellipsoid e = field_ellipsoid(f);
    double lat = atan2(eye[2] / e.b, hypot(eye[0], eye[1]) / e.a), lon = atan2(eye[1], eye[0]);
    double north = fmin(lat + angle, M_PI / 2), south = fmax(lat - angle, -M_PI / 2);
    bool pole = lat + angle >= M_PI / 2 || lat - angle <= -M_PI / 2;
    double half = pole ? M_PI : asin(fmin(1, sin(angle) / cos(lat))) + 1e-6;
    double step = grid_step_lat(f->zoom) * TILE_SIZE;
    north = atan2(sin(north) * e.a, cos(north) * e.b);
    south = atan2(sin(south) * e.a, cos(south) * e.b);
    int last = grid_rows(f->zoom) - 1;
    int first = (int)clamp_double(floor((M_PI / 2 - north) / step) - 1, 0, last);
    last = (int)clamp_double(floor((M_PI / 2 - south) / step) + 1, 0, last);
    f->first_row = first;
    f->rows = last - first + 1;
    f->row = NEW_ARRAY(struct tile_row, (size_t)f->rows);
    f->tiles = 0;
    for (int i = 0; i < f->rows; i++) {
        struct tile_row *r = &f->row[i];
        r->cols = grid_cols(f->zoom, first + i);
        double width = 2 * M_PI / r->cols;
        double west = floor((lon - half + M_PI) / width) - 1,
               east = floor((lon + half + M_PI) / width) + 1;
        bool all = east - west + 1 >= r->cols;
        r->first = all ? 0 : (int)west;
        r->count = all ? r->cols : (int)(east - west + 1);
        r->at = f->tiles;
        f->tiles += (size_t)r->count;
    }
}

static void reduce_tile(const float *heights, float *out)
{
    for (int k = FINEST_BLOCK; k <= COARSEST_BLOCK; k++) {
        int n = TILE_SIZE >> k, m = k == FINEST_BLOCK ? 1 << k : 2;
        const float *from = k == FINEST_BLOCK ? heights : out - 4 * n * n;
        for (int i = 0; i < n * n; i++) {
            const float *block = from + (size_t)(i / n) * m * n * m + (size_t)(i % n) * m;
            float high = block[0];
            for (int j = 1; j < m * m; j++) high = fmaxf(high, block[j / m * n * m + j % m]);
            out[i] = high;
        }
        out += n * n;
    }
}

struct scan {
    struct field *field;
    int row;
};

static void scan_row(void *arg, int worker)
{
    struct scan *scan = arg;
    struct field *f = scan->field;
    const struct tile_row *r = &f->row[scan->row];
    (void)worker;
    for (int i = 0; i < r->count && !f->error; i++) {
        tile_id id = {LAYER_HEIGHT, f->zoom, f->first_row + scan->row, wrap(r->first + i, r->cols)};
        const pyramid_tile *tile;
        status s = pyramid_acquire(f->pyramid, id, &tile);
        if (s) {
            f->error = s;
            return;
        }
        reduce_tile(tile->heights, f->maxima + (r->at + (size_t)i) * TILE_MAXIMA);
        f->low[r->at + (size_t)i] = tile->min;
        pyramid_release(f->pyramid, &tile);
    }
}

static status scan_tiles(struct field *f, struct pool *pool, const reference_progress *progress)
{
    f->maxima = malloc(f->tiles * TILE_MAXIMA * sizeof *f->maxima);
    f->low = malloc(f->tiles * sizeof *f->low);
    if (!f->maxima || !f->low) {
        log_error("reference: out of memory for %zu tiles of zoom %d", f->tiles, f->zoom);
        return ERR_MEMORY;
    }
    struct scan *scans = NEW_ARRAY(struct scan, (size_t)f->rows);
    bool cancelled = false;
    for (int i = 0; i < f->rows && !cancelled; i++) {
        scans[i] = (struct scan){f, i};
        pool_submit(pool, scan_row, &scans[i]);
        cancelled = progress->report && progress->report(progress->user, 0);
    }
    pool_drain(pool);
    free(scans);
    if (f->error || cancelled) return f->error ? f->error : ERR_CANCELLED;
    f->min = INFINITY;
    f->max = -INFINITY;
    for (size_t i = 0; i < f->tiles; i++) {
        f->min = fmin(f->min, f->low[i]);
        f->max = fmax(f->max, f->maxima[(i + 1) * TILE_MAXIMA - 1]);
    }
    return OK;
}

static void forget_tiles(struct field *f)
{
    free(f->row);
    free(f->maxima);
    free(f->low);
    f->row = NULL;
    f->maxima = f->low = NULL;
}

// The cap for heights in [low, high]; when the ground in it goes beyond them, again with more.
static status find_tiles(struct field *f, const double eye[3], struct pool *pool,
                         const reference_progress *progress)
{
    const struct planet_meta *m = pyramid_meta(f->pyramid);
    double slack = 100 + 0.1 * (m->height_max - m->height_min), low, high;
    status s;
    do {
        low = m->height_min - slack;
        high = m->height_max + slack;
        forget_tiles(f);
        list_tiles(f, eye, cap_angle(m->ellipsoid, eye, low, high));
        if (f->tiles > MAX_TILES) {
            log_error("reference: %zu tiles of zoom %d are within the horizon, more than %d "
                      "(--zoom: a coarser one)",
                      f->tiles, f->zoom, MAX_TILES);
            return ERR_ARGUMENT;
        }
        s = scan_tiles(f, pool, progress);
        slack *= 4;
    } while (!s && (f->min < low || f->max > high));
    return s;
}

status field_create(struct pyramid *pyramid, int zoom, const double eye[3], struct pool *pool,
                    const reference_progress *progress, struct field **out)
{
    struct field *f = NEW(struct field);
    f->pyramid = pyramid;
    f->zoom = zoom;
    status s = find_tiles(f, eye, pool, progress);
    if (s) field_destroy(&f);
    *out = f;
    return s;
}

void field_destroy(struct field **field)
{
    if (!*field) return;
    forget_tiles(*field);
    free(*field);
    *field = NULL;
}

// Samples [r0, r1] x [c0, c1] of one tile, by the blocks of a size that few cover.
static float tile_max(const float *maxima, int r0, int r1, int c0, int c1)
{
    int k = FINEST_BLOCK, n = TILE_SIZE >> FINEST_BLOCK;
    while (k < COARSEST_BLOCK && ((r1 >> k) - (r0 >> k) > 2 || (c1 >> k) - (c0 >> k) > 2)) {
        maxima += n * n;
        n >>= 1;
        k++;
    }
    float high = -INFINITY;
    for (int r = r0 >> k; r <= r1 >> k; r++)
        for (int c = c0 >> k; c <= c1 >> k; c++) high = fmaxf(high, maxima[r * n + c]);
    return high;
}

// Samples of rows [r0, r1] of one tile row that matter between two longitudes.
static double row_max(const struct field *f, int tile_row, int r0, int r1, double west, double east)
{
    int i = tile_row - f->first_row;
    if (i < 0 || i >= f->rows) return -INFINITY;
    const struct tile_row *r = &f->row[i];
    double width = (double)r->cols * TILE_SIZE;
    int64_t c0 = (int64_t)floor((west / 360 + 0.5) * width - 0.5),
            c1 = (int64_t)floor((east / 360 + 0.5) * width - 0.5) + 1;
    if (c1 - c0 >= (int64_t)BOX_TILES * TILE_SIZE) return f->max;
    double high = -INFINITY;
    for (int64_t c = c0; c <= c1;) {
        int64_t tile = (c >= 0 ? c : c - TILE_SIZE + 1) / TILE_SIZE;
        int64_t last =
            tile * TILE_SIZE + TILE_SIZE - 1 < c1 ? tile * TILE_SIZE + TILE_SIZE - 1 : c1;
        int at = wrap(tile - r->first, r->cols);
        if (at < r->count)
            high =
                fmax(high, tile_max(f->maxima + (r->at + (size_t)at) * TILE_MAXIMA, r0, r1,
                                    (int)(c - tile * TILE_SIZE), (int)(last - tile * TILE_SIZE)));
        c = last + 1;
    }
    return high;
}

// Beyond a pole the field goes on as the row as far before it on the opposite meridian.
double field_max(const struct field *f, const field_box *box)
{
    double step = deg(grid_step_lat(f->zoom)), high = -INFINITY;
    int64_t rows = (int64_t)grid_rows(f->zoom) * TILE_SIZE;
    int64_t r0 = (int64_t)floor((90 - box->north) / step - 0.5),
            r1 = (int64_t)floor((90 - box->south) / step - 0.5) + 1;
    if (r1 - r0 >= (int64_t)BOX_TILES * TILE_SIZE) return f->max;
    if (r0 < 0) high = row_max(f, 0, 0, 0, box->west + 180, box->east + 180);
    if (r1 >= rows)
        high = fmax(high, row_max(f, (int)(rows / TILE_SIZE) - 1, TILE_SIZE - 1, TILE_SIZE - 1,
                                  box->west + 180, box->east + 180));
    r0 = r0 < 0 ? 0 : r0;
    r1 = r1 >= rows ? rows - 1 : r1;
    for (int64_t r = r0; r <= r1;) {
        int64_t tile = r / TILE_SIZE, last = tile * TILE_SIZE + TILE_SIZE - 1;
        if (last > r1) last = r1;
        high = fmax(high, row_max(f, (int)tile, (int)(r % TILE_SIZE), (int)(last % TILE_SIZE),
                                  box->west, box->east));
        r = last + 1;
    }
    return high;
}

bool field_box_holds(const field_box *o, const field_box *i)
{
    return i->south >= o->south && i->north <= o->north && i->west >= o->west && i->east <= o->east;
}
