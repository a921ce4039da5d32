// A tile is its stored samples, and where there are none, the zoom before upsampled (region.h)
// plus, for heights, the synthetic residual. Making a tile acquires stored tiles of coarser zooms,
// holding one at a time while it copies from it; other tiles it uses only if they are in the cache.
#include "planet/pyramid.h"

#include <assert.h>
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "planet/cache.h"
#include "planet/region.h"
#include "planet/synthesis.h"
#include "planet/tile_index.h"
#include "planet/upsample.h"

enum {
    SAMPLES = TILE_SIZE * TILE_SIZE,
    MIN_CACHE_BYTES = 16 << 20,
    DEFAULT_CACHE_BYTES = 256 << 20
};

struct pyramid {
    struct planet_file *file;
    const struct planet_meta *meta;
    struct tile_index *index[LAYER_COUNT];
    struct cache *cache;
    bool synthesis;
    atomic_uint_fast64_t decoded, synthesised, upsampled, corrupt;
};

// Reads a stored tile. *found is false when it is not stored or cannot be read, which is counted
// and remembered.
static status read_stored(struct pyramid *p, tile_id id, void *out, bool *found)
{
    *found = false;
    if (!tile_index_readable(p->index[id.layer], id)) return OK;
    status s = id.layer == LAYER_HEIGHT ? planet_file_read_height(p->file, id, out)
                                        : planet_file_read_pixels(p->file, id, out);
    if (s == ERR_MEMORY) return s;
    if (s) {
        if (tile_index_mark_bad(p->index[id.layer], id)) p->corrupt++;
        return OK;
    }
    p->decoded++;
    *found = true;
    return OK;
}

static bool is_stored(const struct pyramid *p, tile_id id)
{
    if (tile_index_readable(p->index[id.layer], id)) return true;
    tile_id night = {LAYER_NIGHT, id.zoom, id.row, id.col};
    return id.layer == LAYER_COLOR && tile_index_readable(p->index[LAYER_NIGHT], night);
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
    struct pyramid *p = user;
    const pyramid_tile *tile = NULL;
    status s = OK;
    if (is_stored(p, b->tile) || b->tile.zoom == 0) s = cache_acquire(p->cache, b->tile, &tile);
    else if (!stored) tile = cache_peek(p->cache, b->tile);
    *found = tile != NULL;
    if (!tile) return s;
    copy_block(tile, b);
    cache_release(p->cache, &tile);
    return OK;
}

static bool synthesises(const struct pyramid *p)
{
    return p->synthesis && p->meta->synthesis_gain > 0.0;
}

// What synthesis needs for all rows of a region.
struct residual {
    float *amplitude; // at the parent's samples; NULL: no residual
    double cos_lon[REGION_MAX_COLS], sin_lon[REGION_MAX_COLS];
};

static status residual_init(const struct pyramid *p, struct residual *residual,
                            const region *parent, const region *child)
{
    residual->amplitude = NULL;
    if (!synthesises(p)) return OK;
    residual->amplitude =
        malloc(sizeof *residual->amplitude * (size_t)parent->rows * (size_t)parent->cols);
    if (!residual->amplitude) return ERR_MEMORY;
    synthesis_relief(parent, residual->amplitude);
    synthesis_amplitude(parent, p->meta->synthesis_gain, p->meta->max_zoom[LAYER_HEIGHT],
                        p->meta->ellipsoid.a, residual->amplitude);
    synthesis_columns(child, residual->cos_lon, residual->sin_lon);
    return OK;
}

static void add_residual(const struct residual *residual, const region *parent, const region *child,
                         int row, const bool *flat, float *out)
{
    float share[REGION_MAX_COLS], noise[REGION_MAX_COLS];
    bool any = false;
    upsample_linear_row(parent, residual->amplitude, child, row, share);
    for (int i = 0; i < child->cols; i++) {
        share[i] = flat[i] ? 0.0f : share[i];
        any |= share[i] > 0.0f;
    }
    if (!any) return;
    synthesis_noise(residual->cos_lon, residual->sin_lon, child->cols, child->zoom,
                    grid_lat(child->zoom, child->row + row), noise);
    for (int i = 0; i < child->cols; i++) out[i] += share[i] * noise[i];
}

static float to_byte(float v)
{
    return v <= 0.0f ? 0.0f : v >= 255.0f ? 255.0f : (float)(int)(v + 0.5f);
}

// One zoom from the one before. Colour is rounded at every zoom, as whole tiles are.
static status make_region(void *user, const region *parent, const region *child)
{
    struct pyramid *p = user;
    bool heights = child->layer == LAYER_HEIGHT, flat[REGION_MAX_COLS];
    struct residual residual;
    status s = heights ? residual_init(p, &residual, parent, child) : OK;
    for (int row = 0; !s && row < child->rows; row++) {
        float *out = child->data + (size_t)row * (size_t)child->stride;
        upsample_child_row(parent, child, row, out, flat);
        if (!heights)
            for (int i = 0; i < 4 * child->cols; i++) out[i] = to_byte(out[i]);
        else if (residual.amplitude) add_residual(&residual, parent, child, row, flat, out);
    }
    if (heights) free(residual.amplitude);
    return s;
}

static bool has_nan(const float *heights)
{
    int count = 0;
    for (int i = 0; i < SAMPLES; i++) count += isnan(heights[i]) != 0;
    return count > 0;
}

static void measure_range(const float *heights, float *min, float *max)
{
    float low = heights[0], high = heights[0];
    for (int i = 1; i < SAMPLES; i++) {
        low = heights[i] < low ? heights[i] : low;
        high = heights[i] > high ? heights[i] : high;
    }
    *min = low;
    *max = high;
}

// What a planet without imagery looks like, and no light.
static const uint8_t BARE_GROUND[4] = {156, 150, 140, 0};

// All of a tile that is not stored. At zoom 0, and where nothing is stored at all, height 0 and
// bare ground.
static status make_missing(struct pyramid *p, tile_id id, int channels, float *samples)
{
    bool heights = id.layer == LAYER_HEIGHT;
    if (id.zoom == 0 || (heights && tile_index_max_zoom(p->index[LAYER_HEIGHT]) < 0)) {
        for (int i = 0; i < SAMPLES * channels; i++) samples[i] = heights ? 0 : BARE_GROUND[i % 4];
        return OK;
    }
    region tile = region_of_tile(id, channels, samples);
    region_source source = {p, fetch_block, make_region};
    if (heights && synthesises(p)) p->synthesised++;
    else p->upsampled++;
    return region_make(&source, &tile);
}

static status make_heights(struct pyramid *p, tile_id id, float *heights, float *min, float *max)
{
    bool found;
    status s = read_stored(p, id, heights, &found);
    if (!s && !found) s = make_missing(p, id, 1, heights);
    if (!s && found && has_nan(heights)) {
        float *made = malloc(sizeof *made * SAMPLES);
        s = made ? make_missing(p, id, 1, made) : ERR_MEMORY;
        for (int i = 0; !s && i < SAMPLES; i++)
            heights[i] = isnan(heights[i]) ? made[i] : heights[i];
        free(made);
    }
    if (!s) measure_range(heights, min, max);
    return s;
}

// Colour and light where they are stored; both if need be from the zoom before.
static status make_rgba(struct pyramid *p, tile_id id, uint8_t *rgba)
{
    uint8_t *stored = malloc(SAMPLES * 4); // RGB, then light
    if (!stored) return ERR_MEMORY;
    tile_id night = {LAYER_NIGHT, id.zoom, id.row, id.col};
    bool has_color, has_night = false;
    status s = read_stored(p, id, stored, &has_color);
    if (!s) s = read_stored(p, night, stored + SAMPLES * 3, &has_night);
    bool color_known = has_color || tile_index_max_zoom(p->index[LAYER_COLOR]) < 0;
    bool night_known = has_night || tile_index_max_zoom(p->index[LAYER_NIGHT]) < 0;
    for (int i = 0; i < SAMPLES; i++) memcpy(rgba + 4 * i, BARE_GROUND, 4);
    if (!s && !(color_known && night_known)) {
        float *made = malloc(sizeof *made * SAMPLES * 4);
        s = made ? make_missing(p, id, 4, made) : ERR_MEMORY;
        for (int i = 0; !s && i < SAMPLES * 4; i++) rgba[i] = (uint8_t)made[i];
        free(made);
    }
    for (int i = 0; !s && has_color && i < SAMPLES; i++) memcpy(rgba + 4 * i, stored + 3 * i, 3);
    for (int i = 0; !s && has_night && i < SAMPLES; i++) rgba[4 * i + 3] = stored[3 * SAMPLES + i];
    free(stored);
    return s;
}

static status make_tile(void *user, tile_id id, void *samples, float *min, float *max)
{
    struct pyramid *p = user;
    status s = id.layer == LAYER_HEIGHT ? make_heights(p, id, samples, min, max)
                                        : make_rgba(p, id, samples);
    if (s == ERR_MEMORY)
        log_error("%s: out of memory for tile %s/%d/%d/%d", planet_file_path(p->file),
                  tile_layer_name(id.layer), id.zoom, id.row, id.col);
    return s;
}

status pyramid_create(struct planet_file *file, const pyramid_params *params, struct pyramid **out)
{
    struct pyramid *p = NEW(struct pyramid);
    p->file = file;
    p->meta = planet_file_meta(file);
    p->synthesis = params->synthesis;
    size_t bytes = params->cache_bytes ? params->cache_bytes : DEFAULT_CACHE_BYTES;
    p->cache = cache_create(bytes > MIN_CACHE_BYTES ? bytes : MIN_CACHE_BYTES, make_tile, p);
    status s = OK;
    for (int layer = 0; !s && layer < LAYER_COUNT; layer++)
        s = tile_index_create(file, (enum tile_layer)layer, &p->index[layer]);
    if (s) pyramid_destroy(&p);
    *out = p;
    return s;
}

void pyramid_destroy(struct pyramid **pyramid)
{
    struct pyramid *p = *pyramid;
    if (!p) return;
    cache_destroy(&p->cache);
    for (int layer = 0; layer < LAYER_COUNT; layer++) tile_index_destroy(&p->index[layer]);
    free(p);
    *pyramid = NULL;
}

const struct planet_meta *pyramid_meta(const struct pyramid *p)
{
    return p->meta;
}

static void assert_on_grid(tile_id id)
{
    assert(id.zoom >= 0 && id.zoom <= GRID_MAX_ZOOM);
    assert(id.row >= 0 && id.row < grid_rows(id.zoom));
    assert(id.col >= 0 && id.col < grid_cols(id.zoom, id.row));
    (void)id;
}

status pyramid_acquire(struct pyramid *p, tile_id id, const pyramid_tile **out)
{
    assert(id.layer == LAYER_HEIGHT || id.layer == LAYER_COLOR);
    assert_on_grid(id);
    return cache_acquire(p->cache, id, out);
}

void pyramid_release(struct pyramid *p, const pyramid_tile **tile)
{
    cache_release(p->cache, tile);
}

int pyramid_data_zoom(struct pyramid *p, tile_id id)
{
    assert_on_grid(id);
    return tile_index_data_zoom(p->index[id.layer], id);
}

// Height on the centre line of one global sample row, linear in longitude; a row beyond a pole is
// the row as far before it, on the opposite meridian.
static status height_on_row(struct pyramid *p, int zoom, int64_t row, double lon, double *height)
{
    int64_t rows = (int64_t)TILE_SIZE * grid_rows(zoom);
    double turn = lon / (2.0 * M_PI) + 0.5;
    if (row < 0 || row >= rows) {
        row = row < 0 ? -1 - row : 2 * rows - 1 - row;
        turn += 0.5;
    }
    int tile_row = (int)(row / TILE_SIZE);
    int64_t width = (int64_t)TILE_SIZE * grid_cols(zoom, tile_row);
    double x = (turn - floor(turn)) * (double)width - 0.5, west = floor(x), h[2];
    for (int i = 0; i < 2; i++) {
        int64_t col = ((int64_t)west + i + width) % width;
        tile_id id = {LAYER_HEIGHT, zoom, tile_row, (int)(col / TILE_SIZE)};
        const pyramid_tile *tile;
        status s = cache_acquire(p->cache, id, &tile);
        if (s) return s;
        h[i] = tile->heights[row % TILE_SIZE * TILE_SIZE + col % TILE_SIZE];
        cache_release(p->cache, &tile);
    }
    *height = h[0] + (x - west) * (h[1] - h[0]);
    return OK;
}

status pyramid_height_at(struct pyramid *p, int zoom, double lat, double lon, double *height)
{
    assert(isfinite(lat) && isfinite(lon));
    *height = 0.0;
    zoom = zoom < 0 ? 0 : zoom > GRID_MAX_ZOOM ? GRID_MAX_ZOOM : zoom;
    lat = clamp_double(lat, -M_PI / 2, M_PI / 2);
    double y = (M_PI / 2 - lat) / grid_step_lat(zoom) - 0.5, north = floor(y), a, b;
    status s = height_on_row(p, zoom, (int64_t)north, lon, &a);
    if (!s) s = height_on_row(p, zoom, (int64_t)north + 1, lon, &b);
    if (!s) *height = a + (y - north) * (b - a);
    return s;
}

void pyramid_counters(struct pyramid *p, struct pyramid_counters *out)
{
    out->decoded = p->decoded;
    out->synthesised = p->synthesised;
    out->upsampled = p->upsampled;
    out->corrupt = p->corrupt;
    cache_counters(p->cache, &out->cache_hits, &out->cache_bytes);
}
