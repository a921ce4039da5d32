#include "planet/import_base.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "planet/filter.h"
#include "planet/import_light.h"
#include "planet/pyramid.h"

enum { SAMPLES = TILE_SIZE * TILE_SIZE, SHOWN_BYTES = 64 << 20 };

struct import_base {
    struct planet_file *file;
    struct source *source;   // for its index
    struct pyramid *pyramid; // what it shows
};

status import_base_open(const char *path, struct import_base **out)
{
    struct import_base *b = NEW(struct import_base);
    const pyramid_params params = {.cache_bytes = SHOWN_BYTES, .synthesis = SYNTHESIS_NONE};
    status s = planet_file_open(path, &b->file);
    if (!s) s = source_file_open(b->file, &b->source);
    const pyramid_layer ground = {.source = b->source, .opacity = 1};
    if (!s) s = pyramid_create_stack(&ground, 1, &params, &b->pyramid);
    if (s) import_base_close(&b);
    *out = b;
    return s;
}

void import_base_close(struct import_base **base)
{
    struct import_base *b = *base;
    if (!b) return;
    pyramid_destroy(&b->pyramid);
    source_close(&b->source);
    planet_file_close(&b->file);
    free(b);
    *base = NULL;
}

const char *import_base_path(const struct import_base *b)
{
    return planet_file_path(b->file);
}

const struct planet_meta *import_base_meta(const struct import_base *b)
{
    return planet_file_meta(b->file);
}

bool import_base_has(const struct import_base *b, tile_id id)
{
    return source_has(b->source, id);
}

bool import_base_has_finer(const struct import_base *b, tile_id id)
{
    if (id.zoom >= b->source->meta.max_zoom[id.layer]) return false;
    for (int row = 2 * id.row; row < 2 * id.row + 2; row++) {
        int columns = grid_cols(id.zoom + 1, row) / grid_cols(id.zoom, id.row);
        for (int i = 0; i < columns; i++)
            if (source_has(b->source, (tile_id){id.layer, id.zoom + 1, row, id.col * columns + i}))
                return true;
    }
    return false;
}

double import_base_step(const struct import_base *b, enum tile_layer layer, double lat, double lon)
{
    for (int zoom = b->source->meta.max_zoom[layer]; zoom >= 0; zoom--) {
        int row = (int)((M_PI / 2 - lat) / (grid_step_lat(zoom) * TILE_SIZE));
        row = row < grid_rows(zoom) ? row : grid_rows(zoom) - 1;
        int col = (int)((geo_wrap_lon(lon) + M_PI) / (grid_step_lon(zoom, row) * TILE_SIZE));
        col = col < grid_cols(zoom, row) ? col : grid_cols(zoom, row) - 1;
        if (source_has(b->source, (tile_id){layer, zoom, row, col})) return grid_step_lat(zoom);
    }
    return 0;
}

static int channels_of(tile_id id)
{
    return id.layer == LAYER_COLOR ? 3 : 1;
}

// 8-bit pixels, every `stride`th byte a channel's, to planes of linear light.
static void split(const unsigned char *pixels, int stride, int channels, float *planes)
{
    for (int c = 0; c < channels; c++)
        for (int i = 0; i < SAMPLES; i++) planes[c * SAMPLES + i] = pixels[i * stride + c];
    light_decode(planes, (size_t)SAMPLES * (size_t)channels);
}

status import_base_read(struct import_base *b, tile_id id, float *planes)
{
    if (id.layer == LAYER_HEIGHT) return planet_file_read_height(b->file, id, planes);
    int channels = channels_of(id);
    unsigned char *pixels = malloc((size_t)SAMPLES * (size_t)channels);
    if (!pixels) return ERR_MEMORY;
    status s = planet_file_read_pixels(b->file, id, pixels);
    if (!s) split(pixels, channels, channels, planes);
    free(pixels);
    return s;
}

status import_base_gaps(struct import_base *b, tile_id id, unsigned char *mask)
{
    float *heights = malloc(SAMPLES * sizeof *heights);
    if (!heights) return ERR_MEMORY;
    status s = planet_file_read_height(b->file, id, heights);
    memset(mask, 0, SAMPLES / 8);
    for (int i = 0; !s && i < SAMPLES; i++)
        if (isnan(heights[i])) mask[i / 8] |= (unsigned char)(1u << (i % 8));
    free(heights);
    return s;
}

// The children that a filter has asked for.
struct children {
    struct import_base *base;
    float **planes;
    int count;
    status failed;
};

static const float *fetch_child(void *user, tile_id id, bool *has_nan)
{
    struct children *c = user;
    size_t samples = (size_t)SAMPLES * (size_t)channels_of(id);
    *has_nan = id.layer == LAYER_HEIGHT;
    if (c->failed || !import_base_has(c->base, id)) return NULL;
    float *planes = malloc(samples * sizeof *planes);
    status s = planes ? import_base_read(c->base, id, planes) : ERR_MEMORY;
    if (s) {
        if (s != ERR_NOT_FOUND) c->failed = s;
        free(planes);
        return NULL;
    }
    float **grown = NEW_ARRAY(float *, (size_t)c->count + 1);
    if (c->count) memcpy(grown, c->planes, (size_t)c->count * sizeof *grown);
    free(c->planes);
    c->planes = grown;
    return c->planes[c->count++] = planes;
}

// Stored is v + share (mean - v); v alone.
static void take_off(float *planes, int channels, const float *mean, const float *shares,
                     double step)
{
    const float told = 0.9999f; // from here on nothing of v is left
    for (int i = 0; i < SAMPLES; i++) {
        float share = shares[i], stored = planes[i];
        if (!(share > 0) || share > told || isnan(stored)) continue;
        bool all = channels == 1 && share >= 0.5f && fabs(stored - mean[i]) <= step / 2;
        for (int c = 0; c < channels; c++) {
            float *v = &planes[c * SAMPLES + i];
            *v = all ? NAN : (*v - share * mean[c * SAMPLES + i]) / (1 - share);
        }
    }
}

status import_base_read_alone(struct import_base *b, tile_id id, double step, float *planes)
{
    status s = import_base_read(b, id, planes);
    if (s || !import_base_has_finer(b, id)) return s;
    int channels = channels_of(id);
    struct children c = {.base = b};
    float *mean = malloc((size_t)(channels + 1) * SAMPLES * sizeof *mean);
    if (!mean) return ERR_MEMORY;
    float *shares = mean + channels * SAMPLES;
    struct filter_room room = {0};
    filter_parent(id, channels, fetch_child, &c, &room, mean, shares);
    filter_room_deinit(&room);
    if (!c.failed) take_off(planes, channels, mean, shares, step);
    for (int i = 0; i < c.count; i++) free(c.planes[i]);
    free(c.planes);
    free(mean);
    return c.failed;
}

// Is there data all around? Coarser tiles have some beyond the end of finer data, and what is made
// of a sample at an end is made of nothing too.
static bool is_inside(const float *heights, int x, int y)
{
    const int last = TILE_SIZE - 1;
    for (int v = y > 2 ? y - 2 : 0; v <= (y < last - 2 ? y + 2 : last); v++)
        for (int u = x > 2 ? x - 2 : 0; u <= (x < last - 2 ? x + 2 : last); u++)
            if (isnan(heights[v * TILE_SIZE + u])) return false;
    return true;
}

// Marks the samples of `id` in whose place a tile above has data. Returns how many are not marked.
static int mark(tile_id id, tile_id above, const float *heights, bool *data)
{
    int missing = 0, rows = 1 << (id.zoom - above.zoom);
    double columns = grid_step_lon(above.zoom, above.row) / grid_step_lon(id.zoom, id.row);
    for (int i = 0; i < SAMPLES; i++) {
        double line = (double)id.row * TILE_SIZE + i / TILE_SIZE;
        double column = (double)id.col * TILE_SIZE + i % TILE_SIZE + 0.5;
        int y = (int)(line / rows) - above.row * TILE_SIZE;
        int x = (int)(column / columns) - above.col * TILE_SIZE;
        if (!data[i]) data[i] = is_inside(heights, x, y);
        missing += !data[i];
    }
    return missing;
}

// What the pyramid fills in where the planet has nothing at all is no data.
static status leave_out_nothing(struct import_base *b, tile_id id, float *heights)
{
    bool data[SAMPLES] = {false};
    float *above = malloc(SAMPLES * sizeof *above);
    if (!above) return ERR_MEMORY;
    int missing = SAMPLES;
    status s = OK;
    for (tile_id t = id; missing && !s; t = tile_parent(t)) {
        s = import_base_read(b, t, above);
        if (!s) missing = mark(id, t, above, data);
        if (s == ERR_NOT_FOUND) s = OK;
        if (t.zoom == 0) break;
    }
    for (int i = 0; missing && i < SAMPLES; i++)
        if (!data[i]) heights[i] = NAN;
    free(above);
    return s;
}

status import_base_show(struct import_base *b, tile_id id, float *planes)
{
    tile_id asked = id;
    if (id.layer == LAYER_NIGHT) asked.layer = LAYER_COLOR;
    const pyramid_tile *tile;
    status s = pyramid_acquire(b->pyramid, asked, &tile);
    if (s) return s;
    if (id.layer == LAYER_HEIGHT) memcpy(planes, tile->heights, SAMPLES * sizeof *planes);
    else if (id.layer == LAYER_COLOR) split(tile->rgba, 4, 3, planes);
    else split(tile->rgba + 3, 4, 1, planes);
    pyramid_release(b->pyramid, &tile);
    return id.layer == LAYER_HEIGHT ? leave_out_nothing(b, id, planes) : OK;
}
