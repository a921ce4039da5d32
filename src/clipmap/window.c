// Invariant: everything is computed from the arguments in double precision and whole samples; a
// longitude is reduced to one turn before it is snapped, so that the two sides of the antimeridian
// have the same windows.
#include "clipmap/window.h"

#include <assert.h>
#include <math.h>
#include <stddef.h>

#include "base/vec.h"
#include "planet/region.h"

static int margin(const window_shape *shape)
{
    return (shape->rows - shape->diameter_rows) / 2;
}

static int zoom_of_level(const window_shape *shape, int level)
{
    int zoom = level > 1 ? level - 1 : 0;
    for (int d = shape->diameter_rows; d > 256; d >>= 1) zoom++;
    return zoom;
}

static int64_t map_rows(int zoom)
{
    return (int64_t)256 << zoom;
}

static int64_t circle_columns(const window_shape *shape, int share)
{
    return (int64_t)shape->cols << share;
}

// Half of the longitude span of the ring of a level: asin(sin t / cos b), b the reduced latitude;
// pi when it holds a pole.
static double ring_half_span(int level, double lat, double ring_bound)
{
    double t = ldexp(M_PI, -level);
    double across = ring_bound * cos(lat), up = fabs(sin(lat));
    double colatitude = atan2(across, up);
    if (level < 2 || t >= colatitude) return M_PI;
    return asin(fmin(1.0, sin(t) / sin(colatitude)));
}

// Rows cost their memory; columns half their fineness where they do not suffice.
static int column_margin(const window_shape *shape)
{
    int most = shape->diameter_rows / 16, of_rows = margin(shape);
    return of_rows < most ? of_rows : most;
}

// What of a window of share k the ring and the margin on both sides take.
static double filled(const window_shape *shape, int share, double half_span)
{
    double half_turn = (double)shape->cols / 2.0 / M_PI; // columns a radian of longitude, share 0
    return ldexp(half_span * half_turn, share) / (shape->cols / 2 - column_margin(shape));
}

// The narrowest share 2^-k of the circle that holds the ring and the margin on both sides.
static int share_of_ring(const window_shape *shape, int zoom, double half_span)
{
    for (int k = zoom; k > 0; k--)
        if (filled(shape, k, half_span) <= 1) return k;
    return 0;
}

static int64_t first_row(const window_shape *shape, int zoom, double lat)
{
    double step = M_PI / (double)map_rows(zoom);
    int64_t row = (int64_t)floor((M_PI / 2 - lat) / step + 0.5) - shape->rows / 2;
    int64_t last = map_rows(zoom) + margin(shape) - shape->rows;
    if (row > last) row = last;
    return row < -margin(shape) ? -margin(shape) : row;
}

static int64_t first_column(const window_shape *shape, int share, double lon)
{
    if (share == 0) return 0;
    int64_t circle = circle_columns(shape, share);
    double turns = (lon + M_PI) / (2 * M_PI);
    int64_t middle = (int64_t)floor((turns - floor(turns)) * (double)circle + 0.5);
    return middle % circle - shape->cols / 2;
}

window window_at(const window_shape *shape, int level, double lat, double lon, double ring_bound)
{
    assert(level >= 0 && isfinite(lat) && isfinite(lon) && ring_bound > 0);
    window w = {.level = level, .zoom = zoom_of_level(shape, level)};
    w.share = share_of_ring(shape, w.zoom, ring_half_span(level, lat, ring_bound));
    w.rect.row0 = first_row(shape, w.zoom, lat);
    w.rect.row1 = w.rect.row0 + shape->rows;
    w.rect.col0 = first_column(shape, w.share, lon);
    w.rect.col1 = w.rect.col0 + shape->cols;
    return w;
}

double window_widening(const window_shape *shape, const window *w, double lat, double ring_bound)
{
    const double from = 0.75; // of a window, in whose last quarter the columns widen
    if (w->share == 0) return 0;
    double part = filled(shape, w->share, ring_half_span(w->level, lat, ring_bound));
    return clamp_double((part - from) / (1 - from), 0, 1);
}

double window_step_lat(const window *w)
{
    return M_PI / (double)map_rows(w->zoom);
}

double window_step_lon(const window_shape *shape, const window *w)
{
    return 2 * M_PI / (double)circle_columns(shape, w->share);
}

void window_coordinates(const window_shape *shape, const window *w, double lat, double lon,
                        double *row, double *col)
{
    double circle = (double)circle_columns(shape, w->share);
    double middle = 0.5 * (double)(w->rect.col0 + w->rect.col1);
    double c = (lon + M_PI) / (2 * M_PI) * circle;
    *row = (M_PI / 2 - lat) / window_step_lat(w);
    *col = c - circle * floor((c - middle) / circle + 0.5);
}

int window_texel(int64_t sample, int size)
{
    int64_t m = sample % size;
    return (int)(m < 0 ? m + size : m);
}

bool window_rect_empty(window_rect r)
{
    return r.row0 >= r.row1 || r.col0 >= r.col1;
}

bool window_rect_equal(window_rect a, window_rect b)
{
    return a.row0 == b.row0 && a.row1 == b.row1 && a.col0 == b.col0 && a.col1 == b.col1;
}

window_rect window_rect_intersect(window_rect a, window_rect b)
{
    return (window_rect){
        .row0 = a.row0 > b.row0 ? a.row0 : b.row0,
        .row1 = a.row1 < b.row1 ? a.row1 : b.row1,
        .col0 = a.col0 > b.col0 ? a.col0 : b.col0,
        .col1 = a.col1 < b.col1 ? a.col1 : b.col1,
    };
}

window_rect window_rect_turned(const window_shape *shape, int share, window_rect rect,
                               window_rect near)
{
    int64_t circle = circle_columns(shape, share);
    int64_t off = (near.col0 + near.col1 - rect.col0 - rect.col1) / 2;
    int64_t up = off + circle / 2;
    int64_t turns = up >= 0 ? up / circle : -((-up + circle - 1) / circle);
    rect.col0 += turns * circle;
    rect.col1 += turns * circle;
    return rect;
}

static int64_t half(int64_t a)
{
    return a / 2 - (a % 2 < 0);
}

window_rect window_rect_recast(const window_shape *shape, int from, window_rect rect,
                               const window *to)
{
    assert(to->share == from - 1 || to->share == from + 1);
    window_rect r = rect;
    if (to->share < from) {
        r.col0 = half(rect.col0 + 1);
        r.col1 = half(rect.col1);
    } else if (rect.col1 - rect.col0 == circle_columns(shape, from)) {
        r.col0 = to->rect.col0;
        r.col1 = to->rect.col1;
    } else {
        r.col0 = 2 * rect.col0 + 3;
        r.col1 = 2 * rect.col1 - 3;
    }
    return window_rect_intersect(window_rect_turned(shape, to->share, r, to->rect), to->rect);
}

window_rect window_rect_parents(window_rect r)
{
    return (window_rect){region_first_tap(r.row0), region_first_tap(r.row1 - 1) + 4,
                         region_first_tap(r.col0), region_first_tap(r.col1 - 1) + 4};
}

int window_rect_missing(window_rect target, window_rect held, window_rect out[4])
{
    if (window_rect_empty(target)) return 0;
    if (window_rect_empty(held)) return out[0] = target, 1;
    const window_rect parts[4] = {
        {held.row0, held.row1, target.col0, held.col0},
        {held.row0, held.row1, held.col1, target.col1},
        {target.row0, held.row0, target.col0, target.col1},
        {held.row1, target.row1, target.col0, target.col1},
    };
    int count = 0;
    for (int i = 0; i < 4; i++)
        if (!window_rect_empty(parts[i])) out[count++] = parts[i];
    return count;
}
