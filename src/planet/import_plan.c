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

// Invariant: spans[at ...] of the current row are merged and ascending; `col` is the next column
// inside spans[at]. `left` tiles are to come, in this row and those after.
struct plan_walk {
    enum tile_layer layer;
    int zoom, row, step;
    uint64_t left;
    struct region *regions;
    struct span *spans;
    int region_count, span_count, at, col;
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

static void add_span(struct plan_walk *w, int first, int last, int cols)
{
    if (first < 0) first = 0;
    if (last > cols - 1) last = cols - 1;
    if (first <= last) w->spans[w->span_count++] = (struct span){first, last};
}

static int compare_spans(const void *a, const void *b)
{
    const struct span *x = a, *y = b;
    return (x->first > y->first) - (x->first < y->first);
}

static void merge_spans(struct plan_walk *w)
{
    qsort(w->spans, (size_t)w->span_count, sizeof *w->spans, compare_spans);
    int n = 0;
    for (int i = 0; i < w->span_count; i++) {
        struct span s = w->spans[i];
        if (n && s.first <= w->spans[n - 1].last + 1) {
            if (s.last > w->spans[n - 1].last) w->spans[n - 1].last = s.last;
        } else {
            w->spans[n++] = s;
        }
    }
    w->span_count = n;
}

static void begin_row(struct plan_walk *w)
{
    double height = grid_step_lat(w->zoom) * TILE_SIZE, north = M_PI / 2 - w->row * height;
    double width = grid_step_lon(w->zoom, w->row) * TILE_SIZE;
    int cols = grid_cols(w->zoom, w->row);
    w->span_count = w->at = 0;
    for (int i = 0; i < w->region_count; i++) {
        const struct region *r = &w->regions[i];
        if (r->south >= north || r->north <= north - height) continue;
        for (int turn = -2; turn <= 2; turn++) {
            double west = r->west + 2 * M_PI * turn + M_PI, east = r->east + 2 * M_PI * turn + M_PI;
            if (east <= 0 || west >= 2 * M_PI) continue;
            add_span(w, (int)floor(west / width), (int)ceil(east / width) - 1, cols);
        }
    }
    merge_spans(w);
    if (w->span_count) w->col = w->spans[0].first;
}

// Counts the tiles, row by row, and begins at the first row.
static void begin_walk(struct plan_walk *w)
{
    int first = grid_rows(w->zoom), last = -1;
    for (int i = 0; i < w->region_count; i++) {
        int north = row_of(w->zoom, w->regions[i].north),
            south = row_of(w->zoom, w->regions[i].south);
        if (north < first) first = north;
        if (south > last) last = south;
    }
    for (w->row = first; w->row <= last; w->row++) {
        begin_row(w);
        for (int i = 0; i < w->span_count; i++)
            w->left += (uint64_t)(w->spans[i].last - w->spans[i].first + 1);
    }
    w->step = w->zoom % 2 ? 1 : -1;
    w->row = w->step > 0 ? first : last;
    if (w->left) begin_row(w);
}

struct plan_walk *plan_walk_begin(enum tile_layer layer, int zoom, const raster_grid *grids,
                                  int count, const plan_bounds *bounds, int reach)
{
    struct plan_walk *w = NEW(struct plan_walk);
    w->layer = layer;
    w->zoom = zoom;
    w->regions = NEW_ARRAY(struct region, (size_t)count * 5 + 1);
    for (int i = 0; i < count; i++)
        if (grids[i].zoom >= zoom)
            add_regions(w, &grids[i], bounds,
                        grids[i].zoom > zoom ? reach * grid_step_lat(zoom) : 0);
    w->spans = NEW_ARRAY(struct span, (size_t)w->region_count * 5 + 1);
    begin_walk(w);
    return w;
}

// Goes on by up to `most` tiles of one row; how many.
static uint64_t advance(struct plan_walk *w, uint64_t most)
{
    while (w->at >= w->span_count) {
        w->row += w->step;
        begin_row(w);
    }
    uint64_t run = (uint64_t)(w->spans[w->at].last - w->col + 1);
    if (run > most) run = most;
    w->left -= run;
    w->col += (int)run;
    if (w->col > w->spans[w->at].last && ++w->at < w->span_count) w->col = w->spans[w->at].first;
    return run;
}

bool plan_walk_next(struct plan_walk *w, tile_id *id)
{
    if (!w->left) return false;
    advance(w, 0);
    *id = (tile_id){w->layer, w->zoom, w->row, w->col};
    advance(w, 1);
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
    rest->spans = NEW_ARRAY(struct span, (size_t)w->region_count * 5 + 1);
    memcpy(rest->regions, w->regions, (size_t)w->region_count * sizeof *w->regions);
    memcpy(rest->spans, w->spans, (size_t)w->span_count * sizeof *w->spans);
    w->left = keep;
    while (keep) keep -= advance(rest, keep);
    return rest;
}

void plan_walk_end(struct plan_walk **walk)
{
    if (!*walk) return;
    free((*walk)->regions);
    free((*walk)->spans);
    free(*walk);
    *walk = NULL;
}
