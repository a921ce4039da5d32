// Two frames: the metric axes of a camera, in which a picture is a rectangle, and the space where
// the ellipsoid is the unit sphere, in which the limb is a circular cone. Both are linear images of
// each other, so that a line through the camera is one in both.
#include "geo/screen_grid.h"

#include "geo/grid_hull.h"
#include "geo/grid_rays.h"

enum { EDGE_STEPS = 16, RING_STEPS = 64, HALVINGS = 48 };

// A little more than the picture, for its jitter and the straight lines between vertices.
#define GROWN 1.005

// The farthest that a grid reaches out of the picture, in half pictures.
#define FARTHEST 1e7

// A camera in the space of the unit sphere: a direction's x, y and depth by rows, and the direction
// of x, y and depth 1 by columns.
struct eye {
    dvec3 row[3], column[3];
};

struct setting {
    const grid_params *p;
    struct grid_block *block;
    struct eye view, sampling;
    double half_x, half_y; // of the picture
    dvec3 foot, up, axis;
    struct grid_hull hull; // in the sampling picture: what must be covered besides the picture
};

static void set_vec(double out[4], dvec3 v, double w)
{
    out[0] = v.x;
    out[1] = v.y;
    out[2] = v.z;
    out[3] = w;
}

// To u, e, n about the focus from its meridian frame.
static dvec3 about_focus(const struct geo_focus *f, dvec3 v)
{
    return (dvec3){f->cb * v.x + f->sb * v.z, v.y, f->cb * v.z - f->sb * v.x};
}

// A direction given in ECEF metres; its length counts in semi-axes.
static dvec3 to_scaled(const struct geo_focus *f, dvec3 ecef)
{
    dvec3 m = dmat3_mul(f->meridian_from_ecef, ecef);
    return about_focus(f,
                       (dvec3){m.x / f->ellipsoid.a, m.y / f->ellipsoid.a, m.z / f->ellipsoid.b});
}

// For a scaled direction v of an ECEF direction d: dot(covector(c), v) = dot(c, d) / A.
static dvec3 covector(const struct geo_focus *f, dvec3 ecef)
{
    dvec3 m = dmat3_mul(f->meridian_from_ecef, ecef);
    return about_focus(f, (dvec3){m.x, m.y, m.z / f->r});
}

static struct eye eye_of(const grid_params *p, const geo_camera *camera)
{
    dmat3 eye = geo_eye_from_ecef(camera);
    const dvec3 axes[3] = {eye.row[0], eye.row[1], dvec3_scale(eye.row[2], -1)};
    struct eye e;
    for (int i = 0; i < 3; i++) {
        e.row[i] = covector(p->focus, axes[i]);
        e.column[i] = dvec3_scale(to_scaled(p->focus, axes[i]), p->ellipsoid.a);
    }
    return e;
}

static dvec3 direction_at(const struct eye *e, double x, double y)
{
    return dvec3_mad(dvec3_mad(e->column[2], e->column[0], x), e->column[1], y);
}

double grid_lowest_m(const grid_params *p)
{
    double low = p->discs[0].low;
    for (int i = 1; i < p->disc_count; i++) low = fmax(low, p->discs[i].low);
    return low;
}

// The camera lowered by g metres, in the scaled space.
static dvec3 lowered(const struct setting *s, double g)
{
    double k = (s->p->camera.position.height - g) * s->block->up[3];
    return dvec3_mad(s->foot, s->up, k);
}

static double limb_angle(dvec3 from)
{
    double d = dvec3_length(from);
    return d > 1 ? acos(1 / d) : 0;
}

// Cotangent of the angle from the vertical at which a place `angle` away is seen by a camera at a
// scaled height k.
static double cotangent_to(double k, double angle)
{
    double h = sin(angle / 2);
    return (k + 2 * h * h) / sin(angle);
}

// The highest base at an angle that is seen at a cotangent or a greater one.
static double highest_seen(const struct setting *s, double angle, double cotangent)
{
    double h = sin(angle / 2), k = cotangent * sin(angle) - 2 * h * h;
    return s->p->camera.position.height - k / s->block->up[3];
}

// Each disc's radius halves, and the angle at which it is seen must fall by this at least: where
// the ground drops steeply, the base follows in several steps.
#define STEEPER 1.4

// The widest disc of which ground can be seen on this side of the limb.
static int farthest_disc(const struct setting *s)
{
    const grid_params *p = s->p;
    int far = p->disc_count - 1;
    while (far > 0 && limb_angle(lowered(s, p->discs[far].low)) > p->discs[far].radius) far--;
    return far;
}

// The inner discs' lowest ground where only they can be met. A knot at a disc's radius has at most
// the height that bounds the next wider disc.
static void add_knots(struct setting *s, int far, double limb)
{
    const grid_params *p = s->p;
    struct grid_block *b = s->block;
    double low = b->base[0][1];
    int knots = 1;
    for (int i = far + 1; i <= p->disc_count; i++) {
        bool inmost = i == p->disc_count;
        double radius = inmost ? p->discs[i - 1].radius / 2 : p->discs[i].radius;
        if (radius >= limb) continue;
        double least = STEEPER * b->base[knots - 1][0];
        double g = fmin(p->discs[i - 1].low, highest_seen(s, radius, least));
        if (g < low) continue;
        low = g;
        b->base[knots][0] = cotangent_to(dvec3_length(lowered(s, g)) - 1, radius);
        b->base[knots][1] = g;
        knots++;
    }
    b->base[0][2] = knots;
}

// The base: a narrow picture's ground, or, from the limb inwards, the lowest ground that can be
// met.
static bool set_base(struct setting *s)
{
    const grid_params *p = s->p;
    struct grid_block *b = s->block;
    bool narrow = !isnan(p->ground_m);
    int far = farthest_disc(s);
    double low = narrow ? p->ground_m : p->discs[far].low;
    dvec3 c = lowered(s, low);
    double k = dvec3_length(c) - 1;
    if (!(k > 0)) return false;
    s->axis = dvec3_normalize(c);
    set_vec(b->axis, s->axis, p->camera.position.height);
    b->limb[0] = sqrt(k * (2 + k));
    b->base[0][0] = b->limb[0];
    b->base[0][1] = low;
    b->base[0][2] = 1;
    if (!narrow) add_knots(s, far, limb_angle(c));
    return true;
}

// The least that the picture gives to what lies behind the limb, in half pictures.
#define RING 0.02

// How far behind the base's limb ground can show, as the discs' heights allow, and how high it can
// stand there in the picture.
static void set_limb(struct setting *s)
{
    const grid_params *p = s->p;
    struct grid_block *b = s->block;
    double scale = b->up[3], base = b->base[0][1], d = hypot(1, b->limb[0]);
    double low = fmin(base, p->discs[farthest_disc(s)].low);
    double limb = atan(b->limb[0]), lowest_limb = limb_angle(lowered(s, low));
    double end = limb, top = b->limb[0];
    for (int i = 0; i < p->disc_count; i++) {
        double inner = i + 1 < p->disc_count ? p->discs[i + 1].radius : 0;
        double rise = fmax(0, p->discs[i].high - low) * scale;
        double reach = fmin(p->discs[i].radius, lowest_limb + acos(1 / (1 + rise)));
        double from = fmax(inner, limb), size = 1 + (p->discs[i].high - base) * scale;
        if (reach <= from + 1e-9) continue; // by rounding
        end = fmax(end, reach);
        for (int k = 0; k <= 8; k++) {
            double angle = from + (reach - from) * k / 8;
            top = fmin(top, (d - size * cos(angle)) / (size * sin(angle)));
        }
    }
    b->limb[1] = fmin(top, b->limb[0] - RING * s->half_y);
    b->limb[2] = fmin(tan(fmin(end - limb, 1.5)), 1e3);
    if (!(b->limb[2] > 0)) b->limb[1] = b->limb[0];
}

struct span {
    double low, high;
};

static bool span_empty(struct span s)
{
    return !(s.low <= s.high);
}

static double angle_between(dvec3 a, dvec3 b)
{
    return 2 * asin(fmin(1, dvec3_length(dvec3_sub(a, b)) / 2));
}

// Between which angles from the foot a ray is no higher than h metres.
static struct span below(const struct setting *s, dvec3 dir, double h)
{
    dvec3 c = lowered(s, h);
    double k = (s->p->camera.position.height - h) * s->block->up[3];
    double kk = k * (2 * s->block->foot[3] + k), dd = dvec3_dot(dir, dir);
    double b = -dvec3_dot(c, dir), root = b * b - dd * kk;
    if (!(root >= 0) || (k > 0 && b <= 0)) return (struct span){1, 0};
    double first = k > 0 ? kk / (b + sqrt(root)) : 0, last = (b + sqrt(root)) / dd;
    return (struct span){k > 0 ? angle_between(dvec3_mad(c, dir, first), s->foot) : 0,
                         angle_between(dvec3_mad(c, dir, last), s->foot)};
}

// The place at an angle from the foot over which a ray passes: on the plane of the ray and the
// vertical, which on an ellipsoid misses the centre.
static dvec3 place_under(const struct setting *s, dvec3 dir, double angle)
{
    dvec3 normal = dvec3_cross(s->up, dir);
    double length = dvec3_length(normal);
    if (length <= 1e-14 * dvec3_length(dir)) normal = (dvec3){0, 0, length = 1}; // straight down
    normal = dvec3_scale(normal, 1 / length);
    dvec3 middle = dvec3_scale(normal, dvec3_dot(normal, s->foot));
    dvec3 out = dvec3_sub(s->foot, middle), along = dvec3_cross(normal, out);
    double radius = dvec3_length(out), turn = 2 * asin(fmin(1, sin(angle / 2) / radius));
    if (dvec3_dot(along, dir) < 0) turn = -turn;
    return dvec3_mad(dvec3_mad(middle, out, cos(turn)), along, sin(turn));
}

static double cotangent_of(const struct setting *s, dvec3 dir)
{
    double down = -dvec3_dot(dir, s->axis);
    return down / dvec3_length(dvec3_mad(dir, s->axis, down));
}

static struct span in_disc(const struct setting *s, int i, struct span r)
{
    const grid_params *p = s->p;
    r.low = fmax(r.low, i + 1 < p->disc_count ? p->discs[i + 1].radius : 0);
    r.high = fmin(r.high, p->discs[i].radius);
    return r;
}

// Between which angles from the foot ground can be met by a ray.
static struct span ground_on(const struct setting *s, dvec3 dir)
{
    const grid_params *p = s->p;
    struct span met = {INFINITY, -INFINITY};
    double end = INFINITY;
    for (int i = 0; i < p->disc_count; i++) {
        struct span r = in_disc(s, i, below(s, dir, p->discs[i].low));
        if (!span_empty(r)) end = fmin(end, r.low);
    }
    if (isfinite(end)) met = (struct span){end, end};
    for (int i = 0; i < p->disc_count; i++) {
        struct span r = in_disc(s, i, below(s, dir, p->discs[i].high));
        r.high = fmin(r.high, end);
        if (span_empty(r)) continue;
        met.low = fmin(met.low, r.low);
        met.high = fmax(met.high, r.high);
    }
    return met;
}

// Direction of the ray under which a place on the unit sphere stands: the inverse of grid_foot.
static dvec3 direction_to(const struct setting *s, dvec3 place)
{
    const struct grid_block *b = s->block;
    double out = dvec3_dot(place, s->axis);
    if (out * hypot(1, b->limb[0]) < 1) { // behind the limb
        double past = tan(fmin(acos(clamp_double(out, -1, 1)) - atan(b->limb[0]), 1.5));
        double q = b->limb[2] > 0 ? fmin(past / b->limb[2], 1) : 0;
        dvec3 side = dvec3_normalize(dvec3_mad(place, s->axis, -out));
        return dvec3_mad(side, s->axis, -(b->limb[0] + q * (b->limb[1] - b->limb[0])));
    }
    int last = (int)b->base[0][2] - 1;
    double low = b->base[0][1], high = b->base[last][1];
    for (int i = 0; i < HALVINGS && high > low; i++) {
        double g = 0.5 * (low + high);
        dvec3 d = dvec3_sub(place, lowered(s, g));
        double down = -dvec3_dot(d, s->axis);
        double side = dvec3_length(dvec3_mad(d, s->axis, down));
        if (grid_base(b, down, side) > g) low = g;
        else high = g;
    }
    return dvec3_sub(place, lowered(s, 0.5 * (low + high)));
}

struct spot {
    double x, y;
};

static struct spot spot_of(const struct setting *s, dvec3 dir)
{
    const struct eye *e = &s->sampling;
    double x = dvec3_dot(e->row[0], dir), y = dvec3_dot(e->row[1], dir);
    double ahead = fmax(dvec3_dot(e->row[2], dir), 1e-4 * hypot(x, y));
    return (struct spot){x / ahead, y / ahead};
}

static void cover_direction(struct setting *s, dvec3 dir)
{
    struct spot at = spot_of(s, dir);
    if (isfinite(at.x) && isfinite(at.y)) grid_hull_add(&s->hull, at.x, at.y);
}

// The way between two directions and somewhat more: the samples of the edge are few, and verticals
// are not quite parallel.
static void cover_way(struct setting *s, dvec3 from, dvec3 to)
{
    struct spot a = spot_of(s, from), b = spot_of(s, to);
    double x = b.x - a.x, y = b.y - a.y;
    if (!isfinite(x) || !isfinite(y)) return;
    grid_hull_add(&s->hull, a.x - 0.03 * x, a.y - 0.03 * y);
    for (int side = -1; side <= 1; side += 2)
        grid_hull_add(&s->hull, b.x + 0.03 * x + side * 0.01 * y, b.y + 0.03 * y - side * 0.01 * x);
}

// Feet of all ground that a ray can meet, and what lies between them and the picture.
static void cover_ray(struct setting *s, dvec3 dir)
{
    struct span met = ground_on(s, dir);
    if (span_empty(met)) return;
    dvec3 near = direction_to(s, place_under(s, dir, met.low)),
          far = direction_to(s, place_under(s, dir, met.high));
    bool own = cotangent_of(s, dir) >= s->block->limb[1];
    cover_way(s, own ? dir : far, near);
    cover_way(s, own ? dir : near, far);
}

static bool in_picture(const struct setting *s, dvec3 dir)
{
    const struct eye *e = &s->view;
    double ahead = dvec3_dot(e->row[2], dir);
    return ahead > 0 && fabs(dvec3_dot(e->row[0], dir)) <= s->half_x * ahead &&
           fabs(dvec3_dot(e->row[1], dir)) <= s->half_y * ahead;
}

// The picture's edge, evenly in angle, and the planet's.
static void find_hull(struct setting *s)
{
    for (int i = 0; i < 4 * (EDGE_STEPS + 1); i++) { // each edge with both its corners
        int edge = i / (EDGE_STEPS + 1);
        double along = 2.0 * (i % (EDGE_STEPS + 1)) / EDGE_STEPS - 1, x = s->half_x, y = s->half_y;
        if (edge % 2) x = tan(along * atan(x));
        else y = tan(along * atan(y));
        double sign = edge < 2 ? 1 : -1;
        cover_ray(s, direction_at(&s->view, sign * x, sign * y));
    }
    dvec3 a = fabs(s->axis.x) < 0.6 ? (dvec3){1, 0, 0} : (dvec3){0, 1, 0};
    dvec3 x = dvec3_normalize(dvec3_cross(a, s->axis)), y = dvec3_cross(s->axis, x);
    for (int i = 0; i < RING_STEPS; i++) {
        double turn = 2 * M_PI * i / RING_STEPS;
        dvec3 side = dvec3_mad(dvec3_scale(x, cos(turn)), y, sin(turn));
        dvec3 dir = dvec3_mad(side, s->axis, -s->block->limb[1]);
        if (in_picture(s, dir)) cover_direction(s, dir);
    }
    if (in_picture(s, dvec3_scale(s->axis, -1))) cover_direction(s, dvec3_scale(s->axis, -1));
    grid_hull_close(&s->hull);
}

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
static bool set_columns(const struct setting *s, struct grid_column *columns)
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

// By how much, as an angle, ground may stand beside the vertical plane of the ray that meets it:
// over a place s metres away verticals lean sideways by up to e2 s / (4 A), times their height.
static double aside(const grid_params *p)
{
    double ratio = p->ellipsoid.b / p->ellipsoid.a;
    double height = fmax(fabs(p->discs[0].low), fabs(p->discs[0].high));
    return fabs(1 - ratio * ratio) * height / (2 * p->ellipsoid.a);
}

bool grid_make(const grid_params *p, struct grid_block *block, struct grid_column *columns)
{
    geo_ellipsoid e = p->ellipsoid;
    geodetic under = {p->camera.position.lat, p->camera.position.lon, 0};
    struct setting s = {.p = p, .block = block};
    *block = (struct grid_block){.foot = {0}};
    dvec3 up = to_scaled(p->focus, geo_normal(under.lat, under.lon));
    s.foot = dvec3_normalize(to_scaled(p->focus, geo_ecef_from_geodetic(e, under)));
    s.up = dvec3_normalize(up);
    set_vec(block->foot, s.foot, dvec3_dot(s.foot, s.up));
    set_vec(block->up, s.up, dvec3_length(up));
    s.half_y = GROWN * tan(p->camera.fov_y / 2);
    s.half_x = s.half_y * p->aspect + aside(p);
    s.half_y += aside(p);
    if (!(p->camera.position.height > grid_lowest_m(p)) || !set_base(&s)) return false;
    set_limb(&s);
    geo_camera sampling = p->camera;
    sampling.pitch = fmin(sampling.pitch, 0);
    s.view = eye_of(p, &p->camera);
    s.sampling = eye_of(p, &sampling);
    set_vec(block->row_axis, s.sampling.column[1], s.half_y);
    block->limb[3] = p->denser;
    find_hull(&s);
    return set_columns(&s, columns);
}

void grid_ray(const grid_params *p, const struct grid_block *block, const struct grid_column *c,
              int row, double direction[3], double place[3])
{
    double w = grid_row(c->low, c->high, c->limb_low, c->limb_high, row, p->rows), ahead, above;
    grid_unwarp(w, block->row_axis[3], block->limb[3], &ahead, &above);
    for (int i = 0; i < 3; i++) direction[i] = ahead * c->ahead[i] + above * block->row_axis[i];
    grid_direction at = grid_foot(block, direction[0], direction[1], direction[2]);
    place[0] = at.u;
    place[1] = at.e;
    place[2] = at.n;
}
