#include "planet/import_border.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "planet/import_blend.h"
#include "planet/import_bounded.h"
#include "planet/pyramid_make.h"
#include "planet/source.h"
#include "planet/store.h"

enum { SAMPLES = TILE_SIZE * TILE_SIZE, SHOWN_BYTES = 32 << 20, KEPT_MASKS = 4096 };

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
    int zoom;            // of the tile before
    struct blend *edges; // of holes; NULL: they stay as they are
    struct blend_room room;
    border_gaps gaps;
    void *user;
    float shares[SAMPLES], below[SAMPLES], keep[SAMPLES], heights[SAMPLES], inward[SAMPLES];
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
    int feather = workshop_feather(workshop);
    if (feather > 0) b->edges = blend_create(feather, KEPT_MASKS);
    return b;
}

void border_reads(struct border *b, border_gaps gaps, void *user)
{
    b->gaps = gaps;
    b->user = user;
}

static void forget_grounds(struct border *b)
{
    for (int i = 0; i <= GRID_MAX_ZOOM; i++) pyramid_destroy(&b->grounds[i].pyramid);
}

void border_destroy(struct border **border)
{
    if (!*border) return;
    forget_grounds(*border);
    blend_destroy(&(*border)->edges);
    blend_room_deinit(&(*border)->room);
    free(*border);
    *border = NULL;
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

static status mend_border(struct border *b, struct planet_writer *writer, tile_id id)
{
    const pyramid_tile *shown = NULL;
    int zoom = workshop_zoom_below(b->workshop, id);
    status s = workshop_below(b->workshop, 0, id, b->shares, b->below, b->keep);
    if (!s) s = show(b, writer, zoom, id, &shown);
    if (s) return s;
    put_ground(b, shown->heights);
    pyramid_release(b->grounds[zoom].pyramid, &shown);
    return OK;
}

// A blend_read: where there is no hole.
static status read_solid(void *user, int none, tile_id id, unsigned char *mask)
{
    struct border *b = user;
    unsigned char inside[SAMPLES / 8];
    int gaps = 0;
    (void)none;
    status s = b->gaps(b->user, id, mask);
    if (s && s != ERR_NOT_FOUND) return s;
    if (s) memset(mask, 0xff, SAMPLES / 8);
    for (int i = 0; i < SAMPLES / 8; i++) gaps |= mask[i];
    s = gaps ? workshop_inside(b->workshop, 0, id, inside) : OK;
    for (int i = 0; !s && i < SAMPLES / 8; i++)
        mask[i] = (unsigned char)~(gaps ? mask[i] & inside[i] : 0);
    return s;
}

// Weights against the holes' edges in b->inward. *any: some is less than 1.
static status find_holes(struct border *b, tile_id id, bool *any)
{
    *any = false;
    if (!b->edges) return OK;
    // The first sample beside a hole is what the zoom before shows.
    bool finest = id.zoom == workshop_finest(b->workshop);
    float margin = finest ? 0.5f : 0.5f * (float)workshop_feather(b->workshop);
    region tile = region_of_tile(id, 1, NULL);
    status s = blend_region(b->edges, &tile, margin, read_solid, b, &b->room, b->inward);
    for (int i = 0; !s && i < SAMPLES; i++) *any |= b->inward[i] < 1;
    return s;
}

static status mend_holes(struct border *b, struct planet_writer *writer, tile_id id)
{
    const pyramid_tile *shown = NULL;
    int zoom = id.zoom - 1;
    status s = show(b, writer, zoom, id, &shown);
    if (s) return s;
    for (int i = 0; i < SAMPLES; i++) {
        float ground = shown->heights[i], inward = b->inward[i];
        if (inward < 1 && !isnan(ground))
            b->heights[i] = ground + inward * (b->heights[i] - ground);
    }
    pyramid_release(b->grounds[zoom].pyramid, &shown);
    return OK;
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

static status mend(struct border *b, struct planet_writer *writer, const planet_row *row,
                   bool border, bool holes)
{
    status s = codec_height_decode(row->body.data, row->body.size, b->heights);
    if (!s && border) s = mend_border(b, writer, row->id);
    if (!s && holes) s = mend_holes(b, writer, row->id);
    return s;
}

status border_mend(struct border *b, struct planet_writer *writer, double wider, planet_row *row,
                   bool *mended)
{
    bool border = workshop_has_border(b->workshop, row->id), holes;
    *mended = false;
    if (workshop_zoom_below(b->workshop, row->id) < 0) return OK;
    if (row->id.zoom != b->zoom) forget_grounds(b);
    b->zoom = row->id.zoom;
    status s = find_holes(b, row->id, &holes);
    if (s || !(border || holes)) return s;
    s = mend(b, writer, row, border, holes);
    if (s) return s;
    codec_blob body;
    s = workshop_encode(b->workshop, 0, row->id, b->heights, &body);
    if (s) return s;
    *mended = true;
    row->body = body;
    row->hash = store_hash(body.data, body.size);
    return widen_ranges(b, writer, wider, row);
}
