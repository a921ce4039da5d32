#include "planet/import_tile.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/vector.h"
#include "planet/filter.h"
#include "planet/import_light.h"
#include "planet/import_workshop.h"
#include "planet/quantum.h"

enum { PIXEL_QUALITY = 90, LANES = 32, KEPT_MASKS = 4096 };

struct workshop *workshop_create(const workshop_params *params)
{
    struct workshop *w = NEW(struct workshop);
    w->params = *params;
    w->channels = params->grids[0].channels;
    compose_plan(w);
    if (params->feather > 0) w->blend = blend_create(params->feather, KEPT_MASKS);
    w->benches = NEW_ARRAY(struct bench, (size_t)params->workers);
    for (int i = 0; i < params->workers; i++) {
        w->benches[i].workshop = w;
        w->benches[i].cache = params->cache;
    }
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
        blend_room_deinit(&b->blend_room);
        filter_room_deinit(&b->filter_room);
        free(b->held);
    }
    blend_destroy(&w->blend);
    free(w->benches);
    compose_plan_deinit(w);
    free(w);
    *workshop = NULL;
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
    if (tile->planes && tile_id_equal(tile_parent(id), b->parent)) {
        b->lowest = fminf(b->lowest, tile->min);
        b->highest = fmaxf(b->highest, tile->max);
    }
    *has_nan = tile->has_nan;
    return tile->planes;
}

static bool has_finer(const struct workshop *w, tile_id id)
{
    if (w->params.base && import_base_has_finer(w->params.base, id)) return true;
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
    b->parent = id;
    b->lowest = INFINITY;
    b->highest = -INFINITY;
    status s = compose_sources(w, b, id, any);
    if (s || !has_finer(w, id)) return s;
    b->failed = OK;
    filter_parent(id, w->channels, fetch_child, b, &b->filter_room, b->source, b->coverage);
    for (int i = 0; i < b->held_count; i++) import_cache_release(b->cache, b->held[i]);
    b->held_count = 0;
    if (b->failed) return b->failed;
    bool known = b->lowest <= b->highest && id.layer == LAYER_HEIGHT; // of finer zooms
    if (lay_children(w, b) || known) *any = true;
    return OK;
}

static bool is_empty(const float *samples)
{
    for (int i = 0; i < SAMPLES; i++)
        if (!isnan(samples[i])) return false;
    return true;
}

static status encode(const struct workshop *w, struct bench *b, tile_id id, float *planes,
                     codec_blob *out)
{
    double quantum = w->params.quantum, radius = w->params.ellipsoid.a;
    if (id.layer == LAYER_HEIGHT && quantum == 0) return codec_height_encode(planes, out);
    if (id.layer == LAYER_HEIGHT)
        return codec_height_encode_grid(planes, quantum_tile_exponent(quantum, id, radius), out);
    for (int i = 0; i < SAMPLES; i++)
        for (int c = 0; c < w->channels; c++)
            b->pixels[i * w->channels + c] = light_encode(planes[c * SAMPLES + i]);
    return codec_pixels_encode(b->pixels, w->channels, PIXEL_QUALITY, out);
}

status workshop_encode(struct workshop *w, int worker, tile_id id, float *planes, codec_blob *out)
{
    return encode(w, &w->benches[worker], id, planes, out);
}

status workshop_look(struct workshop *w, int worker, tile_id id, float *planes, bool *any)
{
    struct bench *b = &w->benches[worker];
    status s = compose_sources(w, b, id, any);
    if (!s) memcpy(planes, b->tile, (size_t)w->channels * SAMPLES * sizeof *planes);
    return s;
}

VECTOR_CLONES static void find_range(const float *heights, float *low, float *high, bool *holes)
{
    float lows[LANES], highs[LANES];
    int missing = 0;
    for (int i = 0; i < LANES; i++) {
        lows[i] = INFINITY;
        highs[i] = -INFINITY;
    }
    for (int at = 0; at < SAMPLES; at += LANES)
        for (int i = 0; i < LANES; i++) {
            float v = heights[at + i];
            lows[i] = v < lows[i] ? v : lows[i];
            highs[i] = v > highs[i] ? v : highs[i];
            missing |= v != v;
        }
    *holes = missing != 0;
    for (int i = 0; i < LANES; i++) {
        *low = fminf(*low, lows[i]);
        *high = fmaxf(*high, highs[i]);
    }
}

// A tile without heights of its own, but with children that have some, is stored all the same.
static status encode_heights(const struct workshop *w, struct bench *b, made_tile *out)
{
    float low = INFINITY, high = -INFINITY;
    bool holes = false;
    if (b->lowest > b->highest && is_empty(b->tile)) return OK;
    status s = encode(w, b, b->parent, b->tile, &out->body);
    if (s) return s;
    find_range(b->tile, &low, &high, &holes); // of what was stored
    out->uniform = low == high && !holes;
    low = fminf(low, b->lowest);
    high = fmaxf(high, b->highest);
    out->min = low;
    out->max = high;
    if (b->cache) import_cache_add(b->cache, b->parent, b->tile, low, high);
    return OK;
}

static status encode_pixels(const struct workshop *w, struct bench *b, made_tile *out)
{
    status s = encode(w, b, b->parent, b->tile, &out->body);
    size_t rest = (size_t)(SAMPLES - 1) * (size_t)w->channels;
    out->uniform = memcmp(b->pixels, b->pixels + w->channels, rest) == 0;
    return s;
}

status workshop_make(struct workshop *w, int worker, tile_id id, made_tile *out)
{
    struct bench *b = &w->benches[worker];
    bool any;
    *out = (made_tile){0};
    status s = compose(w, b, id, &any);
    if (s || !any) return s;
    return id.layer == LAYER_HEIGHT ? encode_heights(w, b, out) : encode_pixels(w, b, out);
}

bool workshop_has_border(const struct workshop *w, tile_id id)
{
    return compose_has_border(w, id);
}

int workshop_zoom_below(const struct workshop *w, tile_id id)
{
    return compose_zoom_below(w, id);
}

int workshop_feather(const struct workshop *w)
{
    return w->params.feather;
}

int workshop_finest(const struct workshop *w)
{
    int finest = 0;
    for (int i = 0; i < w->mosaic_count; i++)
        if (w->mosaics[i].zoom > finest) finest = w->mosaics[i].zoom;
    return finest;
}

status workshop_inside(struct workshop *w, int worker, tile_id id, unsigned char *mask)
{
    struct bench *b = &w->benches[worker];
    status s = compose_outlines(w, b, id);
    memset(mask, 0, SAMPLES / 8);
    for (int i = 0; !s && i < SAMPLES; i++)
        if (b->all.own[i] > 1.01f * BLEND_LEAST_WEIGHT)
            mask[i / 8] |= (unsigned char)(1u << (i % 8));
    return s;
}

status workshop_below(struct workshop *w, int worker, tile_id id, float *shares, float *heights,
                      float *keep)
{
    struct bench *b = &w->benches[worker];
    status s = compose_below(w, b, id, keep);
    if (s) return s;
    for (int i = 0; i < SAMPLES; i++) {
        float own = b->all.own[i], below = b->all.laid[i] - own;
        shares[i] = below > 0 ? below / b->all.laid[i] : 0;
        heights[i] = below > 0 ? b->all.sum[i] / below : 0;
        keep[i] = keep[i] < own ? keep[i] / own : keep[i] > 0;
    }
    return OK;
}
