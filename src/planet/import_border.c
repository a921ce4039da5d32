#include "planet/import_border.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "planet/import_bounded.h"
#include "planet/pyramid_make.h"
#include "planet/source.h"
#include "planet/store.h"

enum { SAMPLES = TILE_SIZE * TILE_SIZE, SHOWN_BYTES = 32 << 20 };

// The finished tiles up to one zoom, and what they show.
struct ground {
    struct source source;
    struct planet_writer *writer;
    int zoom;
    struct pyramid *pyramid; // NULL: not asked for yet
};

struct border {
    struct workshop *workshop;
    struct ground grounds[GRID_MAX_ZOOM + 1];
    float shares[SAMPLES], below[SAMPLES], keep[SAMPLES], heights[SAMPLES];
};

static bool ground_has(const struct source *source, tile_id id)
{
    const struct ground *g = (const struct ground *)source;
    return id.layer == LAYER_HEIGHT && id.zoom <= g->zoom && planet_writer_has(g->writer, id);
}

static status ground_read(struct source *source, tile_id id, struct want *want, void *samples,
                          double *until_s)
{
    (void)want;
    *until_s = INFINITY;
    return bounded_read(&(bounded_source){.writer = ((struct ground *)source)->writer}, id,
                        samples);
}

static void ground_close(struct source *source)
{
    (void)source;
}

static const struct source_ops ground_ops = {ground_has, ground_read, NULL, ground_close};

static status show(struct border *b, struct planet_writer *writer, int zoom, tile_id id,
                   const pyramid_tile **out)
{
    struct ground *g = &b->grounds[zoom];
    status s = OK;
    if (!g->pyramid) {
        g->source = (struct source){.ops = &ground_ops, .path = "the file being written"};
        for (int i = 0; i < LAYER_COUNT; i++) g->source.meta.max_zoom[i] = -1;
        g->source.meta.max_zoom[LAYER_HEIGHT] = g->zoom = zoom;
        g->writer = writer;
        const pyramid_params params = {.cache_bytes = SHOWN_BYTES, .synthesis = SYNTHESIS_NONE};
        const pyramid_layer layer = {.source = &g->source, .opacity = 1};
        s = pyramid_create_stack(&layer, 1, &params, &g->pyramid);
        if (!s) g->pyramid->over = true; // where nothing is, it shows nothing
    }
    return s ? s : pyramid_acquire(g->pyramid, id, out);
}

struct border *border_create(struct workshop *workshop)
{
    struct border *b = NEW(struct border);
    b->workshop = workshop;
    return b;
}

void border_destroy(struct border **border)
{
    if (!*border) return;
    for (int i = 0; i <= GRID_MAX_ZOOM; i++) pyramid_destroy(&(*border)->grounds[i].pyramid);
    free(*border);
    *border = NULL;
}

bool border_meets(const struct border *b, tile_id id)
{
    return workshop_has_border(b->workshop, id);
}

static void put_ground(struct border *b, const float *shown)
{
    for (int i = 0; i < SAMPLES; i++) {
        float ground = shown[i], share = b->shares[i], keep = b->keep[i];
        if (isnan(ground) || (share == 0 && keep == 1)) continue;
        float own = b->heights[i] - share * b->below[i] - (1 - share) * ground;
        b->heights[i] = ground + keep * own;
    }
}

static status widen_ranges(struct border *b, struct planet_writer *writer, double wider,
                           planet_row *row)
{
    float low = row->min, high = row->max;
    for (int i = 0; i < SAMPLES; i++) {
        low = b->heights[i] < low ? b->heights[i] : low;
        high = b->heights[i] > high ? b->heights[i] : high;
    }
    bool same = low >= row->min && high <= row->max;
    row->min = low;
    row->max = high;
    status s = OK;
    for (tile_id up = row->id; !same && !s && up.zoom > 0;) {
        up = tile_parent(up);
        s = planet_writer_widen(writer, up, (double)low - wider, (double)high + wider);
    }
    return s;
}

status border_mend(struct border *b, struct planet_writer *writer, double wider, planet_row *row,
                   bool *mended)
{
    int zoom;
    const pyramid_tile *shown = NULL;
    *mended = false;
    status s = workshop_below(b->workshop, 0, row->id, b->shares, b->below, b->keep, &zoom);
    if (s || zoom < 0) return s;
    s = codec_height_decode(row->body.data, row->body.size, b->heights);
    if (!s) s = show(b, writer, zoom, row->id, &shown);
    if (s) return s;
    put_ground(b, shown->heights);
    pyramid_release(b->grounds[zoom].pyramid, &shown);
    codec_blob body;
    s = workshop_encode(b->workshop, 0, row->id, b->heights, &body);
    if (s) return s;
    *mended = true;
    row->body = body;
    row->hash = store_hash(body.data, body.size);
    return widen_ranges(b, writer, wider, row);
}
