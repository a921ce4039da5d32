// Which part of each column of the sampling picture is sampled, and where its rows stand.
#include "geo/grid_rays.h"
#include "geo/screen_grid_parts.h"

// The farthest that a grid reaches out of the picture, in half pictures.
#define FARTHEST 1e7

// Where a column of the sampling picture is inside the cone of cotangent c about the axis: an arc
// about the column's nearest point to it.
static struct span in_cone(const struct setting *s, double x, double c)
{
    const struct eye *e = &s->sampling;
    dvec3 ahead = dvec3_mad(e->column[2], e->column[0], x), rise = e->column[1];
    double unit = dvec3_length(rise), lean = dvec3_dot(ahead, rise) / unit;
    dvec3 level = dvec3_mad(ahead, rise, -lean / unit);
    double length = dvec3_length(level);
    double down = -dvec3_dot(level, s->axis) / length, below_y = -dvec3_dot(rise, s->axis) / unit;
    double reach = hypot(down, below_y), share = c / hypot(1, c) / reach;
    if (share > 1) return (struct span){1, 0};
    double middle = atan2(below_y, down), half = acos(fmax(share, -1));
    const double edge = M_PI / 2 - 1e-9;
    struct span r = {fmax(middle - half, -edge), fmin(middle + half, edge)};
    if (span_empty(r)) {
        double turn = middle > 0 ? -2 * M_PI : 2 * M_PI;
        r = (struct span){fmax(middle - half + turn, -edge), fmin(middle + half + turn, edge)};
    }
    if (span_empty(r)) return r;
    return (struct span){(tan(r.low) * length - lean) / unit, (tan(r.high) * length - lean) / unit};
}

// The column's part of the viewing picture: a part of a line between planes. A column along a side
// of the picture counts as inside.
static struct span in_view(const struct setting *s, double x)
{
    const struct eye *e = &s->sampling;
    dvec3 ahead = dvec3_mad(e->column[2], e->column[0], x), rise = e->column[1];
    struct span r = {-1e9, 1e9};
    for (int i = 0; i < 4; i++) {
        double half = i / 2 ? s->half_y : s->half_x, sign = i % 2 ? -1 : 1;
        dvec3 plane = dvec3_mad(dvec3_scale(s->view.row[2], half), s->view.row[i / 2], sign);
        double at = dvec3_dot(plane, ahead), slope = dvec3_dot(plane, rise);
        if (fabs(slope) <= 1e-9 * half) {
            if (at < -1e-9 * half) return (struct span){1, 0};
        } else if (slope > 0) r.low = fmax(r.low, -at / slope);
        else r.high = fmin(r.high, -at / slope);
    }
    return r;
}

static struct span both(struct span a, struct span b)
{
    return (struct span){fmax(a.low, b.low), fmin(a.high, b.high)};
}

static struct span around(struct span a, struct span b)
{
    if (span_empty(a)) return b;
    if (span_empty(b)) return a;
    return (struct span){fmin(a.low, b.low), fmax(a.high, b.high)};
}

// What of a column must be sampled: all that straight lines to the columns at `left` and `right`
// need to keep the picture and the hull between them.
static struct span column_span(const struct setting *s, double x, double left, double right)
{
    struct span cone = in_cone(s, x, s->block->limb[1]), more;
    if (!grid_hull_between(&s->hull, left, right, &more.low, &more.high))
        more = (struct span){1, 0};
    more = around(more, in_view(s, x));
    if (left < right) {
        if (isfinite(left)) more = around(more, in_view(s, left));
        if (isfinite(right)) more = around(more, in_view(s, right));
    }
    double far = FARTHEST * s->half_y;
    return both(both(more, cone), (struct span){-far, far});
}

// The inverse of grid_unwarp, for `ahead` = 1.
static double warp(double y, double half, double denser)
{
    double v = fabs(y) / half;
    if (v > 1) return copysign(half + GRID_BEND * half * (1 - 1 / v), y);
    double low = 0, high = 1;
    for (int i = 0; i < HALVINGS && denser > 0; i++) {
        double m = 0.5 * (low + high);
        if (m * (1 - denser + denser * m * m) < v) low = m;
        else high = m;
    }
    return copysign(half * (denser > 0 ? 0.5 * (low + high) : v), y);
}

static double unwarp(double w, double half, double denser)
{
    double ahead, above;
    grid_unwarp(w, half, denser, &ahead, &above);
    return ahead > 0 ? above / ahead : copysign(INFINITY, w); // the axis, or past it
}

// The last x between a column that has something to sample and an end that may not.
static double find_end(const struct setting *s, double inside, double end, bool limb)
{
    for (int i = 0; i < HALVINGS; i++) {
        double x = i ? 0.5 * (inside + end) : end;
        struct span r = limb ? in_cone(s, x, s->block->limb[0]) : column_span(s, x, x, x);
        if (!span_empty(r)) inside = x;
        else end = x;
        if (!i && !span_empty(r)) return end;
    }
    return inside;
}

static void snap(double *w, double to, double half_step)
{
    if (fabs(*w - to) < half_step) *w = to;
}

static void set_column(const struct setting *s, double x, double left, double right,
                       struct grid_column *c)
{
    double half = s->half_y, denser = s->p->denser;
    struct span r = column_span(s, x, left, right), limb = in_cone(s, x, s->block->limb[0]);
    if (span_empty(r)) r.low = r.high = 0.5 * (r.low + r.high); // an end, by rounding
    dvec3 ahead = dvec3_mad(s->sampling.column[2], s->sampling.column[0], x);
    c->ahead[0] = ahead.x;
    c->ahead[1] = ahead.y;
    c->ahead[2] = ahead.z;
    c->low = warp(r.low, half, denser);
    c->high = warp(r.high, half, denser);
    bool crosses = !span_empty(limb);
    bool low = crosses && limb.low > r.low && limb.low < r.high;
    bool high = crosses && limb.high > r.low && limb.high < r.high;
    c->limb_low = low ? warp(limb.low, half, denser) : GRID_NOWHERE;
    c->limb_high = high ? warp(limb.high, half, denser) : GRID_NOWHERE;
    c->spare = 0;
}

// An x whose column has something to sample.
static bool find_inside(const struct setting *s, double *x)
{
    const struct grid_hull *h = &s->hull;
    double sum = 0;
    for (int i = 0; i < h->count; i++) sum += h->point[i][0];
    for (int i = -1; i < h->count; i++) {
        *x = i < 0 ? sum / h->count : h->point[i][0];
        if (h->count && !span_empty(column_span(s, *x, *x, *x))) return true;
    }
    return false;
}

// Columns at equal steps, the nearest moved to where the limb ends to the left and to the right.
bool grid_set_columns(const struct setting *s, struct grid_column *columns)
{
    const struct grid_hull *h = &s->hull;
    double inside, denser = s->p->denser;
    if (!find_inside(s, &inside)) return false;
    double left = fmin(h->point[0][0], -s->half_x),
           right = fmax(h->point[h->count - 1][0], s->half_x);
    double first = find_end(s, inside, left, false), last = find_end(s, inside, right, false);
    double limb_left = find_end(s, inside, first, true),
           limb_right = find_end(s, inside, last, true);
    double from = warp(first, s->half_x, denser), to = warp(last, s->half_x, denser);
    double step = (to - from) / (s->p->columns - 1);
    for (int i = 0; i < s->p->columns; i++) {
        double w = i == s->p->columns - 1 ? to : from + i * step;
        snap(&w, warp(limb_left, s->half_x, denser), 0.5 * step);
        snap(&w, warp(limb_right, s->half_x, denser), 0.5 * step);
        set_column(s, unwarp(w, s->half_x, denser), unwarp(w - 1.5 * step, s->half_x, denser),
                   unwarp(w + 1.5 * step, s->half_x, denser), &columns[i]);
    }
    return true;
}
