#include "planet/filter.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/vec.h"

// A parent step of longitude is at most MAX_RATIO child steps (tests/planet/test_filter.c looks at
// every row).
enum { MAX_CHANNELS = 3, MAX_RATIO = 4 };

// The children of one child tile row that a parent may need, side by side from `first` on,
// wrapping.
struct child_row {
    int row, first, count, cols;
    const float **tiles;
    bool has_nan;
};

// Taps of one child sample row on one parent sample row.
struct taps {
    const struct child_row *children;
    int child_line; // sample row inside the child tile
    int ratio;      // child samples in one parent step of longitude
    int64_t start;  // leftmost child column of parent column 0
    int64_t period; // child columns around the planet
    int count, capacity;
    float *weights;
    double total;
};

struct work {
    int channels;
    tile_id parent;
    struct child_row rows[6];
    int row_count;
    struct taps taps;
    float *strip; // room for the taps of 256 parent columns
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

static void reserve_taps(struct work *w)
{
    struct taps *k = &w->taps;
    if (k->count <= k->capacity) return;
    k->capacity = 2 * k->count;
    free(k->weights);
    free(w->strip);
    k->weights = NEW_ARRAY(float, (size_t)k->capacity);
    w->strip = NEW_ARRAY(float, (size_t)(k->capacity + MAX_RATIO * TILE_SIZE));
}

// Weights of child sample row `line` for parent sample row at colatitude t0; false when it is out
// of reach.
static bool make_taps(struct work *w, double t0, int64_t line)
{
    struct taps *k = &w->taps;
    int zoom = w->parent.zoom + 1, child_row = (int)(line / TILE_SIZE);
    double step = grid_step_lat(w->parent.zoom), t = child_colatitude(zoom, line);
    double lon = reach_lon(FILTER_REACH * step, t0, t);
    if (lon < 0) return false;
    k->children = NULL;
    for (int i = 0; i < w->row_count; i++)
        if (w->rows[i].row == child_row) k->children = &w->rows[i];
    assert(k->children);
    k->child_line = (int)(line % TILE_SIZE);
    double child_lon = grid_step_lon(zoom, child_row);
    k->ratio = (int)lround(grid_step_lon(w->parent.zoom, w->parent.row) / child_lon);
    assert(k->ratio >= 1 && k->ratio <= MAX_RATIO);
    k->period = (int64_t)k->children->cols * TILE_SIZE;
    // Parent column 0 stands at x0 in child columns; a parent step is a whole number of them.
    double x0 = ((double)w->parent.col * TILE_SIZE + 0.5) * k->ratio - 0.5;
    int64_t low = (int64_t)ceil(x0 - lon / child_lon), high = (int64_t)floor(x0 + lon / child_lon);
    if (high - low + 1 > k->period || lon >= M_PI) {
        low = (int64_t)floor(x0) - k->period / 2;
        high = low + k->period - 1;
    }
    k->start = low;
    k->count = (int)(high - low + 1);
    reserve_taps(w);
    double half = sin((t - t0) / 2), a = 4 * half * half, b = 4 * sin(t0) * sin(t);
    double scale = -0.5 / (FILTER_SIGMA * FILTER_SIGMA * step * step);
    double area = sin(t) * child_lon / step;
    double rim = exp(scale * FILTER_REACH * FILTER_REACH * step * step);
    k->total = 0;
    for (int i = 0; i < k->count; i++) {
        // As far on the other side of x0 as a tap that is there already?
        int64_t mirrored = (int64_t)(2 * x0) - low - (low + i);
        if (mirrored >= 0 && mirrored < i) {
            k->weights[i] = k->weights[mirrored];
        } else {
            double s = sin((double)(low + i - x0) * child_lon / 2);
            k->weights[i] = (float)(area * fmax(0, exp(scale * (a + b * s * s)) - rim));
        }
        k->total += (double)k->weights[i];
    }
    return k->count > 0;
}

// The child samples under the taps of all parent columns, in a row; NaN where a child is not
// stored.
static void gather_strip(const struct taps *k, int channel, float *strip)
{
    int64_t need = (int64_t)(TILE_SIZE - 1) * k->ratio + k->count, done = 0;
    while (done < need) {
        int64_t column = ((k->start + done) % k->period + k->period) % k->period;
        int tile = (int)(column / TILE_SIZE), inside = (int)(column % TILE_SIZE);
        int64_t run = TILE_SIZE - inside < need - done ? TILE_SIZE - inside : need - done;
        int slot = (tile - k->children->first + k->children->cols) % k->children->cols;
        const float *plane = slot < k->children->count ? k->children->tiles[slot] : NULL;
        if (plane) {
            const float *from =
                plane + ((size_t)channel * TILE_SIZE + (size_t)k->child_line) * TILE_SIZE;
            memcpy(strip + done, from + inside, (size_t)run * sizeof(float));
        } else {
            for (int64_t i = 0; i < run; i++) strip[done + i] = NAN;
        }
        done += run;
    }
}

static void add_solid(const struct taps *k, const float *strip, double *sum)
{
    float line[TILE_SIZE] = {0};
    for (int t = 0; t < k->count; t++) {
        const float *s = strip + t;
        float weight = k->weights[t];
        if (k->ratio == 2)
            for (int i = 0; i < TILE_SIZE; i++) line[i] += weight * s[2 * i];
        else
            for (int i = 0; i < TILE_SIZE; i++) line[i] += weight * s[k->ratio * i];
    }
    for (int i = 0; i < TILE_SIZE; i++) sum[i] += (double)line[i];
}

// As add_solid, over samples that may be NaN; `weight` (when not NULL) receives the weight of those
// that are not.
static void add_sparse(const struct taps *k, const float *strip, double *sum, double *weight)
{
    float line[TILE_SIZE] = {0}, share[TILE_SIZE] = {0};
    for (int t = 0; t < k->count; t++) {
        const float *s = strip + t;
        float tap = k->weights[t];
        for (int i = 0; i < TILE_SIZE; i++) {
            float v = s[k->ratio * i];
            bool valid = v == v;
            line[i] += valid ? tap * v : 0;
            share[i] += valid ? tap : 0;
        }
    }
    for (int i = 0; i < TILE_SIZE; i++) {
        sum[i] += (double)line[i];
        if (weight) weight[i] += (double)share[i];
    }
}

static void filter_line(struct work *w, int line, float *planes, float *coverage)
{
    int zoom = w->parent.zoom + 1;
    double total = 0, solid = 0, step = grid_step_lat(zoom), reach = child_reach(w->parent);
    double t0 = child_colatitude(w->parent.zoom, (int64_t)w->parent.row * TILE_SIZE + line);
    int64_t lines = (int64_t)grid_rows(zoom) * TILE_SIZE;
    int64_t low = (int64_t)ceil((t0 - reach) / step - 0.5),
            high = (int64_t)floor((t0 + reach) / step - 0.5);
    memset(w->sum, 0, sizeof w->sum);
    memset(w->weight, 0, sizeof w->weight);
    for (int64_t child = low < 0 ? 0 : low; child <= high && child < lines; child++) {
        if (!make_taps(w, t0, child)) continue;
        total += w->taps.total;
        bool sparse = w->taps.children->has_nan;
        if (!sparse) solid += w->taps.total;
        for (int c = 0; c < w->channels; c++) {
            gather_strip(&w->taps, c, w->strip);
            if (sparse) add_sparse(&w->taps, w->strip, w->sum[c], c ? NULL : w->weight);
            else add_solid(&w->taps, w->strip, w->sum[c]);
        }
    }
    for (int i = 0; i < TILE_SIZE; i++) {
        double weight = w->weight[i] + solid;
        double share = weight / total;
        coverage[line * TILE_SIZE + i] = share < 1 ? (float)share : 1;
        for (int c = 0; c < w->channels; c++)
            planes[(c * TILE_SIZE + line) * TILE_SIZE + i] =
                weight > 0 ? (float)(w->sum[c][i] / weight) : NAN;
    }
}

void filter_parent(tile_id parent, int channels, filter_fetch fetch, void *user, float *planes,
                   float *coverage)
{
    assert(channels >= 1 && channels <= MAX_CHANNELS && parent.zoom < GRID_MAX_ZOOM);
    struct work *w = NEW(struct work);
    w->channels = channels;
    w->parent = parent;
    for (int row = 2 * parent.row - 1; row <= 2 * parent.row + 2; row++)
        if (row >= 0 && row < grid_rows(parent.zoom + 1)) fetch_row(w, row, fetch, user);
    for (int line = 0; line < TILE_SIZE; line++) filter_line(w, line, planes, coverage);
    for (int i = 0; i < w->row_count; i++) free(w->rows[i].tiles);
    free(w->taps.weights);
    free(w->strip);
    free(w);
}
