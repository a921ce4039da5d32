#include "planet/import_tile.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "planet/filter.h"
#include "planet/import_light.h"
#include "planet/import_resample.h"

enum { SAMPLES = TILE_SIZE * TILE_SIZE, MAX_CHANNELS = 3, MAX_OPEN = 64, PIXEL_QUALITY = 90 };

struct opened {
    struct raster *raster;
    int input;
    unsigned long used;
};

struct bench {
    struct opened open[MAX_OPEN];
    unsigned long clock;
    struct resample_room room;
    const cached_tile **held;
    int held_count, held_room;
    status failed;
    struct import_cache *cache;
    // Planes of the tile, of one source, and the coverage by children.
    float tile[MAX_CHANNELS * SAMPLES], source[MAX_CHANNELS * SAMPLES], coverage[SAMPLES];
    unsigned char pixels[MAX_CHANNELS * SAMPLES];
};

struct workshop {
    workshop_params params;
    int channels;
    struct bench *benches;
    atomic_flag reported; // a read that failed has been logged
};

struct workshop *workshop_create(const workshop_params *params)
{
    struct workshop *w = NEW(struct workshop);
    w->params = *params;
    w->channels = params->grids[0].channels;
    w->benches = NEW_ARRAY(struct bench, (size_t)params->workers);
    for (int i = 0; i < params->workers; i++) w->benches[i].cache = params->cache;
    return w;
}

void workshop_destroy(struct workshop **workshop)
{
    struct workshop *w = *workshop;
    if (!w) return;
    for (int i = 0; i < w->params.workers; i++) {
        struct bench *b = &w->benches[i];
        for (int k = 0; k < MAX_OPEN; k++) raster_close(&b->open[k].raster);
        resample_room_deinit(&b->room);
        free(b->held);
    }
    free(w->benches);
    free(w);
    *workshop = NULL;
}

// The worker's own handle of an input; the one used longest ago makes room.
static status open_input(struct workshop *w, struct bench *b, int input, struct raster **out)
{
    struct opened *slot = &b->open[0];
    for (int i = 0; i < MAX_OPEN; i++) {
        struct opened *o = &b->open[i];
        if (o->raster && o->input == input) {
            o->used = ++b->clock;
            *out = o->raster;
            return OK;
        }
        if (!o->raster ? slot->raster != NULL : slot->raster && o->used < slot->used) slot = o;
    }
    raster_close(&slot->raster);
    status s = raster_open(&w->params.inputs[input], w->params.ellipsoid, &slot->raster);
    slot->input = input;
    slot->used = ++b->clock;
    *out = slot->raster;
    return s;
}

static const float *fetch_child(void *user, tile_id id, bool *has_nan)
{
    struct bench *b = user;
    const cached_tile *tile = NULL;
    status s = b->failed ? b->failed : import_cache_acquire(b->cache, id, &tile);
    if (s) b->failed = s;
    if (!tile) return NULL;
    if (b->held_count == b->held_room) {
        const cached_tile **held = NEW_ARRAY(const cached_tile *, (size_t)b->held_room * 2 + 16);
        if (b->held) memcpy(held, b->held, (size_t)b->held_count * sizeof *held);
        free(b->held);
        b->held = held;
        b->held_room = b->held_room * 2 + 16;
    }
    b->held[b->held_count++] = tile;
    *has_nan = tile->has_nan;
    return tile->planes;
}

// Paints (or, when only its place counts, erases) a source where it has data.
static bool lay_source(const struct workshop *w, struct bench *b, bool erase)
{
    bool any = false;
    for (int i = 0; i < SAMPLES; i++) {
        if (isnan(b->source[i])) continue;
        any = true;
        for (int c = 0; c < w->channels; c++)
            b->tile[c * SAMPLES + i] = erase ? NAN : b->source[c * SAMPLES + i];
    }
    return any;
}

static void clip(const struct workshop *w, tile_id id, float *planes)
{
    if (plan_bounds_are_global(&w->params.bounds)) return;
    double west, south, east, north;
    grid_bounds(id, &west, &south, &east, &north);
    double lon_step = grid_step_lon(id.zoom, id.row);
    for (int y = 0; y < TILE_SIZE; y++)
        for (int x = 0; x < TILE_SIZE; x++) {
            double lat = grid_lat(id.zoom, (int64_t)id.row * TILE_SIZE + y);
            if (plan_bounds_hold(&w->params.bounds, lat, west + (x + 0.5) * lon_step)) continue;
            for (int c = 0; c < w->channels; c++) planes[(c * TILE_SIZE + y) * TILE_SIZE + x] = NAN;
        }
}

// The sources of this zoom (and, for pixels, of coarser ones) in b->tile. *any: a source of this
// zoom has data here.
static status lay_sources(struct workshop *w, struct bench *b, tile_id id, bool *any)
{
    for (int i = 0; i < w->channels * SAMPLES; i++) b->tile[i] = NAN;
    for (int i = 0; i < w->params.count; i++) {
        const raster_grid *g = &w->params.grids[i];
        if (g->zoom > id.zoom || !resample_touches(g, id)) continue;
        struct raster *raster;
        status s = open_input(w, b, i, &raster);
        if (s) return s;
        s = resample_tile(raster, id, &b->room, b->source);
        if (s && !atomic_flag_test_and_set(&w->reported))
            log_error("%s", s == ERR_MEMORY ? "out of memory for a part of a raster"
                                            : raster_error(raster));
        if (s) return s;
        clip(w, id, b->source);
        bool erase = id.layer == LAYER_HEIGHT && g->zoom < id.zoom;
        if (lay_source(w, b, erase) && g->zoom == id.zoom) *any = true;
    }
    return OK;
}

static bool has_finer(const struct workshop *w, tile_id id)
{
    for (int i = 0; i < w->params.count; i++)
        if (w->params.grids[i].zoom > id.zoom && resample_touches(&w->params.grids[i], id))
            return true;
    return false;
}

// The children's mean over b->tile, in proportion to what they cover.
static bool lay_children(const struct workshop *w, struct bench *b)
{
    bool any = false;
    for (int i = 0; i < SAMPLES; i++) {
        float share = b->coverage[i];
        if (!(share > 0)) continue;
        bool empty = isnan(b->tile[i]);
        if (empty && share < 0.5f) continue;
        any = true;
        if (empty || share > 0.9999f) share = 1;
        for (int c = 0; c < w->channels; c++) {
            float *v = &b->tile[c * SAMPLES + i];
            *v = share == 1 ? b->source[c * SAMPLES + i]
                            : *v + share * (b->source[c * SAMPLES + i] - *v);
        }
    }
    return any;
}

static status compose(struct workshop *w, struct bench *b, tile_id id, bool *any)
{
    *any = false;
    status s = lay_sources(w, b, id, any);
    if (s || !has_finer(w, id)) return s;
    b->failed = OK;
    filter_parent(id, w->channels, fetch_child, b, b->source, b->coverage);
    for (int i = 0; i < b->held_count; i++) import_cache_release(b->cache, b->held[i]);
    b->held_count = 0;
    if (b->failed) return b->failed;
    if (lay_children(w, b)) *any = true;
    return OK;
}

static status encode_heights(struct bench *b, codec_blob *body, float *min, float *max)
{
    float low = INFINITY, high = -INFINITY;
    for (int i = 0; i < SAMPLES; i++) {
        low = b->tile[i] < low ? b->tile[i] : low;
        high = b->tile[i] > high ? b->tile[i] : high;
    }
    if (low > high) return OK;
    *min = low;
    *max = high;
    return codec_height_encode(b->tile, body);
}

status workshop_make(struct workshop *w, int worker, tile_id id, codec_blob *body, float *min,
                     float *max)
{
    struct bench *b = &w->benches[worker];
    bool any;
    *body = (codec_blob){0};
    *min = *max = 0;
    status s = compose(w, b, id, &any);
    if (s || !any) return s;
    if (id.layer == LAYER_HEIGHT) return encode_heights(b, body, min, max);
    for (int i = 0; i < SAMPLES; i++)
        for (int c = 0; c < w->channels; c++)
            b->pixels[i * w->channels + c] = light_encode(b->tile[c * SAMPLES + i]);
    return codec_pixels_encode(b->pixels, w->channels, PIXEL_QUALITY, body);
}
