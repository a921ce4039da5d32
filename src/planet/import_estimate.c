// A few tiles are made at each zoom that sources have, and coded as they would be in the file. What
// is coarser is made of them, halved again and again and mirrored into whole tiles, so that each
// zoom is measured by ground of its own roughness.
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/memory.h"
#include "planet/codec_bounded.h"
#include "planet/codec_predict.h"
#include "planet/import_base.h"
#include "planet/import_sources.h"
#include "planet/import_under_way.h"

// Looked at of each zoom; how often a tile is halved. Of the database: rows of a tile in its table
// and in the index of bodies, pages, and those of a file with nothing in it.
enum { SAMPLES = TILE_SIZE * TILE_SIZE, LOOKED = 32, HALVINGS = 5 };
enum { ROW_BYTES = 48, PAGE_BYTES = 8192, EMPTY_PAGES = 5 };

// What the sources of one zoom come to, in tiles of their zoom and of those before it.
struct group {
    struct layer sources;
    int zoom;
    uint64_t tiles;
    double stored, filled;      // shares of its tiles, and of the samples of those
    double bytes[HALVINGS + 1]; // of a tile that is full, so many zooms up
    double seconds[HALVINGS + 1];
};

static double thread_cpu_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

// Are the columns of the zoom above the same?
static bool same_columns(tile_id id)
{
    return grid_coalesce(id.zoom, id.row) == 2 * grid_coalesce(id.zoom - 1, id.row / 2);
}

// The pyramid's filter (filter.h) along one axis, for children half a sample, one and a half and
// two and a half off; beyond the tile its last sample stands.
static float halve(const float *plane, int stride, int at)
{
    static const float weights[3] = {0.3866f, 0.1088f, 0.0046f};
    float sum = 0;
    for (int i = 0; i < 3; i++) {
        int before = at - i > 0 ? at - i : 0;
        int after = at + 1 + i < TILE_SIZE ? at + 1 + i : TILE_SIZE - 1;
        sum += weights[i] * (plane[before * stride] + plane[after * stride]);
    }
    return sum;
}

// The part of the tile above that this one is, halved in rows, and in columns where it has wider
// ones; the rest is NaN.
static void put_quarter(tile_id id, const float *plane, float *parent)
{
    bool same = same_columns(id);
    int cols = same ? TILE_SIZE : TILE_SIZE / 2;
    for (int i = 0; i < SAMPLES; i++) parent[i] = NAN;
    parent += id.row % 2 * (TILE_SIZE / 2) * TILE_SIZE + (same ? 0 : id.col % 2 * cols);
    for (int y = 0; y < TILE_SIZE / 2; y++) {
        float row[TILE_SIZE];
        for (int x = 0; x < TILE_SIZE; x++) row[x] = halve(plane + x, TILE_SIZE, 2 * y);
        for (int x = 0; x < cols; x++)
            parent[y * TILE_SIZE + x] = same ? row[x] : halve(row, 1, 2 * x);
    }
}

// The quarter mirrored into the rest of its tile.
static void mirror(tile_id id, float *parent)
{
    int first = id.row % 2 * (TILE_SIZE / 2), half = TILE_SIZE / 2;
    int west = same_columns(id) ? 0 : id.col % 2 * half, cols = same_columns(id) ? TILE_SIZE : half;
    for (int y = 0; y < TILE_SIZE; y++)
        for (int x = 0; x < TILE_SIZE; x++) {
            int v = y / half == first / half ? y : TILE_SIZE - 1 - y;
            int u = cols == TILE_SIZE || x / half == west / half ? x : TILE_SIZE - 1 - x;
            if (u != x || v != y) parent[y * TILE_SIZE + x] = parent[v * TILE_SIZE + u];
        }
}

// The planes of a tile and of what it gives to each zoom above, from the finest on.
struct look {
    const struct import *im;
    struct workshop *workshop;
    int channels, count;
    tile_id ids[HALVINGS + 2];
    float *planes[HALVINGS + 2];
    float *predicted, *scratch;
};

static void halve_all(struct look *l)
{
    for (l->count = 1; l->ids[l->count - 1].zoom > 0 && l->count < HALVINGS + 2; l->count++) {
        tile_id id = l->ids[l->count - 1];
        for (int c = 0; c < l->channels; c++) {
            float *to = l->planes[l->count] + (size_t)c * SAMPLES;
            put_quarter(id, l->planes[l->count - 1] + (size_t)c * SAMPLES, to);
            mirror(id, to);
        }
        l->ids[l->count] = tile_parent(id);
    }
}

// Bytes of one of them in the finished file; the planes become what is read back, which is what the
// one before is predicted from.
static status size_of(struct look *l, int k, double *bytes)
{
    codec_blob body;
    tile_id id = l->ids[k];
    float *planes = l->planes[k];
    *bytes = 0;
    status s = workshop_encode(l->workshop, 0, id, planes, &body);
    bool one_value = !s && body.size <= 8; // stored once for all
    if (!s && !one_value && l->im->max_error > 0 && id.layer == LAYER_HEIGHT) {
        codec_blob_deinit(&body);
        predict_tile(id, k + 1 < l->count ? l->planes[k + 1] : NULL, l->predicted);
        s = bounded_encode(planes, l->predicted, l->im->max_error, &body, l->scratch);
        if (!s) memcpy(planes, l->scratch, SAMPLES * sizeof *planes);
    }
    if (!s && body.size > 8) *bytes = (double)body.size;
    codec_blob_deinit(&body);
    return s;
}

// Adds a tile of the group, and what it gives to each zoom above.
static status look_at(struct look *l, struct group *g, tile_id id, bool *any)
{
    double began = thread_cpu_s();
    status s = workshop_look(l->workshop, 0, id, l->planes[0], any);
    int filled = 0;
    for (int i = 0; *any && i < SAMPLES; i++) filled += !isnan(l->planes[0][i]);
    g->filled += (double)filled / SAMPLES;
    l->ids[0] = id;
    double made = thread_cpu_s() - began; // what a tile takes before it is coded, at any zoom
    if (!s && *any) halve_all(l);
    for (int k = l->count - 1; !s && *any && k >= 0; k--) {
        double bytes;
        began = thread_cpu_s();
        s = size_of(l, k, &bytes);
        if (k > HALVINGS) continue; // is there to predict from
        g->bytes[k] += bytes;
        g->seconds[k] += thread_cpu_s() - began + made;
    }
    return s;
}

static status look_begin(struct look *l)
{
    size_t plane = (size_t)l->channels * SAMPLES;
    float *room = malloc(((HALVINGS + 2) * plane + 2 * SAMPLES) * sizeof *room);
    if (!room) return ERR_MEMORY;
    for (int k = 0; k < HALVINGS + 2; k++) l->planes[k] = room + (size_t)k * plane;
    l->predicted = room + (HALVINGS + 2) * plane;
    l->scratch = l->predicted + SAMPLES;
    return OK;
}

// Evenly spread over the tiles of the group's own zoom.
static status measure(const struct import *im, struct workshop *workshop, struct group *g)
{
    uint64_t every = g->tiles / LOOKED + 1, i = 0;
    double looked = 0, stored = 0;
    tile_id id;
    struct look l = {.im = im, .workshop = workshop, .channels = g->sources.grids[0].channels};
    status s = look_begin(&l);
    struct plan_walk *walk = layer_walk(im, &g->sources, g->zoom);
    while (!s && plan_walk_next(walk, &id)) {
        bool any = false;
        if (i++ % every != every / 2) continue;
        s = look_at(&l, g, id, &any);
        looked++;
        stored += any;
    }
    plan_walk_end(&walk);
    free(l.planes[0]);
    for (int k = 0; k <= HALVINGS; k++) {
        g->bytes[k] /= fmax(g->filled, 1e-9);
        g->seconds[k] /= fmax(stored, 1);
    }
    g->filled /= fmax(stored, 1);
    g->stored = stored / fmax(looked, 1);
    return s;
}

// What a body takes in the database's pages. Of a large one all but a part fills pages of its own;
// small ones share theirs, at whose end half of one is left free in the mean.
static double in_pages(double bytes)
{
    if (bytes > PAGE_BYTES) return bytes + PAGE_BYTES / 8;
    return fmin(PAGE_BYTES, bytes / (1 - bytes / (2 * PAGE_BYTES)));
}

// `count` of the group's tiles at a zoom, of all that it has there. Of the coarser ones all are
// stored.
static void add_tiles(const struct group *g, int zoom, double count, double all,
                      import_estimate *out)
{
    int up = g->zoom - zoom, k = up < HALVINGS ? up : HALVINGS;
    double full = g->filled * (double)g->tiles * g->stored / ldexp(1, 2 * up);
    double stored = up > 0 ? 1 : g->stored, filled = fmin(1, full / fmax(all * stored, 1e-9));
    out->tiles += (uint64_t)(count * stored + 0.5);
    out->samples += (uint64_t)(count * stored + 0.5) * SAMPLES;
    out->bytes += count * stored * (in_pages(g->bytes[k] * filled) + ROW_BYTES);
    out->core_seconds += count * stored * g->seconds[k];
}

static void pick_sources(const struct import *im, const struct layer *l, int zoom, struct group *g)
{
    layer_init(im, l->layer, &g->sources);
    g->zoom = g->sources.max_zoom = zoom;
    g->sources.count = 0;
    for (int i = 0; i < l->count; i++) {
        if (l->grids[i].zoom != zoom) continue;
        g->sources.inputs[g->sources.count] = l->inputs[i];
        g->sources.grids[g->sources.count++] = l->grids[i];
    }
}

// A tile at a zoom counts for the coarsest sources that have a part in it.
static status estimate_layer(const struct import *im, const struct layer *l, import_estimate *out)
{
    status s = OK;
    struct workshop *workshop = layer_workshop(im, l, 1, NULL);
    double counted[GRID_MAX_ZOOM + 1] = {0};
    for (int zoom = 0; !s && zoom <= l->max_zoom; zoom++) {
        struct group g = {0};
        pick_sources(im, l, zoom, &g);
        if (g.sources.count) {
            g.tiles = layer_count(im, &g.sources, zoom);
            s = measure(im, workshop, &g);
        }
        for (int up = 0; !s && g.sources.count && up <= zoom; up++) {
            double all = (double)layer_count(im, &g.sources, up), left = all - counted[up];
            if (left <= 0) continue;
            add_tiles(&g, up, left, all, out);
            counted[up] += left;
        }
        layer_deinit(&g.sources);
    }
    workshop_destroy(&workshop);
    return s;
}

status import_estimate_run(const import_params *p, import_estimate *out)
{
    *out = (import_estimate){0};
    import_list list;
    status s = import_list_init(p->sources, p->source_count, &list);
    struct import im = {.params = p, .inputs = list.inputs, .count = list.count};
    if (!s) s = import_prepare(&im);
    for (int layer = 0; !s && layer < LAYER_COUNT; layer++) {
        struct layer l;
        layer_init(&im, (enum tile_layer)layer, &l);
        if (l.count) s = estimate_layer(&im, &l, out);
        layer_deinit(&l);
    }
    if (!s) out->bytes += EMPTY_PAGES * PAGE_BYTES;
    import_base_close(&im.base);
    free(im.grids);
    import_list_deinit(&list);
    return s;
}
