// A tile of the planet is asked for whole: every server's tile under it at once. One that the
// server does not have makes all of it come from the coarser one, so that there is no hole.
#include "planet/source_remote.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "planet/image_decode.h"

struct source_remote {
    struct source source;
    source_spec spec;
    struct fetcher *fetcher;
    const spec_layer *layers[LAYER_COUNT];
    atomic_uint_fast64_t corrupt, failed;
};

enum { SAMPLES = TILE_SIZE * TILE_SIZE };

static bool is_available(const spec_layer *l, tile_id id)
{
    size_t low = 0, high = l->range_count;
    if (!l->ranges) return true;
    while (low < high) { // the last range that begins at or before the tile
        size_t middle = (low + high) / 2;
        const spec_range *r = &l->ranges[middle];
        bool before = r->zoom != id.zoom ? r->zoom < id.zoom
                      : r->row != id.row ? r->row < id.row
                                         : r->first <= id.col;
        if (before) low = middle + 1;
        else high = middle;
    }
    if (low == 0) return false;
    const spec_range *r = &l->ranges[low - 1];
    return r->zoom == id.zoom && r->row == id.row && id.col <= r->last;
}

static bool remote_has(const struct source *source, tile_id id)
{
    const spec_layer *l = ((const struct source_remote *)source)->layers[id.layer];
    tile_span span;
    return l && matrix_span(&l->matrix, id, &span) && is_available(l, id);
}

// Does the server's tile lie within the bounds that are said?
static bool in_bounds(const spec_layer *l, int level, int x, int y)
{
    double west, south, east, north;
    if (l->west == 0 && l->east == 0 && l->south == 0 && l->north == 0) return true;
    matrix_bounds(&l->matrix, level, x, y, &west, &south, &east, &north);
    if (north <= l->south || south >= l->north) return false;
    bool wraps = l->west > l->east;
    return wraps ? west < l->east || east > l->west : west < l->east && east > l->west;
}

// The bodies under one tile of the planet, in rows from the north; NULL: nothing there.
struct bodies {
    const fetch_body *body[MATRIX_MAX_TILES];
    int count;
};

static size_t body_limit(const spec_layer *l)
{
    return (size_t)l->matrix.tile_size * (size_t)l->matrix.tile_size * 5 + (64 << 10);
}

// Asks for all of them; the worst of the answers, ERR_PENDING before all others.
static status get_bodies(struct source_remote *r, const spec_layer *l, const tile_span *span,
                         struct want *want, struct bodies *out, double *until_s)
{
    status worst = OK;
    char url[SPEC_URL_SIZE];
    *out = (struct bodies){0};
    for (int y = span->y0; y < span->y1; y++)
        for (int x = span->x0; x < span->x1; x++) {
            double until = INFINITY;
            const fetch_body **body = &out->body[out->count++];
            if (!in_bounds(l, span->level, x, y)) continue;
            source_spec_url(l, span->level, x, y, url);
            status s = fetch_get(r->fetcher, url, body_limit(l), want, body, &until);
            *until_s = fmin(*until_s, until);
            if (s == ERR_PENDING || (s && worst != ERR_PENDING)) worst = s;
        }
    if (worst == ERR_PENDING) *until_s = INFINITY;
    return worst;
}

static void release_bodies(struct source_remote *r, struct bodies *b)
{
    for (int i = 0; i < b->count; i++) fetch_release(r->fetcher, &b->body[i]);
}

static void heights_of(const spec_layer *l, const uint8_t *rgba, int count, float *out)
{
    for (int i = 0; i < count; i++, rgba += 4) {
        double v = rgba[0] * 65536.0 + rgba[1] * 256.0 + rgba[2];
        double h = l->encoding == ENCODING_TERRARIUM ? v / 256 - 32768 : v * 0.1 - 10000;
        out[i] = v == 0 || rgba[3] == 0 ? NAN : (float)h;
    }
}

// Copies one decoded tile to its place in the raster of the span.
static void place_tile(const spec_layer *l, const tile_span *span, int index, const void *tile,
                       void *raster)
{
    size_t size = (size_t)l->matrix.tile_size, across = (size_t)(span->x1 - span->x0);
    size_t row = (size_t)index / across * size, col = (size_t)index % across * size;
    for (size_t y = 0; y < size; y++)
        memcpy((char *)raster + ((row + y) * across * size + col) * 4,
               (const char *)tile + y * size * 4, size * 4);
}

static status reject(struct source_remote *r, const spec_layer *l, const tile_span *span, int index,
                     const char *why)
{
    char url[SPEC_URL_SIZE];
    int across = span->x1 - span->x0;
    source_spec_url(l, span->level, span->x0 + index % across, span->y0 + index / across, url);
    r->corrupt++;
    if (fetch_reject(r->fetcher, url)) log_warn("%s: no tile: %s", url, why);
    else log_debug("%s: no tile: %s", url, why);
    return ERR_FORMAT;
}

// Decodes all bodies into `raster`: 4 bytes a sample, heights as floats. Every one that is no tile
// is rejected, not the first alone: the others would stay on disk and spoil the next run.
static status decode_bodies(struct source_remote *r, const spec_layer *l, const tile_span *span,
                            const struct bodies *bodies, void *raster)
{
    int size = l->matrix.tile_size, count = size * size;
    uint8_t *rgba = malloc((size_t)count * 8);
    status s = rgba ? OK : ERR_MEMORY, worst = s;
    char why[IMAGE_WHY_SIZE];
    for (int i = 0; s != ERR_MEMORY && i < bodies->count; i++) {
        float *heights = (float *)(void *)(rgba + (size_t)count * 4);
        const fetch_body *b = bodies->body[i];
        s = b ? image_decode(b->data, b->size, size, rgba, why) : OK;
        if (!b) memset(rgba, 0, (size_t)count * 4);
        if (s == ERR_FORMAT) reject(r, l, span, i, why);
        if (!s && l->layer == LAYER_HEIGHT) heights_of(l, rgba, count, heights);
        if (!s) place_tile(l, span, i, l->layer == LAYER_HEIGHT ? (void *)heights : rgba, raster);
        if (s) worst = s;
    }
    free(rgba);
    return worst;
}

static status make_samples(struct source_remote *r, tile_id id, const tile_span *span,
                           const struct bodies *bodies, void *samples)
{
    const spec_layer *l = r->layers[id.layer];
    size_t size = (size_t)l->matrix.tile_size;
    void *raster = malloc(size * size * 4 * (size_t)bodies->count);
    uint8_t *light = id.layer == LAYER_NIGHT ? malloc(SAMPLES * 4) : NULL;
    status s = raster && (light || id.layer != LAYER_NIGHT) ? OK : ERR_MEMORY;
    if (!s) s = decode_bodies(r, l, span, bodies, raster);
    if (!s && id.layer == LAYER_HEIGHT)
        matrix_resample_heights(&l->matrix, id, span, raster, samples);
    else if (!s) matrix_resample_pixels(&l->matrix, id, span, raster, light ? light : samples);
    for (int i = 0; !s && light && i < SAMPLES; i++) ((uint8_t *)samples)[i] = light[4 * i];
    free(light);
    free(raster);
    return s;
}

static void fill_blank(tile_id id, void *samples)
{
    if (id.layer == LAYER_HEIGHT)
        for (int i = 0; i < SAMPLES; i++) ((float *)samples)[i] = NAN;
    else memset(samples, 0, SAMPLES * (id.layer == LAYER_COLOR ? 4 : 1));
}

static status remote_read(struct source *source, tile_id id, struct want *want, void *samples,
                          double *until_s)
{
    struct source_remote *r = (struct source_remote *)source;
    const spec_layer *l = r->layers[id.layer];
    tile_span span;
    struct bodies bodies;
    if (!remote_has(source, id) || !matrix_span(&l->matrix, id, &span)) return ERR_NOT_FOUND;
    status s = get_bodies(r, l, &span, want, &bodies, until_s);
    bool blank = true;
    for (int i = 0; i < bodies.count; i++) blank &= !bodies.body[i];
    if (!s && blank) fill_blank(id, samples);
    else if (!s) s = make_samples(r, id, &span, &bodies, samples);
    release_bodies(r, &bodies);
    if (s == ERR_IO) r->failed++;
    return s;
}

static void remote_counters(struct source *source, struct source_counters *out)
{
    struct source_remote *r = (struct source_remote *)source;
    out->corrupt = r->corrupt;
    out->failed = r->failed;
}

static void remote_close(struct source *source)
{
    struct source_remote *r = (struct source_remote *)source;
    source_spec_deinit(&r->spec);
    free(r);
}

static const struct source_ops remote_ops = {remote_has, remote_read, remote_counters,
                                             remote_close};

status source_remote_open_take(source_spec *spec, struct fetcher *fetcher, struct source **out)
{
    struct source_remote *r = NEW(struct source_remote);
    r->spec = *spec;
    *spec = (source_spec){0};
    r->fetcher = fetcher;
    r->source = (struct source){.ops = &remote_ops, .meta = r->spec.meta, .gaps_final = true};
    for (int i = 0; i < r->spec.count; i++) {
        const spec_layer *l = &r->spec.layers[i];
        r->layers[l->layer] = l;
        if (l->matrix.projection == MATRIX_PLANET) r->source.gaps_final = false;
    }
    r->source.path = r->spec.layers[0].url;
    *out = &r->source;
    return OK;
}
