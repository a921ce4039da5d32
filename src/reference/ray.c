// Along a straight line the height g above the ellipsoid is convex, because an ellipsoid is, and
// its derivative is the line's component along the normal: tangents at both ends bound it from
// below. The longitude is monotonic. The latitude, whose level sets are cones, has one extremum at
// most, the one farthest from the equator. So the part of the map below a piece of the ray is
// known.
#include "reference/ray.h"

#include <math.h>

#include "reference/body.h"

#define RAD (M_PI / 180)

// Room for rounding: GeographicLib's conversion is good to nanometres at these distances.
#define HEIGHT_ROOM_M 1e-6
#define ANGLE_ROOM    1e-12 /* degrees */

enum { MAX_DEPTH = 80, ROOT_STEPS = 60 };

struct caster {
    struct field_reader *reader;
    geo_ellipsoid e;
    dvec3 origin, dir; // the origin moved up to the shell by `start` metres, where t = 0
    double pixel, start;
    field_patch patch;
    patch_bounds bounds; // of the patch
    bool has_patch;
};

// A point of the ray. lon goes on from the point before without a jump.
struct knot {
    double t, lat, lon, height, rho; // rho: distance from the axis
    double climb, north;             // the ray's components along normal and north
};

static struct knot knot_at(const struct caster *c, double t, const struct knot *before)
{
    dvec3 p = dvec3_mad(c->origin, c->dir, t);
    struct knot k = {.t = t, .rho = hypot(p.x, p.y)};
    body_locate(c->e, p, &k.lat, &k.lon, &k.height);
    body_frame f = body_frame_at(c->e, k.lat, k.lon, k.height);
    k.climb = dvec3_dot(c->dir, f.up);
    k.north = dvec3_dot(c->dir, f.north);
    if (before && !geo_is_plane(c->e)) k.lon = before->lon + remainder(k.lon - before->lon, 360);
    return k;
}

static double lowest_height(const struct knot *a, const struct knot *b)
{
    double low = fmin(a->height, b->height);
    if (a->climb < 0 && b->climb > 0) {
        double s = (b->height - b->climb * (b->t - a->t) - a->height) / (a->climb - b->climb);
        low = fmin(low, a->height + a->climb * s);
    }
    return low - HEIGHT_ROOM_M;
}

// Least radius of curvature of the surface at height `low`; the latitude changes no faster than one
// over it.
static double least_radius(const struct caster *c, double low)
{
    double r = c->e.b < c->e.a ? c->e.b * c->e.b / c->e.a : c->e.a * c->e.a / c->e.b;
    return fmax(r + low, 1);
}

static field_box box_below(const struct caster *c, const struct knot *a, const struct knot *b,
                           double low)
{
    double length = b->t - a->t;
    field_box box = {fmin(a->lat, b->lat), fmax(a->lat, b->lat), fmin(a->lon, b->lon),
                     fmax(a->lon, b->lon)};
    if ((a->north > 0) != (b->north > 0)) {
        double middle = 0.5 * (a->lat + b->lat), reach = 0.5 * length / least_radius(c, low) / RAD;
        box.south = fmax(-90, fmin(box.south, middle - reach));
        box.north = fmin(90, fmax(box.north, middle + reach));
    }
    box.south -= ANGLE_ROOM;
    box.north += ANGLE_ROOM;
    box.west -= ANGLE_ROOM;
    box.east += ANGLE_ROOM;
    return box;
}

// Does the patch hold the box, but for the room about it? A ray along a border of patches has no
// other: its own surface goes on beyond the border, and in that room parts from the next one's by
// less than HEIGHT_ROOM_M.
static bool holds(const struct caster *c, const field_box *box)
{
    const field_box *p = &c->patch.box;
    const field_box wide = {p->south - 2 * ANGLE_ROOM, p->north + 2 * ANGLE_ROOM,
                            p->west - 2 * ANGLE_ROOM, p->east + 2 * ANGLE_ROOM};
    return c->has_patch && field_box_holds(&wide, box);
}

// Does one patch hold the box? Then it is in c->patch.
static bool find_patch(struct caster *c, const field_box *box, const struct knot *a,
                       const struct knot *b)
{
    if (holds(c, box)) return true;
    double step = grid_step_lat(field_zoom(c->reader->field)) / RAD;
    if (box->north - box->south > step) return false;
    c->patch = field_patch_at(c->reader, 0.5 * (a->lat + b->lat), 0.5 * (a->lon + b->lon));
    c->bounds = patch_bound(&c->patch);
    c->has_patch = true;
    return holds(c, box);
}

// Bound of the second derivative of height above ground along a piece within the patch, 1/m.
// With r the least radius of curvature and rho the least distance from the axis, |lat'| <= 1/r,
// |lon'| <= 1/rho, |lon''| <= 2/rho^2, |lat''| <= (2 + m)/r^2 + 1/(r rho), where m bounds the
// relative change of the meridian's radius by latitude; 0 <= g'' <= 1/r. On a plane all three are
// linear.
static double curvature_bound(const struct caster *c, const struct knot *a, const struct knot *b,
                              double low)
{
    const patch_bounds *h = &c->bounds;
    double plane = c->e.a * RAD;
    if (geo_is_plane(c->e)) return (h->lat_lat + 2 * h->lat_lon + h->lon_lon) / (plane * plane);
    double ratio = c->e.a / c->e.b, q = fmax(ratio, 1 / ratio);
    double m = 1.5 * (q * q - 1) * q * q, r = least_radius(c, low);
    double rho = fmax(a->rho, b->rho) - (b->t - a->t);
    if (rho <= 0) return INFINITY;
    double lat2 = (2 + m) / (r * r) + 1 / (r * rho), lon2 = 2 / (rho * rho);
    double bent = h->lat_lat / (r * r) + 2 * h->lat_lon / (r * rho) + h->lon_lon / (rho * rho);
    return 1 / r + bent / (RAD * RAD) + (h->lat * lat2 + h->lon * lon2) / RAD;
}

static double ground_at(const struct caster *c, const struct knot *k)
{
    const field_box point = {k->lat, k->lat, k->lon, k->lon};
    if (holds(c, &point)) return patch_height(&c->patch, k->lat, k->lon);
    return field_height(c->reader, k->lat, k->lon);
}

static double above_ground(const struct caster *c, const struct knot *k)
{
    return k->height - ground_at(c, k);
}

static ray_hit hit_of(const struct caster *c, const struct knot *k, double ground)
{
    return (ray_hit){c->start + k->t, k->lat, remainder(k->lon, 360), ground};
}

// The root between a (above) and b (below), by the Illinois rule.
static ray_hit solve(const struct caster *c, struct knot a, struct knot b, double tolerance)
{
    double fa = above_ground(c, &a), fb = above_ground(c, &b);
    struct knot k = b;
    for (int i = 0, side = 0; i < ROOT_STEPS && b.t - a.t > tolerance && fb < 0; i++) {
        double t = a.t + (b.t - a.t) * fa / (fa - fb);
        if (!(t > a.t && t < b.t)) break;
        k = knot_at(c, t, &a);
        double f = above_ground(c, &k);
        if (fabs(f) <= 1e-2 * RAY_FLOOR_M) break;
        if (f > 0) {
            a = k;
            fa = f;
            fb *= side > 0 ? 0.5 : 1;
            side = 1;
        } else {
            b = k;
            fb = f;
            fa *= side < 0 ? 0.5 : 1;
            side = -1;
        }
    }
    return hit_of(c, &k, ground_at(c, &k));
}

enum verdict { PASSES, HITS, UNDECIDED };

// A piece within one patch, its beginning above the ground.
static enum verdict judge(const struct caster *c, const struct knot *a, const struct knot *b,
                          const field_box *box, double low)
{
    if (low > patch_max(&c->patch, &c->bounds, box) + HEIGHT_ROOM_M) return PASSES;
    double length = b->t - a->t, bend = curvature_bound(c, a, b, low);
    double fa = above_ground(c, a), fb = above_ground(c, b);
    if (fb <= 0) return fa - fb > bend * length * length ? HITS : UNDECIDED;
    // The chord less the parabola of this curvature.
    double s = bend > 0 ? 0.5 - (fb - fa) / (bend * length * length) : 0;
    s = clamp_double(s, 0, 1);
    double least = fa + (fb - fa) * s - 0.5 * bend * length * length * s * (1 - s);
    return least > HEIGHT_ROOM_M ? PASSES : UNDECIDED;
}

static double tolerance_at(const struct caster *c, double t)
{
    return fmax(RAY_FLOOR_M, RAY_TOLERANCE * c->pixel * (c->start + t));
}

// One piece: PASSES, HITS (and the hit), or UNDECIDED: halve it.
static enum verdict examine(struct caster *c, const struct knot *a, const struct knot *b,
                            ray_hit *hit)
{
    double low = lowest_height(a, b);
    field_box box = box_below(c, a, b, low);
    if (low > field_max(c->reader->field, &box)) return PASSES;
    double tolerance = tolerance_at(c, a->t);
    if (find_patch(c, &box, a, b)) {
        enum verdict v = judge(c, a, b, &box, low);
        if (v == HITS) *hit = solve(c, *a, *b, 1e-3 * tolerance);
        if (v != UNDECIDED) return v;
    }
    if (b->t - a->t > tolerance) return UNDECIDED;
    if (above_ground(c, b) > 0) return PASSES;
    *hit = solve(c, *a, *b, 1e-3 * tolerance);
    return HITS;
}

static bool search(struct caster *c, const struct knot *first, const struct knot *last,
                   ray_hit *hit)
{
    struct knot ends[MAX_DEPTH + 1], a = *first;
    int depth = 0;
    ends[0] = *last;
    while (depth >= 0 && !c->reader->error) {
        struct knot *b = &ends[depth];
        enum verdict v = examine(c, &a, b, hit);
        if (v == HITS) return true;
        if (v == PASSES || depth == MAX_DEPTH) {
            a = *b;
            depth--;
        } else {
            ends[depth + 1] = knot_at(c, 0.5 * (a.t + b->t), &a);
            depth++;
        }
    }
    return false;
}

// Where the ray runs between two heights over a plane's map. One that comes in from the side below
// the ground sees the planet from within: false.
static bool clip_plane(const struct caster *c, double from, double to, double *t0, double *t1)
{
    double low, high, enter = 0, leave = INFINITY;
    if (!body_over_map(c->e, c->origin, c->dir, &enter, &leave)) return false;
    field_range(c->reader->field, &low, &high);
    if (enter > 0) {
        struct knot k = knot_at(c, enter, NULL);
        if (k.height < field_height(c->reader, k.lat, k.lon)) return false;
    }
    double down = (low - HEIGHT_ROOM_M - c->origin.x) / c->dir.x,
           up = (high + HEIGHT_ROOM_M - c->origin.x) / c->dir.x;
    if (c->dir.x == 0) down = c->origin.x > high ? -INFINITY : INFINITY, up = -down;
    *t0 = fmax(fmax(from, enter), fmin(down, up));
    *t1 = fmin(fmin(to, leave), fmax(down, up));
    return *t1 > *t0;
}

// Where the ray runs in the shell that holds all ground, from the scaled space in which the
// ellipsoid is the unit sphere: ground at height h lies there between 1 + min(h, 0) / small and 1 +
// max(h, 0) / small. False: never.
static bool clip(const struct caster *c, double from, double to, double *t0, double *t1)
{
    if (geo_is_plane(c->e)) return clip_plane(c, from, to, t0, t1);
    double low, high, small = fmin(c->e.a, c->e.b);
    field_range(c->reader->field, &low, &high);
    dvec3 o = {c->origin.x / c->e.a, c->origin.y / c->e.a, c->origin.z / c->e.b};
    dvec3 d = {c->dir.x / c->e.a, c->dir.y / c->e.a, c->dir.z / c->e.b};
    double speed = dvec3_length(d);
    d = dvec3_scale(d, 1 / speed);
    double near = -dvec3_dot(o, d);
    dvec3 q = dvec3_mad(o, d, near);
    double room = 1e-9 + 1e-14 * fabs(near), qq = dvec3_dot(q, q);
    double outer = 1 + fmax(high, 0) / small + room, inner = 1 + fmin(low, 0) / small - room;
    if (qq >= outer * outer) return false;
    double half = sqrt(outer * outer - qq);
    *t0 = fmax(from, (near - half) / speed);
    *t1 = fmin(to, (near + half) / speed);
    double deep = near - sqrt(fmax(0, inner * inner - qq));
    if (qq < inner * inner && deep / speed > *t0) *t1 = fmin(*t1, deep / speed);
    return *t1 > *t0;
}

bool ray_cast_between(struct field_reader *reader, dvec3 origin, dvec3 dir, double pixel,
                      double from, double to, ray_hit *hit)
{
    struct caster c = {.reader = reader,
                       .e = field_ellipsoid(reader->field),
                       .origin = origin,
                       .dir = dir,
                       .pixel = pixel};
    double t0, t1;
    if (!clip(&c, from, to, &t0, &t1)) return false;
    c.start = t0;
    c.origin = dvec3_mad(origin, dir, t0);
    struct knot a = knot_at(&c, 0, NULL);
    if (t0 <= from) {
        double ground = field_height(reader, a.lat, a.lon);
        if (a.height <= ground) {
            *hit = hit_of(&c, &a, ground);
            return true;
        }
    }
    struct knot b = knot_at(&c, t1 - t0, &a);
    return search(&c, &a, &b, hit);
}

bool ray_cast(struct field_reader *reader, dvec3 origin, dvec3 dir, double pixel, ray_hit *hit)
{
    return ray_cast_between(reader, origin, dir, pixel, 0, INFINITY, hit);
}
