// Two frames: the metric axes of a camera, in which a picture is a rectangle, and the space where
// the ellipsoid is the unit sphere, in which the limb is a circular cone. Both are linear images of
// each other, so that a line through the camera is one in both.
#include "geo/screen_grid.h"

#include "geo/grid_rays.h"
#include "geo/horizon.h"
#include "geo/screen_grid_parts.h"

enum { EDGE_STEPS = 16, RING_STEPS = 64 };

// A little more than the picture, for its jitter and the straight lines between vertices.
#define GROWN 1.005

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
    dmat3 eye = geo_eye_over(p->ellipsoid, camera);
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

static double limb_angle(const struct setting *s, dvec3 from)
{
    if (s->plane) return INFINITY;
    double d = dvec3_length(from);
    return d > 1 ? acos(1 / d) : 0;
}

// Cotangent of the angle from the vertical at which a place `angle` away is seen by a camera at a
// scaled height k.
static double cotangent_to(const struct setting *s, double k, double angle)
{
    if (s->plane) return k / angle;
    double h = sin(angle / 2);
    return (k + 2 * h * h) / sin(angle);
}

// The highest base at an angle that is seen at a cotangent or a greater one.
static double highest_seen(const struct setting *s, double angle, double cotangent)
{
    double h = sin(angle / 2), k = cotangent * sin(angle) - 2 * h * h;
    if (s->plane) k = cotangent * angle;
    return s->p->camera.position.height - k / s->block->up[3];
}

// Scaled height of the camera over a sphere, or the plane, at height g.
static double height_over(const struct setting *s, double g)
{
    return s->plane ? lowered(s, g).x : dvec3_length(lowered(s, g)) - 1;
}

// Each disc's radius halves, and the angle at which it is seen must fall by this at least: where
// the ground drops steeply, the base follows in several steps.
#define STEEPER 1.4

// The widest disc of which ground can be seen on this side of the limb.
static int farthest_disc(const struct setting *s)
{
    const grid_params *p = s->p;
    int far = p->disc_count - 1;
    while (far > 0 && limb_angle(s, lowered(s, p->discs[far].low)) > p->discs[far].radius) far--;
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
        b->base[knots][0] = cotangent_to(s, height_over(s, g), radius);
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
    double k = height_over(s, low);
    if (!(k > 0)) return false;
    s->axis = s->plane ? s->up : dvec3_normalize(c);
    set_vec(b->axis, s->axis, p->camera.position.height);
    b->limb[0] = s->plane ? k / s->corner : sqrt(k * (2 + k));
    b->base[0][0] = b->limb[0];
    b->base[0][1] = low;
    b->base[0][2] = 1;
    b->base[0][3] = !s->plane;
    if (!narrow) add_knots(s, far, limb_angle(s, c));
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
    b->limb[1] = b->limb[0];
    if (s->plane) return;
    double scale = b->up[3], base = b->base[0][1], d = hypot(1, b->limb[0]);
    double low = fmin(base, p->discs[farthest_disc(s)].low);
    double limb = atan(b->limb[0]), lowest_limb = limb_angle(s, lowered(s, low));
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

static double angle_between(dvec3 a, dvec3 b)
{
    return 2 * asin(fmin(1, dvec3_length(dvec3_sub(a, b)) / 2));
}

// The same on a plane, where angles are distances.
static struct span below_on_plane(const struct setting *s, dvec3 dir, double h)
{
    double k = height_over(s, h), at = k * hypot(dir.y, dir.z) / -dir.x;
    if (k > 0) return dir.x < 0 ? (struct span){at, s->corner} : (struct span){1, 0};
    return (struct span){0, dir.x > 0 ? fmin(at, s->corner) : s->corner};
}

// Between which angles from the foot a ray is no higher than h metres.
static struct span below(const struct setting *s, dvec3 dir, double h)
{
    if (s->plane) return below_on_plane(s, dir, h);
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
    if (s->plane) {
        double side = hypot(dir.y, dir.z);
        return side > 0 ? dvec3_mad(s->foot, (dvec3){0, dir.y, dir.z}, angle / side) : s->foot;
    }
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
    if (!s->plane && out * hypot(1, b->limb[0]) < 1) { // behind the limb
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
    struct setting s = {.p = p, .block = block, .plane = geo_is_plane(e)};
    *block = (struct grid_block){.foot = {0}};
    dvec3 up = to_scaled(p->focus, geo_up_at(e, under.lat, under.lon));
    s.foot = dvec3_normalize(to_scaled(p->focus, geo_ecef_from_geodetic(e, under)));
    if (s.plane) {
        s.foot = (dvec3){0, under.lon - p->focus->lon, under.lat - p->focus->lat};
        s.corner = geo_horizon_angle(e, geo_ecef_from_geodetic(e, under), 0, 0);
    }
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
    return grid_set_columns(&s, columns);
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
