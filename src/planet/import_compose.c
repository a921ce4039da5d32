// The sources that meet in a tile, laid over each other. They are taken from the top down, until
// nothing of what lies below shows through.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "planet/import_workshop.h"
#include "planet/quantum.h"

// A share of a sample smaller than this does not count.
#define LEAST_SHARE 5e-4f

struct rank {
    int input, priority, zoom;
};

static int compare_ranks(const void *a, const void *b)
{
    const struct rank *x = a, *y = b;
    if (x->priority != y->priority) return x->priority < y->priority ? -1 : 1;
    if (x->zoom != y->zoom) return x->zoom < y->zoom ? -1 : 1;
    return x->input - y->input;
}

struct below {
    const struct workshop *workshop;
    int mosaic;
};

// outline_width: the one asked for, in metres or in samples of the mosaic, or the distance of the
// samples of what lies below there.
static double seam_width(void *user, double lat, double lon)
{
    const struct below *below = user;
    const struct workshop *w = below->workshop;
    double asked = w->params.feather_m, radius = w->params.ellipsoid.a;
    if (asked == 0)
        asked = w->params.feather * grid_step_lat(w->mosaics[below->mosaic].zoom) * radius;
    for (int i = w->mosaics[below->mosaic].first - 1; i >= 0; i--) {
        const raster_grid *g = &w->params.grids[w->order[i]];
        if (outline_holds(g, lat, lon)) return asked > 0 ? asked : g->dlat * radius;
    }
    enum tile_layer layer = w->params.inputs[0].source.layer;
    double step = w->params.base ? import_base_step(w->params.base, layer, lat, lon) : 0;
    return step > 0 && asked > 0 ? asked : step * radius;
}

void compose_plan(struct workshop *w)
{
    int count = w->params.count;
    struct rank *ranks = NEW_ARRAY(struct rank, (size_t)count);
    for (int i = 0; i < count; i++)
        ranks[i] = (struct rank){i, w->params.inputs[i].source.priority, w->params.grids[i].zoom};
    qsort(ranks, (size_t)count, sizeof *ranks, compare_ranks);
    w->order = NEW_ARRAY(int, (size_t)count);
    w->mosaics = NEW_ARRAY(struct mosaic, (size_t)count);
    for (int i = 0; i < count; i++) {
        bool begins = i == 0 || ranks[i].priority != ranks[i - 1].priority ||
                      ranks[i].zoom != ranks[i - 1].zoom;
        if (begins) w->mosaics[w->mosaic_count++] = (struct mosaic){i, 0, ranks[i].zoom, NULL};
        w->mosaics[w->mosaic_count - 1].count++;
        w->order[i] = ranks[i].input;
    }
    free(ranks);
    int lowest = w->params.base ? 0 : 1;
    bool seams = w->params.feather_m != 0 || w->params.feather > 0;
    for (int at = lowest; at < w->mosaic_count && seams; at++) {
        const struct mosaic *m = &w->mosaics[at];
        struct below below = {w, at};
        w->mosaics[at].outline = outline_create(w->params.grids, w->order + m->first, m->count,
                                                w->params.ellipsoid.a, seam_width, &below);
    }
}

void compose_plan_deinit(struct workshop *w)
{
    for (int i = 0; i < w->mosaic_count; i++) outline_destroy(&w->mosaics[i].outline);
    free(w->mosaics);
    free(w->order);
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

static bool touches(const struct workshop *w, const struct mosaic *m, tile_id id)
{
    for (int i = 0; i < m->count; i++)
        if (resample_touches(&w->params.grids[w->order[m->first + i]], id)) return true;
    return false;
}

// One input's samples in b->source.
static status read_input(struct workshop *w, struct bench *b, int input, tile_id id)
{
    struct raster *raster;
    status s = open_input(w, b, input, &raster);
    if (s) return s;
    s = resample_tile(raster, id, &b->room, b->source);
    if (s && !atomic_flag_test_and_set(&w->reported))
        log_error("%s",
                  s == ERR_MEMORY ? "out of memory for a part of a raster" : raster_error(raster));
    return s;
}

// One input's samples in b->source, as heights above the ellipsoid and inside the bounds.
static status read_source(struct workshop *w, struct bench *b, int input, tile_id id)
{
    status s = read_input(w, b, input, id);
    if (s) return s;
    struct raster *raster;
    s = open_input(w, b, input, &raster);
    if (!s && id.layer == LAYER_HEIGHT) {
        s = raster_to_ellipsoid(raster, id, b->source);
        if (s && !atomic_flag_test_and_set(&w->reported)) log_error("%s", raster_error(raster));
    }
    return s;
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

static void stack_clear(struct stack *s)
{
    memset(s->sum, 0, sizeof s->sum);
    memset(s->laid, 0, sizeof s->laid);
    memset(s->own, 0, sizeof s->own);
    for (int i = 0; i < SAMPLES; i++) s->left[i] = s->through[i] = 1;
}

// Puts `planes`, where they have data, under what is there; weights NULL: they hide all below.
// seams: the weights of the borders alone; NULL: the same.
static void stack_lay(struct stack *s, int channels, const float *planes, const float *weights,
                      const float *seams, bool own)
{
    for (int i = 0; i < SAMPLES; i++) {
        if (isnan(planes[i]) || !(s->left[i] > 0)) continue;
        float take = weights ? weights[i] : 1, share = s->left[i] * take;
        for (int c = 0; c < channels; c++)
            s->sum[c * SAMPLES + i] += share * planes[c * SAMPLES + i];
        s->laid[i] += share;
        if (own) s->own[i] += share;
        s->left[i] = take < 1 ? s->left[i] * (1 - take) : 0;
        s->through[i] *= 1 - (seams ? seams[i] : take);
    }
}

// Before heights of coarser sources are laid: holes' edges are blended into sources of the tile's
// own zoom alone. What coarser tiles show in a hole, the join knows (import_border.h).
static void stack_close_holes(struct stack *s)
{
    for (int i = 0; i < SAMPLES; i++) {
        float laid = s->laid[i];
        if (!(laid > 0) || s->own[i] != laid || !(s->left[i] > s->through[i])) continue;
        s->sum[i] *= (1 - s->through[i]) / laid;
        s->laid[i] = s->own[i] = 1 - s->through[i];
        s->left[i] = s->through[i];
    }
}

// The mean of what was laid, NaN where nothing was.
static void stack_mean(const struct stack *s, int channels, float *planes)
{
    for (int i = 0; i < SAMPLES; i++) {
        float laid = s->laid[i];
        for (int c = 0; c < channels; c++) {
            float sum = s->sum[c * SAMPLES + i];
            planes[c * SAMPLES + i] = laid == 1 ? sum : laid > 0 ? sum / laid : NAN;
        }
    }
}

// Does anything laid so far let what lies below show through (`partly`: but not wholly)?
static bool stack_shows(const struct stack *s, bool partly)
{
    for (int i = 0; i < SAMPLES; i++)
        if (s->left[i] > 0 && (!partly || s->left[i] < 1)) return true;
    return false;
}

static void add_mask(const float *plane, unsigned char *mask)
{
    for (int i = 0; i < SAMPLES; i++)
        if (!isnan(plane[i])) mask[i / 8] |= (unsigned char)(1u << (i % 8));
}

// blend_read: the data of a whole mosaic (or of one input: the numbers after the mosaics') in a
// tile of its own zoom.
static status read_mask(void *user, int number, tile_id id, unsigned char *mask)
{
    struct bench *b = user;
    struct workshop *w = b->workshop;
    bool whole = number < w->mosaic_count;
    const struct mosaic *m = whole ? &w->mosaics[number] : NULL;
    for (int i = 0; i < (whole ? m->count : 1); i++) {
        int input = whole ? w->order[m->first + i] : number - w->mosaic_count;
        if (!resample_touches(&w->params.grids[input], id)) continue;
        status s = read_input(w, b, input, id);
        if (s) return s;
        add_mask(b->source, mask);
    }
    return OK;
}

static status find_weights(struct workshop *w, struct bench *b, int number, int zoom, tile_id id)
{
    return blend_weights(w->blend, number, zoom, id, read_mask, b, &b->blend_room, b->weights);
}

// One mosaic in b->source. Within it the inputs lie over each other, blended where they overlap.
static status read_mosaic(struct workshop *w, struct bench *b, const struct mosaic *m, tile_id id)
{
    int inputs[2] = {-1, -1}, count = 0;
    for (int i = m->count - 1; i >= 0 && count < 2; i--)
        if (resample_touches(&w->params.grids[w->order[m->first + i]], id))
            inputs[count++] = w->order[m->first + i];
    if (count == 1) return read_source(w, b, inputs[0], id);
    stack_clear(&b->mosaic);
    for (int i = m->count - 1; i >= 0 && stack_shows(&b->mosaic, false); i--) {
        int input = w->order[m->first + i];
        if (!resample_touches(&w->params.grids[input], id)) continue;
        status s = OK;
        if (w->blend) s = find_weights(w, b, w->mosaic_count + input, m->zoom, id);
        if (!s) s = read_source(w, b, input, id);
        if (s) return s;
        stack_lay(&b->mosaic, w->channels, b->source, w->blend ? b->weights : NULL, NULL, true);
    }
    stack_mean(&b->mosaic, w->channels, b->source);
    return OK;
}

// What shows in the tile: heights take part only where sources of the tile's own zoom do.
static bool is_wanted(const struct workshop *w, const struct bench *b, int at, tile_id id)
{
    const struct mosaic *m = &w->mosaics[at];
    if (m->zoom > id.zoom || !touches(w, m, id)) return false;
    if (id.layer != LAYER_HEIGHT || m->zoom == id.zoom) return stack_shows(&b->all, false);
    if (stack_shows(&b->all, true)) return true;
    for (int i = 0; i < at; i++)
        if (w->mosaics[i].zoom == id.zoom && touches(w, &w->mosaics[i], id)) return true;
    return false;
}

// The weights of a mosaic over what lies below it, in b->weights; of its border alone in b->seams.
static status find_seam(struct workshop *w, struct bench *b, int at, tile_id id)
{
    const struct mosaic *m = &w->mosaics[at];
    for (int i = 0; i < SAMPLES; i++) b->weights[i] = b->seams[i] = 1;
    status s = w->blend ? find_weights(w, b, at, m->zoom, id) : OK;
    if (!s && m->outline) s = outline_lower(m->outline, id, 0, b->seams);
    for (int i = 0; i < SAMPLES; i++) b->weights[i] = fminf(b->weights[i], b->seams[i]);
    return s;
}

static status lay_mosaic(struct workshop *w, struct bench *b, int at, tile_id id)
{
    const struct mosaic *m = &w->mosaics[at];
    bool seam = w->blend || m->outline, below = seam && w->params.base;
    for (int i = 0; i < at && seam && !below; i++)
        below = w->mosaics[i].zoom <= id.zoom && touches(w, &w->mosaics[i], id);
    status s = read_mosaic(w, b, m, id);
    if (s) return s;
    clip(w, id, b->source);
    if (below) {
        // Finding the weights may read other tiles' masks through b->source.
        memcpy(b->tile, b->source, sizeof b->tile);
        s = find_seam(w, b, at, id);
        memcpy(b->source, b->tile, sizeof b->source);
    }
    if (!s)
        stack_lay(&b->all, w->channels, b->source, below ? b->weights : NULL,
                  below ? b->seams : NULL, m->zoom == id.zoom);
    return s;
}

// Heights of no mosaic or of one alone, as the stack would give them.
static status compose_alone(struct workshop *w, struct bench *b, const struct mosaic *m, tile_id id,
                            bool *any)
{
    int found = 0;
    if (m && m->zoom == id.zoom) {
        status s = read_mosaic(w, b, m, id);
        if (s) return s;
        clip(w, id, b->source);
        for (int i = 0; i < SAMPLES; i++) {
            b->tile[i] = b->source[i] + 0.0f; // not -0
            found += b->source[i] == b->source[i];
        }
    } else {
        for (int i = 0; i < SAMPLES; i++) b->tile[i] = NAN;
    }
    *any = found > 0;
    return OK;
}

// The planet that is added to lies below all: its own tile, and as what it shows where a seam's
// blend needs it, or pixels would be black.
static status read_base(struct workshop *w, struct bench *b, tile_id id)
{
    struct import_base *base = w->params.base;
    double quantum = w->params.quantum;
    int exponent = quantum == 0 ? 0 : quantum_tile_exponent(quantum, id, w->params.ellipsoid.a);
    return import_base_read_alone(base, id, quantum == 0 ? 0 : ldexp(1, exponent), b->source);
}

static status lay_base(struct workshop *w, struct bench *b, tile_id id)
{
    struct import_base *base = w->params.base;
    if (!base || !stack_shows(&b->all, false)) return OK;
    status s = read_base(w, b, id);
    if (!s) stack_lay(&b->all, w->channels, b->source, NULL, NULL, true);
    if (s && s != ERR_NOT_FOUND) return s;
    if (id.layer == LAYER_HEIGHT) stack_close_holes(&b->all);
    if (!stack_shows(&b->all, id.layer == LAYER_HEIGHT)) return OK;
    s = import_base_show(base, id, b->source);
    if (!s) stack_lay(&b->all, w->channels, b->source, NULL, NULL, false);
    return s;
}

status compose_sources(struct workshop *w, struct bench *b, tile_id id, bool *any)
{
    const struct mosaic *meets = NULL;
    int count = 0;
    for (int at = 0; at < w->mosaic_count; at++)
        if (w->mosaics[at].zoom <= id.zoom && touches(w, &w->mosaics[at], id)) {
            meets = &w->mosaics[at];
            count++;
        }
    if (id.layer == LAYER_HEIGHT && count <= 1 && !w->params.base)
        return compose_alone(w, b, meets, id, any);
    *any = false;
    stack_clear(&b->all);
    for (int at = w->mosaic_count - 1; at >= 0; at--) {
        if (id.layer == LAYER_HEIGHT && w->mosaics[at].zoom < id.zoom) stack_close_holes(&b->all);
        if (!is_wanted(w, b, at, id)) continue;
        status s = lay_mosaic(w, b, at, id);
        if (s) return s;
    }
    status s = lay_base(w, b, id);
    if (s) return s;
    stack_mean(&b->all, w->channels, b->tile);
    for (int i = 0; i < SAMPLES; i++) {
        if (b->all.own[i] > LEAST_SHARE) *any = true;
        else if (id.layer == LAYER_HEIGHT) b->tile[i] = NAN;
    }
    return OK;
}

// Borders

// Of what is finer than the tile nothing is told within so many of its samples of the border: as
// far as the zooms below it are made of a sample.
#define REACH_SAMPLES 2

static double margin_of(const struct workshop *w, const struct mosaic *m, tile_id id)
{
    double sample = grid_step_lat(id.zoom) * w->params.ellipsoid.a;
    return m->zoom > id.zoom ? REACH_SAMPLES * sample : 0;
}

bool compose_has_border(const struct workshop *w, tile_id id)
{
    for (int at = 0; at < w->mosaic_count; at++) {
        const struct mosaic *m = &w->mosaics[at];
        if (m->zoom >= id.zoom && m->outline && touches(w, m, id) &&
            outline_meets(m->outline, id, margin_of(w, m, id)))
            return true;
    }
    return false;
}

static bool mosaic_holds(const struct workshop *w, const struct mosaic *m, double lat, double lon)
{
    for (int i = 0; i < m->count; i++)
        if (outline_holds(&w->params.grids[w->order[m->first + i]], lat, lon)) return true;
    return false;
}

// Height 0 inside a mosaic's outline, else NaN. A row of samples crosses it where its weight is
// less than 1, so that only there the outline need be asked.
static void fill_outline(const struct workshop *w, const struct mosaic *m, tile_id id,
                         const float *weights, float *plane)
{
    double west, south, east, north, step = grid_step_lon(id.zoom, id.row);
    grid_bounds(id, &west, &south, &east, &north);
    for (int i = 0; i < SAMPLES; i++) {
        bool first = i % TILE_SIZE == 0 || weights[i] < 1 || weights[i - 1] < 1;
        double lat = grid_lat(id.zoom, (int64_t)id.row * TILE_SIZE + i / TILE_SIZE);
        double lon = west + (i % TILE_SIZE + 0.5) * step;
        if (first) plane[i] = mosaic_holds(w, m, lat, lon) ? 0 : NAN;
        else plane[i] = plane[i - 1];
    }
}

static status lay_outline(struct workshop *w, struct bench *b, const struct mosaic *m, tile_id id,
                          double margin)
{
    for (int i = 0; i < SAMPLES; i++) b->weights[i] = 1;
    status s = m->outline ? outline_lower(m->outline, id, margin, b->weights) : OK;
    if (s) return s;
    fill_outline(w, m, id, b->weights, b->source);
    clip(w, id, b->source);
    stack_lay(&b->all, 1, b->source, b->weights, NULL, true);
    return OK;
}

// What the planet that is added to has of the tile itself.
static status lay_base_own(struct workshop *w, struct bench *b, tile_id id)
{
    if (!w->params.base || !stack_shows(&b->all, false)) return OK;
    status s = read_base(w, b, id);
    for (int i = 0; !s && i < SAMPLES; i++) b->source[i] = isnan(b->source[i]) ? NAN : 0;
    if (!s) stack_lay(&b->all, 1, b->source, NULL, NULL, true);
    return s == ERR_NOT_FOUND ? OK : s;
}

// A sample less inside may be none because it lies there by less than half.
#define INSIDE_SAMPLES 1.5

status compose_outlines(struct workshop *w, struct bench *b, tile_id id)
{
    double margin = INSIDE_SAMPLES * grid_step_lat(id.zoom) * w->params.ellipsoid.a;
    status s = OK;
    stack_clear(&b->all);
    for (int at = w->mosaic_count - 1; at >= 0 && !s; at--)
        if (w->mosaics[at].zoom >= id.zoom && touches(w, &w->mosaics[at], id))
            s = lay_outline(w, b, &w->mosaics[at], id, margin);
    return s;
}

// The shares that what is not coarser than the tile has within the margin.
static status find_kept(struct workshop *w, struct bench *b, tile_id id, float *kept)
{
    status s = OK;
    stack_clear(&b->all);
    for (int at = w->mosaic_count - 1; at >= 0 && !s; at--) {
        const struct mosaic *m = &w->mosaics[at];
        if (m->zoom >= id.zoom && touches(w, m, id))
            s = lay_outline(w, b, m, id, margin_of(w, m, id));
    }
    if (!s) s = lay_base_own(w, b, id);
    for (int i = 0; i < SAMPLES; i++)
        kept[i] = b->all.own[i] > 1.01f * BLEND_LEAST_WEIGHT ? b->all.own[i] : 0;
    return s;
}

static status lay_base_below(struct workshop *w, struct bench *b, tile_id id)
{
    status s = lay_base_own(w, b, id);
    if (s || !w->params.base || !stack_shows(&b->all, true)) return s;
    s = import_base_show(w->params.base, id, b->source);
    if (!s) stack_lay(&b->all, 1, b->source, NULL, NULL, false);
    return s;
}

int compose_zoom_below(const struct workshop *w, tile_id id)
{
    int zoom = -1;
    for (int at = 0; at < w->mosaic_count; at++) {
        const struct mosaic *m = &w->mosaics[at];
        if (m->zoom < id.zoom && m->zoom > zoom && touches(w, m, id)) zoom = m->zoom;
    }
    while (w->params.base && id.zoom > zoom + 1) {
        id = tile_parent(id);
        if (import_base_has(w->params.base, id)) return id.zoom;
    }
    return zoom;
}

status compose_below(struct workshop *w, struct bench *b, tile_id id, float *kept)
{
    status s = find_kept(w, b, id, kept);
    stack_clear(&b->all);
    for (int at = w->mosaic_count - 1; at >= 0 && !s; at--) {
        const struct mosaic *m = &w->mosaics[at];
        if (!touches(w, m, id)) continue;
        if (m->zoom >= id.zoom) s = lay_outline(w, b, m, id, 0);
        else if (stack_shows(&b->all, true)) s = lay_mosaic(w, b, at, id);
    }
    return s ? s : lay_base_below(w, b, id);
}
