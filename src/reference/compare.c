#include "reference/compare.h"

#include <math.h>
#include <stdlib.h>

#include "base/log.h"
#include "reference/compare_edges.h"
#include "reference/compare_stat.h"

enum measure { GEOMETRIC, DISTANCE, DEPTH, RELATIVE, GEOMETRIC_ALL, LIMB, RIDGE, MEASURES };

struct trial {
    const compare_params *params;
    const compare_maps *maps;
    compare_result *result;
    dvec3 right, up, forward;
    depth_picture a, b;
    edge_picture edges_a, edges_b;
    unsigned char *mask; // 1: silhouette
    struct stat_sum sums[MEASURES];
    double squares; // of colour
};

static void aim(struct trial *t)
{
    const compare_params *p = t->params;
    double x = 0.5 * p->width, y = 0.5 * p->height;
    dvec3 origin, beside, above;
    reference_ray(p->ellipsoid, &p->camera, p->width, p->height, x, y, &origin, &t->forward);
    reference_ray(p->ellipsoid, &p->camera, p->width, p->height, x + 1, y, &origin, &beside);
    reference_ray(p->ellipsoid, &p->camera, p->width, p->height, x, y - 1, &origin, &above);
    t->right = dvec3_normalize(dvec3_sub(beside, t->forward));
    t->up = dvec3_normalize(dvec3_sub(above, t->forward));
    double scale = 2 * tan(p->camera.fov_deg * (M_PI / 360)) / p->height;
    t->a = (depth_picture){p->a.z_m, p->width, p->height, scale};
    t->b = (depth_picture){p->b.z_m, p->width, p->height, scale};
}

// B's normal at a pixel in the eye's frame.
static dvec3 normal_at(const struct trial *t, size_t at, int x, int y)
{
    const compare_picture *b = &t->params->b;
    if (!b->nx || !b->ny || !b->nz) {
        depth_plane plane = depth_plane_at(&t->b, x, y);
        return depth_plane_normal(&t->b, &plane, x, y);
    }
    dvec3 n = {b->nx[at], b->ny[at], b->nz[at]};
    return (dvec3){dvec3_dot(n, t->right), dvec3_dot(n, t->up), dvec3_dot(n, t->forward)};
}

static void put(float *map, size_t at, double value)
{
    if (map) map[at] = (float)value;
}

// Both show ground.
static void measure_pixel(struct trial *t, size_t at, int x, int y)
{
    double za = t->a.z_m[at], zb = t->b.z_m[at], scale = t->b.scale;
    double ray_x = (x + 0.5 - 0.5 * t->b.width) * scale,
           ray_y = (0.5 * t->b.height - y - 0.5) * scale;
    dvec3 n = normal_at(t, at, x, y);
    double d = (za - zb) * (n.x * ray_x + n.y * ray_y + n.z);
    double pixel = zb * scale;
    double moved = d * hypot(n.x - ray_x * n.z, n.y - ray_y * n.z) / pixel;
    put(t->maps->geometric_px, at, moved);
    put(t->maps->depth_m, at, za - zb);
    stat_add(&t->sums[GEOMETRIC_ALL], moved, x, y);
    if (t->mask[at]) return;
    stat_add(&t->sums[GEOMETRIC], moved, x, y);
    stat_add(&t->sums[DISTANCE], d / pixel, x, y);
    stat_add(&t->sums[DEPTH], za - zb, x, y);
    stat_add(&t->sums[RELATIVE], (za - zb) / zb, x, y);
}

double compare_encoded(double light)
{
    light = clamp_double(light, 0, 1);
    return light <= 0.0031308 ? 12.92 * light : 1.055 * pow(light, 1 / 2.4) - 0.055;
}

static bool has_color(const compare_picture *p)
{
    return p->r && p->g && p->b;
}

static void measure_color(struct trial *t, size_t at)
{
    const compare_picture *a = &t->params->a, *b = &t->params->b;
    if (!has_color(a) || !has_color(b)) return;
    double of_a[3] = {a->r[at], a->g[at], a->b[at]}, of_b[3] = {b->r[at], b->g[at], b->b[at]};
    for (int i = 0; i < 3; i++) {
        double difference = compare_encoded(of_a[i]) - compare_encoded(of_b[i]);
        t->squares += difference * difference;
    }
    t->result->colors++;
}

// Does a pixel of the 3 x 3 neighbourhood show sky?
static bool near_kind(const depth_picture *p, int x, int y, bool sky)
{
    for (int j = y - 1; j <= y + 1; j++)
        for (int i = x - 1; i <= x + 1; i++)
            if (i >= 0 && j >= 0 && i < p->width && j < p->height &&
                !!isnan(p->z_m[(size_t)j * (size_t)p->width + (size_t)i]) == sky)
                return true;
    return false;
}

static bool sky_at(const depth_picture *p, int x, int y)
{
    return isnan(p->z_m[(size_t)y * (size_t)p->width + (size_t)x]);
}

static bool ground_at(const depth_picture *p, int x, int y)
{
    return x >= 0 && y >= 0 && x < p->width && y < p->height && !sky_at(p, x, y);
}

// Whether A shows ground on both sides of a pixel, across a direction.
static bool walled(const struct trial *t, int x, int y, int dx, int dy)
{
    return ground_at(&t->a, x + dy, y + dx) && ground_at(&t->a, x - dy, y - dx);
}

// Whether a missing pixel belongs to a silhouette that A has too low: it is next to B's sky, or
// from it to there, along a row or column, all is missing, and it is not the second pixel of a slit
// between A's ground (the first may be where two silhouettes meet).
static bool at_limb(const struct trial *t, int x, int y)
{
    static const int ways[4][2] = {{0, -1}, {0, 1}, {-1, 0}, {1, 0}};
    if (near_kind(&t->b, x, y, true)) return true;
    for (int k = 0; k < 4; k++) {
        int dx = ways[k][0], dy = ways[k][1], i = x, j = y, left = EDGE_SEARCH_PX;
        if (walled(t, x, y, dx, dy) && walled(t, x + dx, y + dy, dx, dy)) continue;
        do i += dx, j += dy;
        while (--left > 0 && ground_at(&t->b, i, j) && sky_at(&t->a, i, j));
        bool inside = i >= 0 && j >= 0 && i < t->b.width && j < t->b.height;
        if (inside && sky_at(&t->b, i, j)) return true;
    }
    return false;
}

static enum compare_kind kind_of(const struct trial *t, size_t at)
{
    bool sky_a = isnan(t->a.z_m[at]), sky_b = isnan(t->b.z_m[at]);
    if (sky_a) return sky_b ? COMPARE_SKY : COMPARE_MISSING;
    if (sky_b) return COMPARE_EXTRA;
    return t->mask[at] ? COMPARE_SILHOUETTE : COMPARE_GROUND;
}

static void compare_pixel(struct trial *t, int x, int y)
{
    size_t at = (size_t)y * (size_t)t->b.width + (size_t)x;
    compare_result *r = t->result;
    enum compare_kind kind = kind_of(t, at);
    size_t *const counts[] = {&r->sky, &r->ground, &r->silhouette, &r->missing, &r->extra};
    ++*counts[kind];
    if (kind == COMPARE_MISSING) r->missing_inside += !at_limb(t, x, y);
    if (kind == COMPARE_EXTRA) r->extra_outside += !near_kind(&t->b, x, y, false);
    if (t->maps->kind) t->maps->kind[at] = (unsigned char)kind;
    put(t->maps->geometric_px, at, NAN);
    put(t->maps->depth_m, at, NAN);
    if (kind != COMPARE_GROUND && kind != COMPARE_SILHOUETTE) return;
    measure_pixel(t, at, x, y);
    measure_color(t, at);
}

static void found_in_b(void *user, int x, int y, bool limb, double displacement_px)
{
    struct trial *t = user;
    size_t at = (size_t)y * (size_t)t->b.width + (size_t)x;
    t->result->edges_b++;
    t->result->edges_only_b += isnan(displacement_px);
    stat_add(&t->sums[limb ? LIMB : RIDGE], displacement_px, x, y);
    if (!t->maps->silhouette_px) return;
    float *to = &t->maps->silhouette_px[at], value = (float)displacement_px;
    if (isnan(value)) value = EDGE_SEARCH_PX + 1;
    *to = isnan(*to) ? value : fmaxf(*to, value);
}

static void found_in_a(void *user, int x, int y, bool limb, double displacement_px)
{
    struct trial *t = user;
    (void)x, (void)y, (void)limb;
    t->result->edges_a++;
    t->result->edges_only_a += isnan(displacement_px);
}

static void compare_edges(struct trial *t)
{
    const edge_sink of_b = {found_in_b, t}, of_a = {found_in_a, t};
    if (t->maps->silhouette_px)
        for (size_t i = 0; i < t->result->pixels; i++) t->maps->silhouette_px[i] = NAN;
    edges_mark(&t->b, &t->edges_b, t->mask);
    edges_mark(&t->a, &t->edges_a, t->mask);
    edges_match(&t->b, &t->edges_b, &t->a, &t->edges_a, t->mask, &of_b);
    edges_match(&t->a, &t->edges_a, &t->b, &t->edges_b, NULL, &of_a);
}

static status finish(struct trial *t)
{
    compare_result *r = t->result;
    compare_stat *const stats[MEASURES] = {&r->geometric_px,   &r->distance_px,      &r->depth_m,
                                           &r->depth_relative, &r->geometric_all_px, &r->limb_px,
                                           &r->ridge_px};
    const double *lat = t->params->b.lat_deg, *lon = t->params->b.lon_deg;
    status s = OK;
    for (int i = 0; i < MEASURES; i++) {
        status one = stat_finish(&t->sums[i], stats[i]);
        s = s ? s : one;
        if (stats[i]->count == 0) continue;
        size_t at = (size_t)stats[i]->y * (size_t)t->b.width + (size_t)stats[i]->x;
        if (lat) stats[i]->lat_deg = lat[at];
        if (lon) stats[i]->lon_deg = lon[at];
    }
    r->mse = r->colors ? t->squares / (3 * (double)r->colors) : NAN;
    r->psnr_db = -10 * log10(r->mse);
    return s;
}

status compare_pictures(const compare_params *params, const compare_maps *maps, compare_result *out)
{
    static const compare_maps none;
    struct trial t = {.params = params, .maps = maps ? maps : &none, .result = out};
    *out = (compare_result){.pixels = (size_t)params->width * (size_t)params->height};
    aim(&t);
    t.mask = calloc(out->pixels, 1);
    status s = t.mask ? OK : ERR_MEMORY;
    if (s) log_error("compare: out of memory for %dx%d pixels", params->width, params->height);
    if (!s) s = edges_find(&t.a, &t.edges_a);
    if (!s) s = edges_find(&t.b, &t.edges_b);
    if (!s) {
        compare_edges(&t);
        for (int y = 0; y < params->height; y++)
            for (int x = 0; x < params->width; x++) compare_pixel(&t, x, y);
    }
    status finished = finish(&t);
    edges_deinit(&t.edges_a);
    edges_deinit(&t.edges_b);
    free(t.mask);
    return s ? s : finished;
}

const char *compare_kind_name(enum compare_kind kind)
{
    static const char *const names[] = {"sky", "ground", "silhouette", "missing", "extra"};
    return names[kind];
}
