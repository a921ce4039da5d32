// A stack of pyramids, each over one source, and a cache of what they make together.
#include "planet/pyramid.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "planet/pyramid_make.h"

enum { SAMPLES = PYRAMID_SAMPLES, MIN_CACHE_BYTES = 16 << 20, DEFAULT_CACHE_BYTES = 256 << 20 };

static void mix_heights(const float *over, float opacity, float *heights)
{
    for (int i = 0; i < SAMPLES; i++)
        if (!isnan(over[i])) heights[i] += opacity * (over[i] - heights[i]);
}

// A keeps the light of the ground, as far as it is not covered.
static void mix_pixels(const uint8_t *over, float opacity, uint8_t *rgba)
{
    for (int i = 0; i < SAMPLES; i++) {
        float left = 1 - opacity * (float)over[4 * i + 3] / 255;
        for (int c = 0; c < 3; c++)
            rgba[4 * i + c] =
                (uint8_t)fminf(opacity * over[4 * i + c] + left * rgba[4 * i + c] + 0.5f, 255);
    }
}

// Does the layer hold any such tile, or one to make it from?
static bool has_layer(const struct pyramid *p, enum tile_layer layer)
{
    return p->own.max_zoom[layer] >= 0;
}

static status mix_tile(void *user, struct want *want, tile_id id, void *samples,
                       struct cache_made *made)
{
    struct pyramid *p = user;
    bool heights = id.layer == LAYER_HEIGHT;
    status pending = OK;
    for (int k = -1; k < p->over_count; k++) {
        struct pyramid *layer = k < 0 ? p : p->overs[k];
        const pyramid_tile *tile;
        if (k >= 0 && !has_layer(layer, id.layer)) continue;
        status s = cache_acquire(layer->cache, want, id, &tile);
        if (s == ERR_PENDING) pending = s;
        if (s && s != ERR_PENDING) return s;
        if (s) continue;
        if (k < 0) memcpy(samples, heights ? (const void *)tile->heights : tile->rgba, SAMPLES * 4);
        else if (heights) mix_heights(tile->heights, p->opacity[k], samples);
        else mix_pixels(tile->rgba, p->opacity[k], samples);
        made->until_s = fmin(made->until_s, tile->until_s);
        cache_release(layer->cache, &tile);
    }
    if (!pending && heights) pyramid_measure_range(samples, made);
    return pending;
}

static size_t cache_share(const pyramid_params *params, int parts)
{
    size_t bytes = params->cache_bytes ? params->cache_bytes : DEFAULT_CACHE_BYTES;
    if (bytes < MIN_CACHE_BYTES) bytes = MIN_CACHE_BYTES;
    return bytes / (size_t)parts;
}

static struct pyramid *layer_create(struct source *source, const pyramid_params *params, int parts)
{
    struct pyramid *p = NEW(struct pyramid);
    p->source = source;
    p->own = p->meta = source->meta;
    p->synthesis = params->synthesis;
    p->cache = cache_create(cache_share(params, parts), pyramid_make_tile, p);
    p->edges = blend_create(PYRAMID_FADE_ROWS, PYRAMID_FADE_MASKS);
    return p;
}

static status add_over(struct pyramid *p, const pyramid_layer *layer, const pyramid_params *params,
                       int parts)
{
    const struct planet_meta *m = &layer->source->meta;
    const geo_ellipsoid *e = &p->meta.ellipsoid;
    double b =
        geo_is_plane(*e) ? m->ellipsoid.a : m->ellipsoid.b; // a plane is of the equator's scale
    double off = fmax(fabs(m->ellipsoid.a - e->a), fabs(b - e->b));
    if (m->ellipsoid.a > 0 && off > 1e-3 * e->a) {
        log_error("%s: of a body with radii %.0f and %.0f m, which cannot lie on one with %.0f and "
                  "%.0f m",
                  layer->source->path, m->ellipsoid.a, m->ellipsoid.b, e->a, e->b);
        return ERR_ARGUMENT;
    }
    struct pyramid *over = layer_create(layer->source, params, parts);
    over->over = true;
    over->own.ellipsoid = *e;
    if (!(over->own.synthesis_gain > 0)) over->own.synthesis_gain = p->own.synthesis_gain;
    p->opacity[p->over_count] = layer->opacity;
    p->overs[p->over_count++] = over;
    for (int i = 0; i < LAYER_NIGHT; i++)
        if (m->max_zoom[i] > p->meta.max_zoom[i]) p->meta.max_zoom[i] = m->max_zoom[i];
    if (m->max_zoom[LAYER_HEIGHT] >= 0) {
        p->meta.height_min = fmin(p->meta.height_min, m->height_min);
        p->meta.height_max = fmax(p->meta.height_max, m->height_max);
    }
    size_t used = strlen(p->meta.attribution);
    if (m->attribution[0] && !strstr(p->meta.attribution, m->attribution))
        snprintf(p->meta.attribution + used, sizeof p->meta.attribution - used, "%s%s",
                 used ? "; " : "", m->attribution);
    return OK;
}

status pyramid_create_stack(const pyramid_layer *layers, int count, const pyramid_params *params,
                            struct pyramid **out)
{
    assert(count >= 1 && count <= PYRAMID_MAX_LAYERS);
    int parts = count > 1 ? count + 1 : 1;
    struct pyramid *p = layer_create(layers[0].source, params, parts);
    if (!(p->own.ellipsoid.a > 0)) p->own.ellipsoid = p->meta.ellipsoid = GEO_WGS84;
    if (params->flat && !geo_is_plane(p->meta.ellipsoid))
        p->own.ellipsoid = p->meta.ellipsoid = geo_plane_of(p->meta.ellipsoid);
    p->overs = NEW_ARRAY(struct pyramid *, (size_t)count);
    p->opacity = NEW_ARRAY(float, (size_t)count);
    status s = OK;
    for (int i = 1; !s && i < count; i++) s = add_over(p, &layers[i], params, parts);
    if (count > 1) p->mixed = cache_create(cache_share(params, parts), mix_tile, p);
    if (s) pyramid_destroy(&p);
    *out = p;
    return s;
}

status pyramid_create(struct planet_file *file, const pyramid_params *params, struct pyramid **out)
{
    *out = NULL;
    pyramid_layer layer = {.opacity = 1};
    status s = source_file_open(file, &layer.source);
    if (!s) s = pyramid_create_stack(&layer, 1, params, out);
    if (*out) (*out)->owned = true;
    else source_close(&layer.source);
    return s;
}

void pyramid_destroy(struct pyramid **pyramid)
{
    struct pyramid *p = *pyramid;
    if (!p) return;
    cache_destroy(&p->mixed);
    for (int i = 0; i < p->over_count; i++) pyramid_destroy(&p->overs[i]);
    cache_destroy(&p->cache);
    blend_destroy(&p->edges);
    if (p->owned) source_close(&p->source);
    free(p->overs);
    free(p->opacity);
    free(p);
    *pyramid = NULL;
}

const struct planet_meta *pyramid_meta(const struct pyramid *p)
{
    return &p->meta;
}

bool pyramid_synthesises(const struct pyramid *p)
{
    bool any = p->synthesis && p->own.synthesis_gain > 0;
    for (int i = 0; i < p->over_count; i++) any |= pyramid_synthesises(p->overs[i]);
    return any;
}

enum synthesis pyramid_synthesis(const struct pyramid *p)
{
    return p->own.synthesis_gain > 0 ? p->synthesis : SYNTHESIS_NONE;
}

bool pyramid_derives(const struct pyramid *p, tile_id id)
{
    region tile = region_of_tile(id, 1, NULL);
    return !p->over_count && id.layer == LAYER_HEIGHT && id.zoom > 0 && pyramid_synthesis(p) &&
           p->own.max_zoom[LAYER_HEIGHT] >= 0 && !pyramid_beside_stored(p, &tile);
}

static void assert_on_grid(tile_id id)
{
    assert(id.zoom >= 0 && id.zoom <= GRID_MAX_ZOOM);
    assert(id.row >= 0 && id.row < grid_rows(id.zoom));
    assert(id.col >= 0 && id.col < grid_cols(id.zoom, id.row));
    (void)id;
}

status pyramid_try(struct pyramid *p, tile_id id, struct want *want, const pyramid_tile **out)
{
    assert(id.layer == LAYER_HEIGHT || id.layer == LAYER_COLOR);
    assert_on_grid(id);
    return cache_acquire(p->mixed ? p->mixed : p->cache, want, id, out);
}

status pyramid_acquire(struct pyramid *p, tile_id id, const pyramid_tile **out)
{
    const double again_s = 0.1; // should news be missed, or nobody want to wait any more
    struct want *want = want_create(-1);
    status s;
    while ((s = pyramid_try(p, id, want, out)) == ERR_PENDING && !p->given_up)
        want_wait(want, again_s);
    want_release(&want);
    return s == ERR_PENDING ? ERR_CANCELLED : s;
}

void pyramid_give_up(struct pyramid *p)
{
    p->given_up = true;
}

void pyramid_release(struct pyramid *p, const pyramid_tile **tile)
{
    cache_release(p->mixed ? p->mixed : p->cache, tile);
}

static int layer_data_zoom(const struct pyramid *p, tile_id id)
{
    while (!source_has(p->source, id)) {
        if (id.zoom == 0) return -1;
        id = tile_parent(id);
    }
    return id.zoom;
}

int pyramid_data_zoom(struct pyramid *p, tile_id id)
{
    assert_on_grid(id);
    int zoom = layer_data_zoom(p, id);
    for (int i = 0; i < p->over_count; i++) {
        int over = layer_data_zoom(p->overs[i], id);
        zoom = over > zoom ? over : zoom;
    }
    return zoom;
}

// How tiles are had for a height: from memory alone, or asked for by the want; without it waited
// for.
struct look {
    struct pyramid *pyramid;
    struct want *want;
    bool held;
};

static status look_at_tile(const struct look *l, tile_id id, const pyramid_tile **out)
{
    struct pyramid *p = l->pyramid;
    if (l->held) {
        *out = cache_peek(p->mixed ? p->mixed : p->cache, id);
        return *out ? OK : ERR_PENDING;
    }
    return l->want ? pyramid_try(p, id, l->want, out) : pyramid_acquire(p, id, out);
}

// Height on the centre line of one global sample row, linear in longitude; a row beyond a pole is
// the row as far before it, on the opposite meridian.
static status height_on_row(const struct look *l, int zoom, int64_t row, double lon, double *height)
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
        status s = look_at_tile(l, id, &tile);
        if (s) return s;
        h[i] = tile->heights[row % TILE_SIZE * TILE_SIZE + col % TILE_SIZE];
        pyramid_release(l->pyramid, &tile);
    }
    *height = h[0] + (x - west) * (h[1] - h[0]);
    return OK;
}

static status height_at(const struct look *l, int zoom, double lat, double lon, double *height)
{
    assert(isfinite(lat) && isfinite(lon));
    *height = 0.0;
    lat = clamp_double(lat, -M_PI / 2, M_PI / 2);
    double y = (M_PI / 2 - lat) / grid_step_lat(zoom) - 0.5, north = floor(y), a, b;
    status s = height_on_row(l, zoom, (int64_t)north, lon, &a);
    if (!s) s = height_on_row(l, zoom, (int64_t)north + 1, lon, &b);
    if (!s) *height = a + (y - north) * (b - a);
    return s;
}

static int on_grid(int zoom)
{
    return zoom < 0 ? 0 : zoom > GRID_MAX_ZOOM ? GRID_MAX_ZOOM : zoom;
}

status pyramid_height_at(struct pyramid *p, int zoom, double lat, double lon, double *height)
{
    return height_at(&(struct look){.pyramid = p}, on_grid(zoom), lat, lon, height);
}

status pyramid_height_try(struct pyramid *p, int zoom, double lat, double lon, struct want *want,
                          double *height)
{
    return height_at(&(struct look){.pyramid = p, .want = want}, on_grid(zoom), lat, lon, height);
}

int pyramid_height_held(struct pyramid *p, int zoom, double lat, double lon, double *height)
{
    const struct look held = {.pyramid = p, .held = true};
    zoom = on_grid(zoom);
    while (zoom >= 0 && height_at(&held, zoom, lat, lon, height)) zoom--;
    return zoom;
}

static void add_counters(struct pyramid *p, struct pyramid_counters *out)
{
    struct source_counters source;
    uint64_t hits, bytes;
    source_counters(p->source, &source);
    cache_counters(p->cache, &hits, &bytes);
    out->decoded += p->decoded;
    out->synthesised += p->synthesised;
    out->upsampled += p->upsampled;
    out->corrupt += source.corrupt;
    out->failed += source.failed;
    out->cache_hits += hits;
    out->cache_bytes += bytes;
}

void pyramid_counters(struct pyramid *p, struct pyramid_counters *out)
{
    *out = (struct pyramid_counters){0};
    add_counters(p, out);
    for (int i = 0; i < p->over_count; i++) add_counters(p->overs[i], out);
    if (!p->mixed) return;
    uint64_t hits, bytes;
    cache_counters(p->mixed, &hits, &bytes);
    out->cache_hits += hits;
    out->cache_bytes += bytes;
}
