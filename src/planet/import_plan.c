#include "planet/import_plan.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

struct span {
    int first, last;
};

struct region {
    double west, south, east, north;
};

// Four rows of children of so many rows of tiles may be more than is kept.
enum { BLOCK = 8, BLOCK_ABOVE = 128 };

// What is left of a row: from `col` on, inside spans[at], to the east or the west as the walk goes.
// Spans are merged and ascending.
struct cursor {
    int row, cols;
    struct span *spans;
    int span_count, at, col;
};

// Invariant: `left` tiles are to come, `in_block` of them in the block begun.
struct plan_walk {
    enum tile_layer layer;
    int zoom, step, height, block;
    uint64_t left, in_block;
    struct region *regions;
    int region_count;
    struct cursor cursors[BLOCK]; // rows of the block in the order of the walk
};

bool plan_bounds_are_global(const plan_bounds *b)
{
    return b->east - b->west >= 2 * M_PI && b->south <= -M_PI / 2 && b->north >= M_PI / 2;
}

bool plan_bounds_hold(const plan_bounds *b, double lat, double lon)
{
    if (lat < b->south || lat > b->north) return false;
    double offset = lon - b->west;
    offset -= 2 * M_PI * floor(offset / (2 * M_PI));
    return offset <= b->east - b->west;
}

// A region grown by a distance on the ground (rad); all of the circle where it holds a pole.
static struct region grow(struct region r, double reach)
{
    double far = fmax(fabs(r.south), fabs(r.north)) + reach;
    double across = far < M_PI / 2 ? fmin(reach / cos(far), M_PI) : M_PI;
    return (struct region){r.west - across, r.south - reach, r.east + across, r.north + reach};
}

// Parts of the grid's extent that lie inside the bounds, shifted by whole turns into any place.
static void add_regions(struct plan_walk *w, const raster_grid *g, const plan_bounds *b,
                        double reach)
{
    for (int turn = -2; turn <= 2; turn++) {
        double west = fmax(g->west + 2 * M_PI * turn, b->west);
        double east = fmin(g->east + 2 * M_PI * turn, b->east);
        double south = fmax(g->south, b->south), north = fmin(g->north, b->north);
        if (west < east && south < north)
            w->regions[w->region_count++] = grow((struct region){west, south, east, north}, reach);
    }
}

static int row_of(int zoom, double lat)
{
    int row = (int)floor((M_PI / 2 - lat) / (grid_step_lat(zoom) * TILE_SIZE));
    return row < 0 ? 0 : row >= grid_rows(zoom) ? grid_rows(zoom) - 1 : row;
}

static void add_span(struct cursor *c, int first, int last)
{
    if (first < 0) first = 0;
    if (last > c->cols - 1) last = c->cols - 1;
    if (first <= last) c->spans[c->span_count++] = (struct span){first, last};
}

static int compare_spans(const void *a, const void *b)
{
    const struct span *x = a, *y = b;
    return (x->first > y->first) - (x->first < y->first);
}

static void merge_spans(struct cursor *c)
{
    qsort(c->spans, (size_t)c->span_count, sizeof *c->spans, compare_spans);
    int n = 0;
    for (int i = 0; i < c->span_count; i++) {
        struct span s = c->spans[i];
        if (n && s.first <= c->spans[n - 1].last + 1) {
            if (s.last > c->spans[n - 1].last) c->spans[n - 1].last = s.last;
        } else {
            c->spans[n++] = s;
        }
    }
    c->span_count = n;
}

// Tiles of the row.
static uint64_t begin_row(const struct plan_walk *w, struct cursor *c, int row)
{
    uint64_t count = 0;
    c->row = row;
    c->span_count = 0;
    if (row >= grid_rows(w->zoom)) return 0;
    double height = grid_step_lat(w->zoom) * TILE_SIZE, north = M_PI / 2 - row * height;
    double width = grid_step_lon(w->zoom, row) * TILE_SIZE;
    c->cols = grid_cols(w->zoom, row);
    for (int i = 0; i < w->region_count; i++) {
        const struct region *r = &w->regions[i];
        if (r->south >= north || r->north <= north - height) continue;
        for (int turn = -2; turn <= 2; turn++) {
            double west = r->west + 2 * M_PI * turn + M_PI, east = r->east + 2 * M_PI * turn + M_PI;
            if (east <= 0 || west >= 2 * M_PI) continue;
            add_span(c, (int)floor(west / width), (int)ceil(east / width) - 1);
        }
    }
    merge_spans(c);
    for (int i = 0; i < c->span_count; i++)
        count += (uint64_t)(c->spans[i].last - c->spans[i].first + 1);
    c->at = w->step > 0 ? 0 : c->span_count - 1;
    if (count) c->col = w->step > 0 ? c->spans[0].first : c->spans[c->at].last;
    return count;
}

static void begin_block(struct plan_walk *w)
{
    w->in_block = 0;
    for (int i = 0; i < w->height; i++)
        w->in_block += begin_row(w, &w->cursors[i],
                                 w->block * w->height + (w->step > 0 ? i : w->height - 1 - i));
}

static bool is_done(const struct cursor *c)
{
    return c->at < 0 || c->at >= c->span_count;
}

// Does a's tile begin before b's, in the walk's direction?
static bool is_before(const struct plan_walk *w, const struct cursor *a, const struct cursor *b)
{
    if (w->step > 0) return (int64_t)a->col * b->cols < (int64_t)b->col * a->cols;
    return ((int64_t)a->col + 1) * b->cols > ((int64_t)b->col + 1) * a->cols;
}

static tile_id take(struct plan_walk *w)
{
    struct cursor *c = NULL;
    for (; !w->in_block; begin_block(w)) w->block += w->step;
    for (int i = 0; i < w->height; i++) {
        struct cursor *other = &w->cursors[i];
        if (!is_done(other) && (!c || is_before(w, other, c))) c = other;
    }
    tile_id id = {w->layer, w->zoom, c->row, c->col};
    const struct span *span = &c->spans[c->at];
    w->left--;
    w->in_block--;
    if (c->col != (w->step > 0 ? span->last : span->first)) {
        c->col += w->step;
        return id;
    }
    c->at += w->step;
    if (!is_done(c)) c->col = w->step > 0 ? c->spans[c->at].first : c->spans[c->at].last;
    return id;
}

static void skip(struct plan_walk *w, uint64_t count)
{
    while (count) {
        for (; !w->in_block; begin_block(w)) w->block += w->step;
        if (w->in_block <= count) {
            count -= w->in_block;
            w->left -= w->in_block;
            w->in_block = 0;
        } else {
            for (; count; count--) take(w);
        }
    }
}

static void make_room(struct plan_walk *w)
{
    for (int i = 0; i < w->height; i++)
        w->cursors[i].spans = NEW_ARRAY(struct span, (size_t)w->region_count * 5 + 1);
}

// Counts the tiles, block by block, and stands before the first block.
static void begin_walk(struct plan_walk *w)
{
    int first = grid_rows(w->zoom), last = -1;
    for (int i = 0; i < w->region_count; i++) {
        int north = row_of(w->zoom, w->regions[i].north);
        int south = row_of(w->zoom, w->regions[i].south);
        if (north < first) first = north;
        if (south > last) last = south;
    }
    first /= w->height;
    last = last < 0 ? -1 : last / w->height;
    for (w->block = first; w->block <= last; w->block++) {
        begin_block(w);
        w->left += w->in_block;
    }
    w->in_block = 0;
    w->block = w->step > 0 ? first - 1 : last + 1;
}

struct plan_walk *plan_walk_begin(enum tile_layer layer, int zoom, const raster_grid *grids,
                                  int count, const plan_bounds *bounds, int reach)
{
    struct plan_walk *w = NEW(struct plan_walk);
    bool finest = true;
    w->layer = layer;
    w->zoom = zoom;
    w->step = zoom % 2 ? 1 : -1;
    w->regions = NEW_ARRAY(struct region, (size_t)count * 5 + 1);
    for (int i = 0; i < count; i++) {
        finest = finest && grids[i].zoom <= zoom;
        if (grids[i].zoom >= zoom)
            add_regions(w, &grids[i], bounds,
                        grids[i].zoom > zoom ? reach * grid_step_lat(zoom) : 0);
    }
    w->height = finest || grid_rows(zoom) < BLOCK_ABOVE ? 1 : BLOCK;
    make_room(w);
    begin_walk(w);
    return w;
}

bool plan_walk_next(struct plan_walk *w, tile_id *id)
{
    if (!w->left) return false;
    *id = take(w);
    return true;
}

uint64_t plan_walk_left(const struct plan_walk *w)
{
    return w->left;
}

struct plan_walk *plan_walk_split(struct plan_walk *w, uint64_t keep)
{
    struct plan_walk *rest = NEW(struct plan_walk);
    assert(keep <= w->left);
    *rest = *w;
    rest->regions = NEW_ARRAY(struct region, (size_t)w->region_count + 1);
    memcpy(rest->regions, w->regions, (size_t)w->region_count * sizeof *w->regions);
    make_room(rest);
    for (int i = 0; i < w->height; i++)
        memcpy(rest->cursors[i].spans, w->cursors[i].spans,
               (size_t)w->cursors[i].span_count * sizeof *w->cursors[i].spans);
    w->left = keep;
    skip(rest, keep);
    return rest;
}

void plan_walk_end(struct plan_walk **walk)
{
    if (!*walk) return;
    for (int i = 0; i < (*walk)->height; i++) free((*walk)->cursors[i].spans);
    free((*walk)->regions);
    free(*walk);
    *walk = NULL;
}
