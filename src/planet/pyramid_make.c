// A tile is its stored samples, and where there are none, the zoom before upsampled (region.h)
// plus, for heights, the synthetic residual. Making a tile acquires stored tiles of coarser zooms,
// holding one at a time while it copies from it; other tiles it uses only if they are in the cache.
#include "planet/pyramid_make.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "planet/region.h"
#include "planet/synthesis.h"
#include "planet/upsample.h"

enum { SAMPLES = PYRAMID_SAMPLES };

bool pyramid_may_hold(const struct pyramid *p, tile_id id)
{
    return p->own.max_zoom[id.layer] >= 0 && source_has(p->source, id);
}

status pyramid_read_stored(struct making *m, tile_id id, void *out, bool *found)
{
    struct pyramid *p = m->pyramid;
    double until_s;
    *found = false;
    if (!pyramid_may_hold(p, id)) return OK;
    status s = source_read(p->source, id, m->want, out, &until_s);
    if (s == ERR_MEMORY || s == ERR_PENDING) return s;
    m->until_s = fmin(m->until_s, until_s);
    if (s) return OK;
    p->decoded++;
    *found = true;
    return OK;
}

static bool is_stored(const struct pyramid *p, tile_id id)
{
    if (pyramid_may_hold(p, id)) return true;
    tile_id night = {LAYER_NIGHT, id.zoom, id.row, id.col};
    return id.layer == LAYER_COLOR && !p->over && pyramid_may_hold(p, night);
}

static void copy_block(const pyramid_tile *tile, const region_block *b)
{
    for (int r = 0; r < b->rows; r++) {
        size_t at = (size_t)(b->row + r) * TILE_SIZE + (size_t)b->col;
        float *out = b->out + (size_t)r * (size_t)b->stride;
        if (tile->heights) memcpy(out, tile->heights + at, (size_t)b->cols * sizeof *out);
        else
            for (int i = 0; i < 4 * b->cols; i++) out[i] = tile->rgba[4 * at + (size_t)i];
    }
}

static status fetch_block(void *user, const region_block *b, bool stored, bool *found)
{
    struct making *m = user;
    struct pyramid *p = m->pyramid;
    const pyramid_tile *tile = NULL;
    status s = OK;
    if (is_stored(p, b->tile) || b->tile.zoom == 0)
        s = cache_acquire(p->cache, m->want, b->tile, &tile);
    else if (!stored) tile = cache_peek(p->cache, b->tile);
    *found = tile != NULL;
    if (!tile) return s;
    copy_block(tile, b);
    m->until_s = fmin(m->until_s, tile->until_s);
    cache_release(p->cache, &tile);
    return OK;
}

static bool synthesises(const struct pyramid *p)
{
    return p->synthesis && p->own.synthesis_gain > 0.0;
}

static float to_byte(float v)
{
    return v <= 0.0f ? 0.0f : v >= 255.0f ? 255.0f : (float)(int)(v + 0.5f);
}

// NULL: all of it everywhere.
static status share_residual(struct making *m, const region *child, float **share)
{
    *share = NULL;
    if (!pyramid_beside_stored(m->pyramid, child)) return OK;
    *share = malloc(sizeof **share * (size_t)child->rows * (size_t)child->cols);
    return *share ? pyramid_fade(m, child, *share) : ERR_MEMORY;
}

// One zoom from the one before. Colour is rounded at every zoom, as whole tiles are.
static status make_region(void *user, const region *parent, const region *child)
{
    struct making *m = user;
    const struct pyramid *p = m->pyramid;
    bool heights = child->layer == LAYER_HEIGHT, flat[REGION_MAX_COLS];
    synthesis_columns columns;
    synthesis_ground ground = {0};
    float *share = NULL;
    status s = OK;
    if (heights && synthesises(p)) {
        s = share_residual(m, child, &share);
        if (!s)
            s = synthesis_ground_create(parent, p->synthesis, p->own.synthesis_gain,
                                        p->own.max_zoom[LAYER_HEIGHT], p->own.ellipsoid.a, &ground);
        synthesis_columns_of(child, &columns);
    }
    for (int row = 0; !s && row < child->rows; row++) {
        float *out = child->data + (size_t)row * (size_t)child->stride;
        upsample_child_row(parent, child, row, out, flat);
        if (!heights)
            for (int i = 0; i < 4 * child->cols; i++) out[i] = to_byte(out[i]);
        else if (ground.amplitude)
            synthesis_add_row(&ground, &columns, parent, child, row, flat,
                              share ? share + (size_t)row * (size_t)child->cols : NULL, out);
    }
    synthesis_ground_destroy(&ground);
    free(share);
    return s;
}

static bool has_nan(const float *heights)
{
    int count = 0;
    for (int i = 0; i < SAMPLES; i++) count += isnan(heights[i]) != 0;
    return count > 0;
}

void pyramid_measure_range(const float *heights, struct cache_made *made)
{
    float low = INFINITY, high = -INFINITY;
    for (int i = 0; i < SAMPLES; i++) {
        low = heights[i] < low ? heights[i] : low;
        high = heights[i] > high ? heights[i] : high;
    }
    made->min = low <= high ? low : 0;
    made->max = low <= high ? high : 0;
}

// What a planet without imagery looks like, and no light.
static const uint8_t BARE_GROUND[4] = {156, 150, 140, 0};

static void fill_bare(const struct pyramid *p, bool heights, float *samples)
{
    float ground = p->over ? NAN : 0;
    for (int i = 0; i < SAMPLES * (heights ? 1 : 4); i++)
        samples[i] = heights ? ground : p->over ? 0 : BARE_GROUND[i % 4];
}

// All of a tile that is not stored. At zoom 0, and where nothing is stored at all, height 0 and
// bare ground, or what lies below.
static status make_missing(struct making *m, tile_id id, float *samples)
{
    struct pyramid *p = m->pyramid;
    bool heights = id.layer == LAYER_HEIGHT;
    if (id.zoom == 0 || p->own.max_zoom[id.layer] < 0) {
        bool night = id.layer == LAYER_COLOR && p->own.max_zoom[LAYER_NIGHT] >= 0;
        if (id.zoom == 0 || !night) {
            fill_bare(p, heights, samples);
            return OK;
        }
    }
    region tile = region_of_tile(id, heights ? 1 : 4, samples);
    region_source source = {m, fetch_block, make_region, heights && synthesises(p)};
    if (heights && synthesises(p)) p->synthesised++;
    else p->upsampled++;
    return region_make(&source, &tile);
}

static status make_heights(struct making *m, tile_id id, float *heights, struct cache_made *range)
{
    const struct pyramid *p = m->pyramid;
    bool found;
    status s = pyramid_read_stored(m, id, heights, &found);
    if (!s && !found) s = make_missing(m, id, heights);
    if (!s && found && !p->source->gaps_final && has_nan(heights)) {
        float *made = malloc(sizeof *made * SAMPLES);
        s = made ? make_missing(m, id, made) : ERR_MEMORY;
        for (int i = 0; !s && i < SAMPLES; i++)
            heights[i] = isnan(heights[i]) ? made[i] : heights[i];
        free(made);
    }
    for (int i = 0; !s && !p->over && i < SAMPLES; i++)
        heights[i] = isnan(heights[i]) ? 0 : heights[i];
    if (!s) pyramid_measure_range(heights, range);
    return s;
}

// What is stored of a tile of pixels.
struct stored_pixels {
    uint8_t *color, *light; // SAMPLES of RGBA, of light
    bool has_color, has_light;
};

static status read_pixels(struct making *m, tile_id id, struct stored_pixels *out)
{
    tile_id night = {LAYER_NIGHT, id.zoom, id.row, id.col};
    status s = pyramid_read_stored(m, id, out->color, &out->has_color), t = OK;
    if (s && s != ERR_PENDING) return s;
    if (!m->pyramid->over) t = pyramid_read_stored(m, night, out->light, &out->has_light);
    return s ? s : t;
}

static bool is_opaque(const uint8_t *rgba)
{
    uint8_t all = 255;
    for (int i = 0; i < SAMPLES; i++) all &= rgba[4 * i + 3];
    return all == 255;
}

// Stored pixels over what is below, which is what rgba holds.
static void lay_pixels(const struct pyramid *p, const struct stored_pixels *stored, uint8_t *rgba)
{
    for (int i = 0; stored->has_color && i < SAMPLES; i++) {
        const uint8_t *over = stored->color + 4 * i;
        uint8_t *out = rgba + 4 * i;
        int channels = p->over ? 4 : 3;
        for (int c = 0; c < channels; c++)
            out[c] = (uint8_t)(over[c] + (out[c] * (255 - over[3]) + 127) / 255);
    }
    for (int i = 0; stored->has_light && i < SAMPLES; i++) rgba[4 * i + 3] = stored->light[i];
}

// Colour and light where they are stored; both if need be from the zoom before.
static status make_rgba(struct making *m, tile_id id, uint8_t *rgba)
{
    const struct pyramid *p = m->pyramid;
    uint8_t *room = malloc(SAMPLES * 5);
    if (!room) return ERR_MEMORY;
    struct stored_pixels stored = {.color = room, .light = room + SAMPLES * 4};
    status s = read_pixels(m, id, &stored);
    bool color_known = p->own.max_zoom[LAYER_COLOR] < 0;
    if (!s && stored.has_color) color_known = p->source->gaps_final || is_opaque(stored.color);
    bool light_known = p->over || stored.has_light || p->own.max_zoom[LAYER_NIGHT] < 0;
    for (int i = 0; i < SAMPLES * 4; i++) rgba[i] = p->over ? 0 : BARE_GROUND[i % 4];
    if (!s && !(color_known && light_known)) {
        float *made = malloc(sizeof *made * SAMPLES * 4);
        s = made ? make_missing(m, id, made) : ERR_MEMORY;
        for (int i = 0; !s && i < SAMPLES * 4; i++) rgba[i] = (uint8_t)made[i];
        free(made);
    }
    if (!s) lay_pixels(p, &stored, rgba);
    free(room);
    return s;
}

status pyramid_make_tile(void *user, struct want *want, tile_id id, void *samples,
                         struct cache_made *made)
{
    struct making m = {user, want, INFINITY};
    status s =
        id.layer == LAYER_HEIGHT ? make_heights(&m, id, samples, made) : make_rgba(&m, id, samples);
    made->until_s = m.until_s;
    if (s == ERR_MEMORY)
        log_error("%s: out of memory for tile %s/%d/%d/%d", m.pyramid->source->path,
                  tile_layer_name(id.layer), id.zoom, id.row, id.col);
    return s;
}
