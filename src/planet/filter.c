#include "planet/filter.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/vec.h"
#include "base/vector.h"

// A parent step of longitude is at most MAX_RATIO child steps (tests/planet/test_filter.c looks at
// every row).
enum { MAX_CHANNELS = 3, MAX_RATIO = 4, LANES = 32 };

// Child sample rows in reach of a parent's, and more: child rows `HELD` apart share room.
enum { HELD = 8 };

// Stands anywhere among floats.
typedef float eight __attribute__((vector_size(32), aligned(4), may_alias));

// The children of one child tile row that a parent may need, side by side from `first` on,
// wrapping.
struct child_row {
    int row, first, count, cols;
    const float **tiles;
    bool has_nan;
};

// Taps of one child sample row on one parent sample row.
struct filter_taps {
    int64_t line;   // child sample row
    int ratio;      // child samples in one parent step of longitude
    int64_t start;  // leftmost child column of the tile row's first parent column
    int64_t period; // child columns around the planet
    int count;
    size_t weights; // in the room's
    double total;
};

struct work {
    int channels;
    tile_id parent;
    struct filter_room *room;
    struct child_row rows[6];
    int row_count;
    int64_t held[HELD]; // child sample rows whose samples are in the room's phases; -1: none
    double sum[MAX_CHANNELS][TILE_SIZE], weight[TILE_SIZE];
};

static double child_reach(tile_id parent)
{
    return FILTER_REACH * grid_step_lat(parent.zoom);
}

// Widest half-angle of longitude that the filter spans from parent colatitude t0 to child
// colatitude t.
static double reach_lon(double reach, double t0, double t)
{
    double s = sin((t - t0) / 2), a = 4 * s * s, b = 4 * sin(t0) * sin(t);
    double q = reach * reach - a;
    if (q < 0) return -1;
    return q >= b ? M_PI : 2 * asin(sqrt(q / b));
}

static double child_colatitude(int zoom, int64_t line)
{
    return ((double)line + 0.5) * grid_step_lat(zoom);
}

// Child tile columns that the whole parent tile needs from child tile row `row`.
static void find_columns(tile_id parent, struct child_row *r)
{
    double west, south, east, north, reach = child_reach(parent);
    grid_bounds(parent, &west, &south, &east, &north);
    int zoom = parent.zoom + 1;
    r->cols = grid_cols(zoom, r->row);
    tile_id child = {parent.layer, zoom, r->row, 0};
    double child_west, child_south, child_east, child_north;
    grid_bounds(child, &child_west, &child_south, &child_east, &child_north);
    // The filter spans most longitude where the circles of latitude are smallest: at the poleward
    // edges, as far as they are in reach of each other. Colatitudes from the nearer pole.
    double at = M_PI / 2 - fmax(fabs(south), fabs(north));
    double child_at = M_PI / 2 - fmax(fabs(child_south), fabs(child_north));
    double circle =
        sin(fmax(0, fmax(at, child_at - reach))) * sin(fmax(0, fmax(child_at, at - reach)));
    double lon = 4 * circle > reach * reach ? 2 * asin(reach / (2 * sqrt(circle))) : M_PI;
    double width = child_east - child_west;
    int first = (int)floor((west - lon + M_PI) / width - 0.01);
    int last = (int)floor((east + lon + M_PI) / width + 0.01);
    if (last - first + 1 >= r->cols) {
        first = 0;
        last = r->cols - 1;
    }
    r->count = last - first + 1;
    r->first = (first % r->cols + r->cols) % r->cols;
}

static void fetch_row(struct work *w, int row, filter_fetch fetch, void *user)
{
    struct child_row *r = &w->rows[w->row_count++];
    *r = (struct child_row){.row = row};
    find_columns(w->parent, r);
    r->tiles = NEW_ARRAY(const float *, (size_t)r->count);
    for (int i = 0; i < r->count; i++) {
        tile_id child = {w->parent.layer, w->parent.zoom + 1, row, (r->first + i) % r->cols};
        bool has_nan = true;
        r->tiles[i] = fetch(user, child, &has_nan);
        r->has_nan |= !r->tiles[i] || has_nan;
    }
}

static struct filter_span *span_of(struct filter_room *room, int64_t line)
{
    return &room->spans[line - (2 * (int64_t)room->row * TILE_SIZE - FILTER_MARGIN)];
}

static void *resize(void *from, size_t used, size_t bytes)
{
    char *to = NEW_ARRAY(char, bytes);
    if (used) memcpy(to, from, used);
    free(from);
    return to;
}

static struct filter_taps *add_taps(struct filter_room *room, size_t weights)
{
    if (room->taps_used == room->taps_size) {
        room->taps_size = 2 * room->taps_size + 1024;
        room->taps = resize(room->taps, room->taps_used * sizeof *room->taps,
                            room->taps_size * sizeof *room->taps);
    }
    if (room->weights_used + weights > room->weights_size) {
        room->weights_size = 2 * (room->weights_used + weights);
        room->weights = resize(room->weights, room->weights_used * sizeof(float),
                               room->weights_size * sizeof(float));
    }
    struct filter_taps *k = &room->taps[room->taps_used++];
    k->weights = room->weights_used;
    room->weights_used += weights;
    return k;
}

// Weights of child sample row `line` for parent sample row at colatitude t0; none when it is out of
// reach. Columns are counted from the tile row's first.
static void make_taps(struct filter_room *room, double t0, int64_t line)
{
    int zoom = room->zoom + 1, child_row = (int)(line / TILE_SIZE);
    double step = grid_step_lat(room->zoom), t = child_colatitude(zoom, line);
    double lon = reach_lon(FILTER_REACH * step, t0, t), child_lon = grid_step_lon(zoom, child_row);
    if (lon < 0) return;
    int ratio = (int)lround(grid_step_lon(room->zoom, room->row) / child_lon);
    assert(ratio >= 1 && ratio <= MAX_RATIO);
    int64_t period = (int64_t)grid_cols(zoom, child_row) * TILE_SIZE;
    // Parent column 0 stands at x0 in child columns; a parent step is a whole number of them.
    double x0 = 0.5 * ratio - 0.5;
    int64_t low = (int64_t)ceil(x0 - lon / child_lon), high = (int64_t)floor(x0 + lon / child_lon);
    if (high - low + 1 > period || lon >= M_PI) {
        low = (int64_t)floor(x0) - period / 2;
        high = low + period - 1;
    }
    int count = (int)(high - low + 1);
    if (count <= 0) return;
    struct filter_taps *k = add_taps(room, (size_t)count);
    float *weights = room->weights + k->weights;
    *k = (struct filter_taps){line, ratio, low, period, count, k->weights, 0};
    double half = sin((t - t0) / 2), a = 4 * half * half, b = 4 * sin(t0) * sin(t);
    double scale = -0.5 / (FILTER_SIGMA * FILTER_SIGMA * step * step);
    double area = sin(t) * child_lon / step;
    double rim = exp(scale * FILTER_REACH * FILTER_REACH * step * step);
    for (int i = 0; i < count; i++) {
        // As far on the other side of x0 as a tap that is there already?
        int64_t mirrored = (int64_t)(2 * x0) - low - (low + i);
        if (mirrored >= 0 && mirrored < i) {
            weights[i] = weights[mirrored];
        } else {
            double s = sin((double)(low + i - x0) * child_lon / 2);
            weights[i] = (float)(area * fmax(0, exp(scale * (a + b * s * s)) - rim));
        }
        k->total += (double)weights[i];
    }
}

// What each child sample row is read for: the columns under all of its taps.
static void find_spans(struct filter_room *room)
{
    int most = 0;
    for (int i = 0; i < FILTER_LINES; i++) room->spans[i] = (struct filter_span){0, 0};
    for (size_t i = 0; i < room->taps_used; i++) {
        const struct filter_taps *k = &room->taps[i];
        struct filter_span *span = span_of(room, k->line);
        int64_t end = k->start + k->count, old = span->start + span->count;
        if (!span->count || k->start < span->start) span->start = k->start;
        span->count = (int)((span->count && old > end ? old : end) - span->start);
        if (span->count > most) most = span->count;
    }
    room->held_size = (size_t)(most + MAX_RATIO * (TILE_SIZE + 1));
    room->strip = resize(room->strip, 0, room->held_size * sizeof(float));
    room->phases = resize(room->phases, 0, HELD * MAX_CHANNELS * room->held_size * sizeof(float));
}

// All taps of a tile row, which its tiles share.
static void plan_row(struct filter_room *room, tile_id parent)
{
    if (room->taps && room->zoom == parent.zoom && room->row == parent.row) return;
    int zoom = parent.zoom + 1;
    double step = grid_step_lat(zoom), reach = child_reach(parent);
    int64_t lines = (int64_t)grid_rows(zoom) * TILE_SIZE;
    room->zoom = parent.zoom;
    room->row = parent.row;
    room->taps_used = room->weights_used = 0;
    for (int line = 0; line < TILE_SIZE; line++) {
        double t0 = child_colatitude(parent.zoom, (int64_t)parent.row * TILE_SIZE + line);
        int64_t low = (int64_t)ceil((t0 - reach) / step - 0.5),
                high = (int64_t)floor((t0 + reach) / step - 0.5);
        room->first[line] = room->taps_used;
        for (int64_t child = low < 0 ? 0 : low; child <= high && child < lines; child++)
            make_taps(room, t0, child);
    }
    room->first[TILE_SIZE] = room->taps_used;
    find_spans(room);
}

// The child samples that a parent's row needs, in a row; NaN where a child is not stored.
static void gather_strip(const struct work *w, const struct filter_taps *k,
                         const struct filter_span *span, const struct child_row *children,
                         int channel)
{
    int64_t need = (int64_t)(TILE_SIZE - 1) * k->ratio + span->count, done = 0;
    int64_t start = span->start + (int64_t)w->parent.col * TILE_SIZE * k->ratio;
    int64_t line = channel * TILE_SIZE + k->line % TILE_SIZE;
    while (done < need) {
        int64_t column = ((start + done) % k->period + k->period) % k->period;
        int tile = (int)(column / TILE_SIZE), inside = (int)(column % TILE_SIZE);
        int64_t run = TILE_SIZE - inside < need - done ? TILE_SIZE - inside : need - done;
        int slot = (tile - children->first + children->cols) % children->cols;
        const float *plane = slot < children->count ? children->tiles[slot] : NULL;
        float *to = w->room->strip + done;
        if (plane) memcpy(to, plane + line * TILE_SIZE + inside, (size_t)run * sizeof *to);
        for (int64_t i = 0; !plane && i < run; i++) to[i] = NAN;
        done += run;
    }
}

// Every `ratio`-th sample of the strip, from each of the first `ratio` on, `stride` of each.
VECTOR_CLONES static void split_phases(const float *strip, int ratio, int stride, float *phases)
{
    if (ratio == 2)
        for (int i = 0; i < stride; i++) {
            phases[i] = strip[2 * i];
            phases[stride + i] = strip[2 * i + 1];
        }
    else
        for (int p = 0; p < ratio; p++)
            for (int i = 0; i < stride; i++) phases[p * stride + i] = strip[ratio * i + p];
}

// Samples under taps: those under the first, for parent column 0, and how to go on.
struct under {
    const float *first;
    int phase, stride, ratio;
};

// From the samples under one tap to those under the next.
VECTOR_INLINE const float *next_tap(const struct under *u, const float *under, int *phase)
{
    if (++*phase < u->ratio) return under + u->stride;
    *phase = 0;
    return under - (u->ratio - 1) * u->stride + 1;
}

// The samples of a child row are gathered once for all parent rows that need them.
static struct under find_under(struct work *w, const struct filter_taps *k,
                               const struct child_row *children, int channel)
{
    struct filter_room *room = w->room;
    const struct filter_span *span = span_of(room, k->line);
    int stride = TILE_SIZE + (span->count - 1) / k->ratio, slot = (int)(k->line % HELD);
    float *phases = room->phases + (size_t)(slot * MAX_CHANNELS) * room->held_size;
    for (int c = 0; c < w->channels && w->held[slot] != k->line; c++) {
        gather_strip(w, k, span, children, c);
        split_phases(room->strip, k->ratio, stride, phases + (size_t)c * room->held_size);
    }
    w->held[slot] = k->line;
    int offset = (int)(k->start - span->start), phase = offset % k->ratio;
    const float *first = phases + (size_t)channel * room->held_size;
    return (struct under){first + phase * stride + offset / k->ratio, phase, stride, k->ratio};
}

// The sums of LANES parent columns stay in registers.
VECTOR_CLONES static void add_solid(const struct under *u, const float *weights, int count,
                                    double *sum)
{
    for (int column = 0; column < TILE_SIZE; column += LANES) {
        const float *s = u->first + column;
        eight line[LANES / 8] = {0};
        for (int t = 0, phase = u->phase; t < count; t++, s = next_tap(u, s, &phase))
            for (int i = 0; i < LANES / 8; i++) line[i] += weights[t] * ((const eight *)s)[i];
        float lane[LANES];
        memcpy(lane, line, sizeof lane);
        for (int i = 0; i < LANES; i++) sum[column + i] += (double)lane[i];
    }
}

// As add_solid, over samples that may be NaN; `weight` (when not NULL) receives the weight of those
// that are not.
VECTOR_CLONES static void add_sparse(const struct under *u, const float *weights, int count,
                                     double *sum, double *weight)
{
    for (int column = 0; column < TILE_SIZE; column += LANES) {
        const float *s = u->first + column;
        float line[LANES] = {0}, share[LANES] = {0};
        for (int t = 0, phase = u->phase; t < count; t++, s = next_tap(u, s, &phase)) {
            float tap = weights[t];
            for (int i = 0; i < LANES; i++) {
                bool valid = s[i] == s[i];
                line[i] += valid ? tap * s[i] : 0;
                share[i] += valid ? tap : 0;
            }
        }
        for (int i = 0; i < LANES; i++) sum[column + i] += (double)line[i];
        for (int i = 0; weight && i < LANES; i++) weight[column + i] += (double)share[i];
    }
}

VECTOR_CLONES static void take_means(const double *sum, const double *weights, double solid,
                                     float *means)
{
    for (int i = 0; i < TILE_SIZE; i++) {
        double weight = weights[i] + solid;
        means[i] = weight > 0 ? (float)(sum[i] / weight) : NAN;
    }
}

VECTOR_CLONES static void take_coverage(const double *weights, double solid, double total,
                                        float *coverage)
{
    for (int i = 0; i < TILE_SIZE; i++) {
        double share = (weights[i] + solid) / total;
        coverage[i] = share < 1 ? (float)share : 1;
    }
}

static const struct child_row *find_children(const struct work *w, int row)
{
    const struct child_row *found = w->rows;
    while (found->row != row) found++;
    return found;
}

static void filter_line(struct work *w, int line, float *planes, float *coverage)
{
    const struct filter_room *room = w->room;
    double total = 0, solid = 0;
    memset(w->sum, 0, sizeof w->sum);
    memset(w->weight, 0, sizeof w->weight);
    for (size_t at = room->first[line]; at < room->first[line + 1]; at++) {
        const struct filter_taps *k = &room->taps[at];
        const struct child_row *children = find_children(w, (int)(k->line / TILE_SIZE));
        const float *weights = room->weights + k->weights;
        total += k->total;
        if (!children->has_nan) solid += k->total;
        for (int c = 0; c < w->channels; c++) {
            struct under u = find_under(w, k, children, c);
            if (!children->has_nan) add_solid(&u, weights, k->count, w->sum[c]);
            else add_sparse(&u, weights, k->count, w->sum[c], c ? NULL : w->weight);
        }
    }
    take_coverage(w->weight, solid, total, coverage + line * TILE_SIZE);
    for (int c = 0; c < w->channels; c++)
        take_means(w->sum[c], w->weight, solid, planes + (c * TILE_SIZE + line) * TILE_SIZE);
}

void filter_room_deinit(struct filter_room *room)
{
    free(room->taps);
    free(room->weights);
    free(room->strip);
    free(room->phases);
    *room = (struct filter_room){0};
}

void filter_parent(tile_id parent, int channels, filter_fetch fetch, void *user,
                   struct filter_room *room, float *planes, float *coverage)
{
    assert(channels >= 1 && channels <= MAX_CHANNELS && parent.zoom < GRID_MAX_ZOOM);
    struct work *w = NEW(struct work);
    w->channels = channels;
    w->parent = parent;
    w->room = room;
    for (int i = 0; i < HELD; i++) w->held[i] = -1;
    plan_row(room, parent);
    for (int row = 2 * parent.row - 1; row <= 2 * parent.row + 2; row++)
        if (row >= 0 && row < grid_rows(parent.zoom + 1)) fetch_row(w, row, fetch, user);
    for (int line = 0; line < TILE_SIZE; line++) filter_line(w, line, planes, coverage);
    for (int i = 0; i < w->row_count; i++) free(w->rows[i].tiles);
    free(w);
}
