#include "render/gaps.h"

const char *const gaps_border_names[GAPS_BORDERS] = {"level border", "fill", "sector",
                                                     "seam",         "pole", "antimeridian"};

void gaps_read(perigee_view *view, struct gaps_frame *f)
{
    perigee_stats stats;
    perigee_view_get_stats(view, &stats);
    f->late = stats.needs_redraw;
    f->last_level = (int)stats.last_level;
    perigee_planes planes = {.z_m = f->z, .lat_deg = f->lat, .lon_deg = f->lon};
    perigee_triangles triangles = {.triangle = f->triangle, .level = f->level, .sector = f->sector};
    assert_int_equal(perigee_view_read_planes(view, &planes), 0);
    assert_int_equal(perigee_view_read_triangles(view, &triangles), 0);
}

static bool on_map(const scene_map *map, double east, double north)
{
    double lat = north / map->radius, lon = east / map->radius;
    return lat > map->south && lat < map->north && lon > map->west && lon < map->east;
}

// Does the ray meet the plane of so many metres on the map?
static bool meets_plane(const scene_map *map, const double o[3], const double d[3], double metres)
{
    double along = (metres - o[0]) / d[0];
    return along > 0 && on_map(map, o[1] + along * d[1], o[2] + along * d[2]);
}

// Does the ray of a point of the picture pass over the map from its highest ground to its lowest?
static bool falls_on_map(const perigee_camera *c, double x_px, double y_px)
{
    double o[3], d[3];
    const scene_map *map = scene_flat();
    scene_ray(c, GAPS_WIDTH, GAPS_HEIGHT, x_px, y_px, o, d);
    return (on_map(map, o[1], o[2]) || meets_plane(map, o, d, map->height_max + 1)) &&
           meets_plane(map, o, d, map->height_min - 1);
}

static bool plane_must_show(const perigee_camera *c, int k, double limb_px)
{
    bool all = true;
    for (int i = 0; i < (limb_px > 0 ? 4 : 1); i++)
        all = all && falls_on_map(c, k % GAPS_WIDTH + 0.5 + (i % 2 ? limb_px : -limb_px),
                                  k / GAPS_WIDTH + 0.5 + (i / 2 ? limb_px : -limb_px));
    return all;
}

// Does the ray meet the ellipsoid lowered by so many metres? `along`: where it comes closest.
static bool meets_lowered(const double o[3], const double d[3], double metres, double *along)
{
    double a = 6378137.0 - metres, b = 6356752.314245179 - metres;
    double x[3] = {o[0] / a, o[1] / a, o[2] / b}, v[3] = {d[0] / a, d[1] / a, d[2] / b};
    double vv = v[0] * v[0] + v[1] * v[1] + v[2] * v[2],
           xv = x[0] * v[0] + x[1] * v[1] + x[2] * v[2];
    double xx = x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
    *along = -xv / vv;
    return xv < 0 && xv * xv - vv * (xx - 1) > 0;
}

static bool must_show(const perigee_camera *c, const double o[3], const double d[3], double limb_px)
{
    double along, deep = ANALYTIC_HEIGHT_MAX + 1;
    if (!meets_lowered(o, d, deep, &along)) return false;
    double pixel = 2 * tan(c->fov_deg * (M_PI / 360)) / GAPS_HEIGHT * along;
    return limb_px == 0 || meets_lowered(o, d, deep + limb_px * pixel, &along);
}

// Does the ray pass over the map no higher than the highest terrain, give or take some metres?
static bool may_show(const double o[3], const double d[3])
{
    double from = 0, to = 1e12;
    const scene_map *map = scene_flat();
    const double low[3] = {map->height_min - 1, map->radius * map->west - 1,
                           map->radius * map->south - 1},
                 high[3] = {map->height_max + 1, map->radius * map->east + 1,
                            map->radius * map->north + 1};
    for (int i = 0; i < 3; i++) {
        double s = (low[i] - o[i]) / d[i], t = (high[i] - o[i]) / d[i];
        from = fmax(from, fmin(s, t));
        to = fmin(to, fmax(s, t));
    }
    return from < to;
}

// Distance along the axis of the ground that two opposite neighbours of pixel k both show, about
// equally far, when k shows nothing as near; else 0.
static double covered_by(const struct gaps_frame *f, int k, int step)
{
    double a = f->z[k - step], b = f->z[k + step], far = fmax(a, b);
    if (isnan(a) || isnan(b) || far > 1.02 * fmin(a, b)) return 0;
    return isnan(f->z[k]) || f->z[k] > 1.1 * far ? far : 0;
}

// Is the ground there, as near as `far`, all around the pixel?
static bool solid(const perigee_camera *c, int k, double far)
{
    double x = k % GAPS_WIDTH + 0.5, y = k / GAPS_WIDTH + 0.5;
    for (int i = 0; i < 9; i++) {
        double o[3], d[3];
        scene_ray(c, GAPS_WIDTH, GAPS_HEIGHT, x + i % 3 - 1, y + i / 3 % 3 - 1, o, d);
        double t = scene_trace(o, d);
        if (isnan(t) || t > 1.03 * far) return false;
    }
    return true;
}

static bool cracked(const perigee_camera *c, const struct gaps_frame *f, int k)
{
    int x = k % GAPS_WIDTH, y = k / GAPS_WIDTH;
    if (x == 0 || y == 0 || x == GAPS_WIDTH - 1 || y == GAPS_HEIGHT - 1) return false;
    double far = fmax(covered_by(f, k, 1), covered_by(f, k, GAPS_WIDTH));
    return far > 0 && solid(c, k, far);
}

struct gaps_counts gaps_find(const perigee_camera *c, const struct gaps_frame *f, double limb_px)
{
    struct gaps_counts n = {0};
    for (int k = 0; k < GAPS_PIXELS; k++) {
        double o[3], d[3];
        scene_ray(c, GAPS_WIDTH, GAPS_HEIGHT, k % GAPS_WIDTH + 0.5, k / GAPS_WIDTH + 0.5, o, d);
        bool sky = isnan(f->z[k]),
             inside = scene_flat() ? plane_must_show(c, k, limb_px) : must_show(c, o, d, limb_px);
        n.inside += inside;
        n.beyond += scene_flat() && !sky && !may_show(o, d);
        n.background += inside && sky;
        n.cracks += cracked(c, f, k);
        n.unidentified += sky != (f->triangle[k] == 0);
    }
    return n;
}

static bool seam_between(int a, int b)
{
    return (a == 31 && b == 0) || (a == 0 && b == 31) || (a == 15 && b == 16) ||
           (a == 16 && b == 15);
}

static bool meets(const struct gaps_frame *f, int a, int b, enum gaps_border border)
{
    int level = abs(f->level[a] - f->level[b]), deeper = f->level[a] > f->level[b] ? a : b;
    bool fill = f->level[deeper] > f->last_level;
    int turn = abs(f->sector[a] - f->sector[b]);
    switch (border) {
    case GAPS_LEVEL:
        return level == 1 && !fill;
    case GAPS_FILL:
        return level == 1 && fill;
    case GAPS_SECTOR:
        return turn == 1 && !seam_between(f->sector[a], f->sector[b]);
    case GAPS_SEAM:
        return seam_between(f->sector[a], f->sector[b]);
    case GAPS_ANTIMERIDIAN:
        return fabs(f->lon[a] - f->lon[b]) > 359;
    default:
        return false;
    }
}

static int quarters_met(const struct gaps_frame *f)
{
    int seen = 0;
    for (int y = GAPS_HEIGHT / 3; y < GAPS_HEIGHT * 2 / 3; y++)
        for (int x = GAPS_WIDTH / 3; x < GAPS_WIDTH * 2 / 3; x++)
            if (f->triangle[y * GAPS_WIDTH + x])
                seen |= 1 << ((int)floor((f->lon[y * GAPS_WIDTH + x] + 180) / 90) & 3);
    return seen == 15 ? 4 : 0;
}

int gaps_met(const struct gaps_frame *f, enum gaps_border border)
{
    if (border == GAPS_POLE) return quarters_met(f);
    int pairs = 0;
    for (int y = GAPS_HEIGHT / 3; y < GAPS_HEIGHT * 2 / 3; y++) {
        for (int x = GAPS_WIDTH / 3; x < GAPS_WIDTH * 2 / 3; x++) {
            int k = y * GAPS_WIDTH + x, next[2] = {k + 1, k + GAPS_WIDTH};
            for (int i = 0; i < 2; i++)
                pairs += f->triangle[k] && f->triangle[next[i]] && meets(f, k, next[i], border);
        }
    }
    return pairs;
}
