// A tile is its stored samples, and where there are none, a function of its parent's whole zoom: a
// patch upsampled, plus the synthetic residual. Making a tile acquires the parents around it, which
// may be made in turn; each level holds at most one parent at a time, while it copies from it.
#include "planet/pyramid.h"

#include <assert.h>
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "planet/cache.h"
#include "planet/patch.h"
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

static status fetch_block(void *user, const patch_block *b)
{
    struct pyramid *p = user;
    const pyramid_tile *tile;
    status s = cache_acquire(p->cache, b->tile, &tile);
    if (s) return s;
    for (int r = 0; r < b->rows; r++) {
        size_t at = (size_t)(b->row + r) * TILE_SIZE + b->col;
        float *out = b->out + (size_t)r * b->stride;
        if (tile->heights) memcpy(out, tile->heights + at, (size_t)b->cols * sizeof *out);
        else
            for (int i = 0; i < 4 * b->cols; i++) out[i] = tile->rgba[4 * at + i];
    }
    cache_release(p->cache, &tile);
    return OK;
}

// One made row: the patch upsampled, and where `amplitude` is given, with its residual.
static void make_row(const struct patch *patch, int row, const float *amplitude,
                     const synthesis_columns *columns, float out[TILE_SIZE])
{
    bool flat[TILE_SIZE], any = false;
    upsample_height_row(patch, row, out, flat);
    if (!amplitude) return;
    float share[TILE_SIZE], noise[TILE_SIZE];
    upsample_linear_row(patch, amplitude, row, share);
    for (int i = 0; i < TILE_SIZE; i++) {
        share[i] = flat[i] ? 0.0f : share[i];
        any |= share[i] > 0.0f;
    }
    if (!any) return;
    int zoom = patch->child.zoom;
    synthesis_noise_row(columns, zoom, grid_lat(zoom, (int64_t)TILE_SIZE * patch->child.row + row),
                        noise);
    for (int i = 0; i < TILE_SIZE; i++) out[i] += share[i] * noise[i];
}

// Replaces what is NaN in `heights` by what the parents give.
static status fill_heights(struct pyramid *p, const struct patch *patch, float *heights)
{
    bool noisy = p->synthesis && p->meta->synthesis_gain > 0.0;
    float *amplitude = NULL;
    synthesis_columns columns;
    if (noisy) {
        amplitude = malloc(sizeof *amplitude * PATCH_ROWS * patch->cols);
        if (!amplitude) return ERR_MEMORY;
        synthesis_relief(patch, amplitude);
        synthesis_amplitude(patch, p->meta->synthesis_gain, p->meta->max_zoom[LAYER_HEIGHT],
                            p->meta->ellipsoid.a, amplitude);
        synthesis_columns_init(&columns, patch->child);
    }
    for (int row = 0; row < TILE_SIZE; row++) {
        float made[TILE_SIZE], *out = heights + row * TILE_SIZE;
        make_row(patch, row, amplitude, &columns, made);
        for (int i = 0; i < TILE_SIZE; i++) out[i] = isnan(out[i]) ? made[i] : out[i];
    }
    free(amplitude);
    noisy ? p->synthesised++ : p->upsampled++;
    return OK;
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

static status make_heights(struct pyramid *p, tile_id id, float *heights, float *min, float *max)
{
    bool found;
    status s = read_stored(p, id, heights, &found);
    if (!s && !found)
        for (int i = 0; i < SAMPLES; i++) heights[i] = NAN;
    if (!s && (!found || has_nan(heights))) {
        struct patch patch;
        if (id.zoom == 0 || tile_index_max_zoom(p->index[LAYER_HEIGHT]) < 0) {
            for (int i = 0; i < SAMPLES; i++) heights[i] = isnan(heights[i]) ? 0.0f : heights[i];
        } else if (!(s = patch_init(&patch, id, 1, fetch_block, p))) {
            s = fill_heights(p, &patch, heights);
            patch_deinit(&patch);
        }
    }
    if (!s) measure_range(heights, min, max);
    return s;
}

// What a planet without imagery looks like, and no light.
static const uint8_t BARE_GROUND[4] = {156, 150, 140, 0};

// Colour and light where they are stored; both if need be from the parents.
static status make_rgba(struct pyramid *p, tile_id id, uint8_t *rgba)
{
    uint8_t *stored = malloc(SAMPLES * 4); // RGB, then light
    if (!stored) return ERR_MEMORY;
    tile_id night = id;
    night.layer = LAYER_NIGHT;
    bool has_color, has_night = false;
    status s = read_stored(p, id, stored, &has_color);
    if (!s) s = read_stored(p, night, stored + SAMPLES * 3, &has_night);
    bool color_known = has_color || tile_index_max_zoom(p->index[LAYER_COLOR]) < 0;
    bool night_known = has_night || tile_index_max_zoom(p->index[LAYER_NIGHT]) < 0;
    struct patch patch;
    if (s || (color_known && night_known) || id.zoom == 0) {
        for (int i = 0; i < SAMPLES; i++) memcpy(rgba + 4 * i, BARE_GROUND, 4);
    } else if (!(s = patch_init(&patch, id, 4, fetch_block, p))) {
        upsample_rgba(&patch, rgba);
        patch_deinit(&patch);
        p->upsampled++;
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
