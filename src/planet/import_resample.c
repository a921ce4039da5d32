#include "planet/import_resample.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vector.h"

// Standard deviation of a cubic B-spline of unit spacing is sqrt(1/3); SPREAD makes it 0.45.
#define SPREAD 0.7794
// Above this many raster columns in a tile row's width, columns are first averaged in groups that
// leave at least half.
#define GROUP_ABOVE 8.0

// A band of tile rows and the window of the raster that it needs: rows [row0, row0 + rows),
// unwrapped columns in `cols` groups of `group` from col0 on.
struct window {
    const raster_grid *grid;
    double shift;    // whole turns added to the tile's longitudes
    int first, last; // tile rows, inclusive
    int64_t row0, col0;
    int rows, cols, group;
    bool solid; // no sample is missing
};

static float *reserve(float **room, size_t *size, size_t need)
{
    if (need > *size) {
        free(*room);
        *room = calloc(need, sizeof(float));
        *size = *room ? need : 0;
    }
    return *room;
}

void resample_room_deinit(struct resample_room *room)
{
    free(room->planes);
    free(room->line);
    free(room->column);
    *room = (struct resample_room){0};
}

bool resample_touches(const raster_grid *g, tile_id id)
{
    double west, south, east, north;
    grid_bounds(id, &west, &south, &east, &north);
    if (south >= g->north || north <= g->south) return false;
    if (g->full_circle) return true;
    for (int turn = -1; turn <= 1; turn++) {
        double shift = 2 * M_PI * turn;
        if (west + shift < g->east && east + shift > g->west) return true;
    }
    return false;
}

// Fractional raster row (0 at the centre of row 0) of a tile row.
static double source_row(const raster_grid *g, tile_id id, int line)
{
    double lat = grid_lat(id.zoom, (int64_t)id.row * TILE_SIZE + line);
    return (g->north - lat) / g->dlat - 0.5;
}

// Width of a tile row in raster columns at the row's latitude.
static double columns_in_row(const raster_grid *g, tile_id id, int line)
{
    double lat = grid_lat(id.zoom, (int64_t)id.row * TILE_SIZE + line);
    return grid_step_lat(id.zoom) / (g->dlon * cos(lat));
}

// Share of the average in a row whose width is that many columns; the rest is interpolation.
static double average_share(double width)
{
    double t = clamp_double((width - 1) / 0.5, 0, 1);
    return t * t * (3 - 2 * t);
}

// As source_row, for the row that is read. An average along a circle of latitude stands for the
// centroid of its arc, which lies nearer to the pole by sinc^4(half the spline's spacing in
// longitude); the circle that is read is wider by as much.
static double read_row(const raster_grid *g, tile_id id, int line)
{
    double width = columns_in_row(g, id, line), spacing = SPREAD * width * g->dlon;
    if (spacing < 1e-3) return source_row(g, id, line);
    double half = fmin(spacing, M_PI / 2) / 2, sinc = sin(half) / half;
    double widen = 1 / (sinc * sinc * sinc * sinc) - 1;
    double lat = grid_lat(id.zoom, (int64_t)id.row * TILE_SIZE + line);
    double moved = (M_PI / 2 - fabs(lat)) * widen * average_share(width);
    return source_row(g, id, line) + copysign(moved, lat) / g->dlat;
}

// Raster column (unwrapped) of the tile's first sample, and raster columns in a tile step.
static double source_column(const raster_grid *g, tile_id id, double shift, double *step)
{
    double west, south, east, north, lon = grid_step_lon(id.zoom, id.row);
    grid_bounds(id, &west, &south, &east, &north);
    *step = lon / g->dlon;
    return (west + shift + lon / 2 - g->west) / g->dlon - 0.5;
}

// Reads unwrapped columns [col, col + cols) of one raster row, NaN where there is none. `line` has
// room for read_planes x cols samples twice.
static status read_line(struct raster *raster, int64_t row, int64_t col, int64_t cols, float *line)
{
    const raster_grid *g = raster_get_grid(raster);
    size_t n = (size_t)cols;
    float *segment = line + (size_t)g->read_planes * n;
    for (size_t i = 0; i < n * (size_t)g->channels; i++) line[i] = NAN;
    int64_t done = g->full_circle || col > 0 ? 0 : -col;
    while (done < cols) {
        int64_t real = col + done;
        if (g->full_circle) real = (real % g->width + g->width) % g->width;
        if (real >= g->width) break;
        int64_t run = g->width - real < cols - done ? g->width - real : cols - done;
        status s = raster_read(raster, (int)real, (int)row, (int)run, 1, segment);
        if (s) return s;
        for (int c = 0; c < g->channels; c++)
            memcpy(line + (size_t)c * n + done, segment + (size_t)c * (size_t)run,
                   (size_t)run * sizeof *line);
        done += run;
    }
    return OK;
}

// The raster row that stands for row `row` of the window, which may lie beyond a pole: there it is
// the row as far on the other side, half a turn away (*turned). False when there is none.
static bool real_row(const raster_grid *g, int64_t row, int64_t *real, bool *turned)
{
    *real = row;
    *turned = false;
    if (row >= 0 && row < g->height) return true;
    if (!g->full_circle) return false;
    double pole = row < 0 ? (g->north - M_PI / 2) / g->dlat : (g->north + M_PI / 2) / g->dlat;
    *real = (int64_t)llround(2 * pole - 1 - (double)row);
    *turned = true;
    return fabs(pole - (row < 0 ? 0 : g->height)) < 0.75 && *real >= 0 && *real < g->height;
}

static void group_columns(const struct window *w, const float *line, size_t row, float *planes)
{
    const raster_grid *g = w->grid;
    size_t cols = (size_t)w->cols, rows = (size_t)w->rows;
    for (int c = 0; c < g->channels; c++) {
        const float *from = line + (size_t)c * cols * (size_t)w->group;
        float *to = planes + ((size_t)c * rows + row) * cols;
        for (size_t i = 0; i < cols; i++, from += w->group) {
            float sum = 0;
            int n = 0;
            for (int k = 0; k < w->group; k++)
                if (from[k] == from[k]) {
                    sum += from[k];
                    n++;
                }
            to[i] = 2 * n >= w->group ? sum / (float)n : NAN;
        }
    }
}

// Row by row: for windows that wrap, reach beyond the raster or are grouped.
static status load_lines(struct raster *raster, const struct window *w, struct resample_room *room)
{
    const raster_grid *g = w->grid;
    int64_t cols = (int64_t)w->cols * w->group;
    float *line = reserve(&room->line, &room->line_size, (size_t)cols * (size_t)g->read_planes * 2);
    if (!line) return ERR_MEMORY;
    for (int y = 0; y < w->rows; y++) {
        int64_t row;
        bool turned;
        if (real_row(g, w->row0 + y, &row, &turned)) {
            status s = read_line(raster, row, w->col0 + (turned ? g->width / 2 : 0), cols, line);
            if (s) return s;
        } else {
            for (size_t i = 0; i < (size_t)cols * (size_t)g->channels; i++) line[i] = NAN;
        }
        group_columns(w, line, (size_t)y, room->planes);
    }
    return OK;
}

VECTOR_CLONES static bool is_solid(const float *samples, size_t count)
{
    int missing = 0;
    for (size_t i = 0; i < count; i++) missing |= samples[i] != samples[i];
    return !missing;
}

static status load_window(struct raster *raster, const struct window *w, struct resample_room *room)
{
    const raster_grid *g = w->grid;
    size_t count = (size_t)w->rows * (size_t)w->cols;
    if (!reserve(&room->planes, &room->planes_size, count * (size_t)g->read_planes))
        return ERR_MEMORY;
    int64_t col = w->col0;
    if (g->full_circle) col = (col % g->width + g->width) % g->width;
    bool inside = w->group == 1 && w->row0 >= 0 && w->row0 + w->rows <= g->height && col >= 0 &&
                  col + w->cols <= g->width;
    if (!inside) return load_lines(raster, w, room);
    return raster_read(raster, (int)col, (int)w->row0, w->cols, w->rows, room->planes);
}

// Catmull-Rom between b and c, held between them. Without branches, as all that follows, so that
// compilers make vector code of it.
VECTOR_INLINE float cubic_held(float a, float b, float c, float d, float t)
{
    float v = b + 0.5f * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
    float low = b < c ? b : c, high = b < c ? c : b;
    v = v < low ? low : v;
    return v > high ? high : v;
}

// The same where samples may be missing (`solid`: none is): NaN neighbours are replaced, the nearer
// of b and c must be there.
VECTOR_INLINE float cubic(float a, float b, float c, float d, float t, bool solid)
{
    if (solid) return cubic_held(a, b, c, d, t);
    float near = t < 0.5f ? b : c, v = cubic_held(a == a ? a : b, b, c, d == d ? d : c, t);
    bool both = (b == b) & (c == c);
    return both ? v : near;
}

VECTOR_INLINE void cubic_rows(const float *b, size_t cols, float t, bool solid, float *column)
{
    const float *a = b - cols, *c = b + cols, *d = c + cols;
    for (size_t i = 0; i < cols; i++) column[i] = cubic(a[i], b[i], c[i], d[i], t, solid);
}

// One tile row from the four raster rows around it: `column` receives w->cols values.
VECTOR_CLONES static void interpolate_rows(const struct window *w, const float *plane, double v,
                                           float *column)
{
    double base = floor(v);
    float t = (float)(v - base);
    size_t cols = (size_t)w->cols;
    const float *row = plane + (size_t)((int64_t)base - w->row0) * cols;
    if (w->solid) cubic_rows(row, cols, t, true, column);
    else cubic_rows(row, cols, t, false, column);
}

VECTOR_INLINE float b_spline(float x)
{
    x = fabsf(x);
    float y = 2 - x, far = y * y * y / 6, near = (4 - 3 * x * x * y) / 6;
    float k = x >= 1 ? far : near;
    return x >= 2 ? 0 : k;
}

// Where the samples of a tile row lie in the columns of a window: `u`, and as whole and fraction.
struct places {
    double u[TILE_SIZE];
    int base[TILE_SIZE];
    float t[TILE_SIZE];
};

static void find_places(double u0, double step, struct places *out)
{
    for (int i = 0; i < TILE_SIZE; i++) {
        out->u[i] = u0 + i * step;
        double base = floor(out->u[i]);
        out->base[i] = (int)base;
        out->t[i] = (float)(out->u[i] - base);
    }
}

VECTOR_INLINE void cubic_columns(const struct places *at, const float *column, bool solid,
                                 float *out)
{
    float a[TILE_SIZE], b[TILE_SIZE], c[TILE_SIZE], d[TILE_SIZE];
    for (int i = 0; i < TILE_SIZE; i++) {
        const float *p = column + at->base[i];
        a[i] = p[-1];
        b[i] = p[0];
        c[i] = p[1];
        d[i] = p[2];
    }
    for (int i = 0; i < TILE_SIZE; i++) out[i] = cubic(a[i], b[i], c[i], d[i], at->t[i], solid);
}

VECTOR_CLONES static void interpolate(const struct places *at, const float *column, bool solid,
                                      float *out)
{
    if (solid) cubic_columns(at, column, true, out);
    else cubic_columns(at, column, false, out);
}

// The taps of an average: raster columns low to high around each place, and the first one's
// distance in kernel spacings.
struct spans {
    int low[TILE_SIZE], high[TILE_SIZE], taps;
    float x[TILE_SIZE], inverse;
};

VECTOR_INLINE void find_spans(const struct places *at, int cols, double h, struct spans *s)
{
    s->inverse = (float)(1 / h);
    s->taps = 0;
    for (int i = 0; i < TILE_SIZE; i++) {
        int low = (int)ceil(at->u[i] - 2 * h), high = (int)floor(at->u[i] + 2 * h);
        s->low[i] = low < 0 ? 0 : low;
        s->high[i] = high > cols - 1 ? cols - 1 : high;
        s->x[i] = (float)((double)s->low[i] - at->u[i]) * s->inverse;
    }
    for (int i = 0; i < TILE_SIZE; i++) {
        int taps = s->high[i] - s->low[i] + 1;
        s->taps = taps > s->taps ? taps : s->taps;
    }
}

VECTOR_INLINE void weigh(struct spans *s, const float *column, int cols, bool solid, float *out)
{
    float v[TILE_SIZE], sum[TILE_SIZE] = {0}, weight[TILE_SIZE] = {0}, total[TILE_SIZE] = {0};
    for (int tap = 0; tap < s->taps; tap++) {
        for (int i = 0; i < TILE_SIZE; i++) {
            int from = s->low[i] + tap;
            v[i] = column[from < cols ? from : cols - 1];
        }
        for (int i = 0; i < TILE_SIZE; i++) {
            float spline = b_spline(s->x[i]), k = s->low[i] + tap <= s->high[i] ? spline : 0;
            bool here = solid || v[i] == v[i];
            float value = here ? v[i] : 0;
            total[i] += k;
            k = here ? k : 0;
            sum[i] += k * value;
            if (!solid) weight[i] += k;
            s->x[i] += s->inverse;
        }
    }
    for (int i = 0; i < TILE_SIZE; i++) {
        float found = solid ? total[i] : weight[i];
        out[i] = found > 0 && found >= 0.5f * total[i] ? sum[i] / found : NAN;
    }
}

// Weighted means of the columns around the places, spacing h; NaN where less than half the weight
// has data.
VECTOR_CLONES static void average(const struct places *at, const float *column, int cols, double h,
                                  bool solid, float *out)
{
    struct spans s;
    find_spans(at, cols, h, &s);
    if (solid) weigh(&s, column, cols, true, out);
    else weigh(&s, column, cols, false, out);
}

// One tile row from one row of raster columns; where there is no data `out` is left as it is.
// width: a tile row in columns of the window.
static void resample_row(const struct window *w, const float *column, const struct places *at,
                         double width, float *out)
{
    float mix = (float)average_share(width), v[TILE_SIZE], mean[TILE_SIZE];
    if (mix < 1) interpolate(at, column, w->solid, v);
    if (mix > 0) average(at, column, w->cols, SPREAD * width, w->solid, mean);
    if (mix >= 1) memcpy(v, mean, sizeof v);
    else if (mix > 0)
        for (int i = 0; i < TILE_SIZE; i++) v[i] += mix * (mean[i] - v[i]);
    for (int i = 0; i < TILE_SIZE; i++) out[i] = v[i] == v[i] ? v[i] : out[i];
}

static void plan_window(const raster_grid *g, tile_id id, struct window *w)
{
    double narrow = fmin(columns_in_row(g, id, w->first), columns_in_row(g, id, w->last));
    double wide = fmax(columns_in_row(g, id, w->first), columns_in_row(g, id, w->last));
    w->grid = g;
    w->group = 1;
    while (narrow / w->group > GROUP_ABOVE && w->group < g->width / 64) w->group *= 2;
    w->row0 = (int64_t)floor(read_row(g, id, w->first)) - 1;
    w->rows = (int)((int64_t)floor(read_row(g, id, w->last)) + 2 - w->row0 + 1);
    // No kernel spans more than the full circle.
    double step, u0 = source_column(g, id, w->shift, &step);
    double reach = fmin(2 * SPREAD * wide, M_PI / g->dlon) + 3 * w->group;
    w->col0 = (int64_t)floor(u0 - reach);
    w->cols = (int)ceil(((TILE_SIZE - 1) * step + 2 * reach) / w->group) + 3;
}

static status resample_band(struct raster *raster, tile_id id, struct window *w,
                            struct resample_room *room, float *planes)
{
    const raster_grid *g = raster_get_grid(raster);
    plan_window(g, id, w);
    status s = load_window(raster, w, room);
    if (s) return s;
    w->solid = is_solid(room->planes, (size_t)w->rows * (size_t)w->cols * (size_t)g->channels);
    float *column = reserve(&room->column, &room->column_size, (size_t)w->cols);
    if (!column) return ERR_MEMORY;
    double step, u0 = source_column(g, id, w->shift, &step);
    u0 = (u0 - (double)w->col0 + 0.5) / w->group - 0.5;
    step /= w->group;
    struct places at;
    find_places(u0, step, &at);
    // Half the circle, in columns, bounds the B-spline's half width 2 SPREAD width.
    double widest = 2 * M_PI / g->dlon / w->group / (4 * SPREAD);
    for (int line = w->first; line <= w->last; line++) {
        double width = fmin(columns_in_row(g, id, line) / w->group, widest);
        double v = read_row(g, id, line);
        for (int c = 0; c < g->channels; c++) {
            interpolate_rows(w, room->planes + (size_t)c * (size_t)w->rows * (size_t)w->cols, v,
                             column);
            resample_row(w, column, &at, width,
                         planes + ((size_t)c * TILE_SIZE + (size_t)line) * TILE_SIZE);
        }
    }
    return OK;
}

// Tile rows whose nearest raster row is there; false when there are none.
static bool covered_rows(const raster_grid *g, tile_id id, int *first, int *last)
{
    *first = 0;
    *last = TILE_SIZE - 1;
    while (*first <= *last && source_row(g, id, *first) < -0.5) ++*first;
    while (*last >= *first && source_row(g, id, *last) > g->height - 0.5) --*last;
    return *first <= *last;
}

// Bands in which the kernel's width in columns stays within a factor of two, so that each groups
// its own way.
static status resample_bands(struct raster *raster, tile_id id, double shift,
                             struct resample_room *room, float *planes)
{
    const raster_grid *g = raster_get_grid(raster);
    int first, last;
    if (!covered_rows(g, id, &first, &last)) return OK;
    while (first <= last) {
        struct window w = {.shift = shift, .first = first, .last = first};
        double width = fmax(columns_in_row(g, id, first), GROUP_ABOVE);
        for (; w.last < last; w.last++) {
            double next = fmax(columns_in_row(g, id, w.last + 1), GROUP_ABOVE);
            if (next > 2 * width || width > 2 * next) break;
        }
        status s = resample_band(raster, id, &w, room, planes);
        if (s) return s;
        first = w.last + 1;
    }
    return OK;
}

status resample_tile(struct raster *raster, tile_id id, struct resample_room *room, float *planes)
{
    const raster_grid *g = raster_get_grid(raster);
    size_t count = (size_t)g->channels * TILE_SIZE * TILE_SIZE;
    for (size_t i = 0; i < count; i++) planes[i] = NAN;
    if (g->full_circle)
        return resample_touches(g, id) ? resample_bands(raster, id, 0, room, planes) : OK;
    double west, south, east, north;
    grid_bounds(id, &west, &south, &east, &north);
    // A wide tile may meet both ends of a raster that almost closes the circle.
    for (int turn = -1; turn <= 1; turn++) {
        double shift = 2 * M_PI * turn;
        if (west + shift >= g->east || east + shift <= g->west) continue;
        status s = resample_bands(raster, id, shift, room, planes);
        if (s) return s;
    }
    return OK;
}
