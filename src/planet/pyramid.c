// A tile is decoded when it is stored and whole, else made from a patch of the next coarser zoom,
// which is asked of the same cache; so every tile is a function of the file alone.
#include "planet/pyramid.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "planet/cache.h"
#include "planet/synthesis.h"
#include "planet/tile_index.h"
#include "planet/upsample.h"

enum { SAMPLES = TILE_SIZE * TILE_SIZE };

static const size_t CACHE_DEFAULT_BYTES = (size_t)256 << 20, CACHE_MIN_BYTES = (size_t)16 << 20;

struct pyramid {
    struct planet_file *file;
    struct tile_index *index[LAYER_COUNT];
    struct cache *cache;
    double gain; // 0: no synthesis
    atomic_uint_least64_t decoded, synthesised, upsampled, corrupt;
};

// Copies a block of a tile of the cache, as floats.
static status fetch_block(void *user, const patch_block *b)
{
    struct pyramid *p = user;
    const pyramid_tile *t;
    status s = cache_acquire(p->cache, b->tile, &t);
    if (s) return s;
    for (int r = 0; r < b->rows; r++) {
        size_t first = (size_t)(b->row + r) * TILE_SIZE + (size_t)b->col;
        float *out = b->out + (size_t)r * (size_t)b->stride;
        if (t->heights) memcpy(out, t->heights + first, (size_t)b->cols * sizeof *out);
        else
            for (int i = 0; i < 4 * b->cols; i++) out[i] = t->rgba[4 * first + (size_t)i];
    }
    cache_release(p->cache, &t);
    return OK;
}

static void add_residual(struct pyramid *p, const patch *from, const bool *flat, float *heights,
                         float *residual)
{
    synthesis_residual(from, p->gain, planet_file_meta(p->file)->ellipsoid.a, flat, residual);
    for (int i = 0; i < SAMPLES; i++) heights[i] += residual[i];
}

// Heights made from the next coarser zoom, with their residual.
static status heights_from_parent(struct pyramid *p, tile_id id, float *heights)
{
    patch from;
    status s = patch_init(&from, id, 1, fetch_block, p);
    if (s) return s;
    bool *flat = malloc(SAMPLES * sizeof *flat);
    float *residual = malloc(SAMPLES * sizeof *residual);
    if (!flat || !residual) s = ERR_MEMORY;
    for (int r = 0; !s && r < TILE_SIZE; r++)
        upsample_height_row(&from, r, heights + r * TILE_SIZE, flat + r * TILE_SIZE);
    if (!s && p->gain > 0) add_residual(p, &from, flat, heights, residual);
    atomic_fetch_add(p->gain > 0 ? &p->synthesised : &p->upsampled, 1);
    free(flat);
    free(residual);
    patch_deinit(&from);
    return s;
}

static bool note_corrupt(struct pyramid *p, tile_id id)
{
    if (tile_index_mark_bad(p->index[id.layer], id)) atomic_fetch_add(&p->corrupt, 1);
    return false;
}

// Decodes a stored tile; false when it is not stored or not readable.
static bool read_heights(struct pyramid *p, tile_id id, float *heights)
{
    if (!tile_index_readable(p->index[LAYER_HEIGHT], id)) return false;
    if (planet_file_read_height(p->file, id, heights)) return note_corrupt(p, id);
    atomic_fetch_add(&p->decoded, 1);
    return true;
}

static status make_heights(struct pyramid *p, tile_id id, float *heights)
{
    bool stored = read_heights(p, id, heights), whole = stored;
    for (int i = 0; stored && i < SAMPLES; i++) whole &= !isnan(heights[i]);
    if (whole) return OK;
    if (id.zoom == 0) {
        for (int i = 0; i < SAMPLES; i++)
            if (!stored || isnan(heights[i])) heights[i] = 0;
        return OK;
    }
    if (!stored) return heights_from_parent(p, id, heights);
    float *fill = malloc(SAMPLES * sizeof *fill);
    status s = fill ? heights_from_parent(p, id, fill) : ERR_MEMORY;
    for (int i = 0; !s && i < SAMPLES; i++)
        if (isnan(heights[i])) heights[i] = fill[i];
    free(fill);
    return s;
}

static bool read_pixels(struct pyramid *p, tile_id id, unsigned char *pixels)
{
    if (!tile_index_readable(p->index[id.layer], id)) return false;
    if (planet_file_read_pixels(p->file, id, pixels)) return note_corrupt(p, id);
    atomic_fetch_add(&p->decoded, 1);
    return true;
}

static status rgba_from_parent(struct pyramid *p, tile_id id, uint8_t *rgba)
{
    if (id.zoom == 0) {
        memset(rgba, 0, 4 * SAMPLES);
        return OK;
    }
    patch from;
    status s = patch_init(&from, id, 4, fetch_block, p);
    if (s) return s;
    upsample_rgba(&from, rgba);
    patch_deinit(&from);
    atomic_fetch_add(&p->upsampled, 1);
    return OK;
}

// Colour and night come each from its stored tile, what is missing of them from the parent.
static status make_rgba(struct pyramid *p, tile_id id, uint8_t *rgba)
{
    uint8_t *pixels = malloc((size_t)4 * SAMPLES), *light = pixels ? pixels + 3 * SAMPLES : NULL;
    if (!pixels) return ERR_MEMORY;
    tile_id night = id;
    night.layer = LAYER_NIGHT;
    bool has_color = read_pixels(p, id, pixels), has_night = read_pixels(p, night, light);
    status s = has_color && has_night ? OK : rgba_from_parent(p, id, rgba);
    for (int i = 0; !s && i < SAMPLES; i++) {
        if (has_color) memcpy(rgba + 4 * i, pixels + 3 * i, 3);
        if (has_night) rgba[4 * i + 3] = light[i];
    }
    free(pixels);
    return s;
}

static status make_tile(void *user, tile_id id, void *samples, float *min, float *max)
{
    struct pyramid *p = user;
    *min = *max = 0;
    status s = id.layer == LAYER_HEIGHT ? make_heights(p, id, samples) : make_rgba(p, id, samples);
    if (s == ERR_MEMORY)
        log_error("no memory for %s tile %d/%d/%d", tile_layer_name(id.layer), id.zoom, id.row,
                  id.col);
    if (s || id.layer != LAYER_HEIGHT) return s;
    const float *h = samples;
    *min = *max = h[0];
    for (int i = 1; i < SAMPLES; i++) {
        *min = fminf(*min, h[i]);
        *max = fmaxf(*max, h[i]);
    }
    return OK;
}

status pyramid_create(struct planet_file *file, const pyramid_params *params, struct pyramid **out)
{
    struct pyramid *p = NEW(struct pyramid);
    status s = OK;
    p->file = file;
    p->gain = params && params->synthesis ? planet_file_meta(file)->synthesis_gain : 0;
    for (int i = 0; !s && i < LAYER_COUNT; i++)
        s = tile_index_create(file, (enum tile_layer)i, &p->index[i]);
    size_t bytes = params && params->cache_bytes ? params->cache_bytes : CACHE_DEFAULT_BYTES;
    if (!s)
        p->cache = cache_create(bytes < CACHE_MIN_BYTES ? CACHE_MIN_BYTES : bytes, make_tile, p);
    if (s) pyramid_destroy(&p);
    *out = p;
    return s;
}

void pyramid_destroy(struct pyramid **pyramid)
{
    struct pyramid *p = *pyramid;
    if (!p) return;
    if (p->cache) cache_destroy(&p->cache);
    for (int i = 0; i < LAYER_COUNT; i++) tile_index_destroy(&p->index[i]);
    free(p);
    *pyramid = NULL;
}

const struct planet_meta *pyramid_meta(const struct pyramid *pyramid)
{
    return planet_file_meta(pyramid->file);
}

status pyramid_acquire(struct pyramid *pyramid, tile_id id, const pyramid_tile **out)
{
    return cache_acquire(pyramid->cache, id, out);
}

void pyramid_release(struct pyramid *pyramid, const pyramid_tile **tile)
{
    cache_release(pyramid->cache, tile);
}

int pyramid_data_zoom(struct pyramid *pyramid, tile_id id)
{
    return tile_index_data_zoom(pyramid->index[id.layer], id);
}

// Linear along a sample row, which may lie beyond a pole.
static status row_height(struct pyramid *p, int zoom, int64_t row, double lon, double *height)
{
    int64_t rows = (int64_t)TILE_SIZE << zoom;
    bool beyond = row < 0 || row >= rows;
    if (beyond) row = row < 0 ? -1 - row : 2 * rows - 1 - row;
    int tile_row = (int)(row / TILE_SIZE);
    int64_t cols = (int64_t)TILE_SIZE * grid_cols(zoom, tile_row);
    double x = (lon + (beyond ? 2 : 1) * M_PI) / grid_step_lon(zoom, tile_row) - 0.5,
           f = x - floor(x);
    double ends[2];
    for (int i = 0; i < 2; i++) {
        int64_t col = (((int64_t)floor(x) + i) % cols + cols) % cols;
        const pyramid_tile *t;
        status s =
            pyramid_acquire(p, (tile_id){LAYER_HEIGHT, zoom, tile_row, (int)(col / TILE_SIZE)}, &t);
        if (s) return s;
        ends[i] = t->heights[(row % TILE_SIZE) * TILE_SIZE + col % TILE_SIZE];
        pyramid_release(p, &t);
    }
    *height = ends[0] + (ends[1] - ends[0]) * f;
    return OK;
}

status pyramid_height_at(struct pyramid *pyramid, int zoom, double lat, double lon, double *height)
{
    zoom = zoom < 0 ? 0 : zoom > GRID_MAX_ZOOM ? GRID_MAX_ZOOM : zoom;
    double y = (M_PI / 2 - lat) / grid_step_lat(zoom) - 0.5, f = y - floor(y), north = 0, south = 0;
    status s = row_height(pyramid, zoom, (int64_t)floor(y), lon, &north);
    if (!s) s = row_height(pyramid, zoom, (int64_t)floor(y) + 1, lon, &south);
    *height = s ? 0 : north + (south - north) * f;
    return s;
}

void pyramid_counters(struct pyramid *p, struct pyramid_counters *out)
{
    *out = (struct pyramid_counters){.decoded = atomic_load(&p->decoded),
                                     .synthesised = atomic_load(&p->synthesised),
                                     .upsampled = atomic_load(&p->upsampled),
                                     .corrupt = atomic_load(&p->corrupt)};
    cache_counters(p->cache, &out->cache_hits, &out->cache_bytes);
}
