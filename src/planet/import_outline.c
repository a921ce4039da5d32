#include "planet/import_outline.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/vec.h"
#include "planet/import_blend.h"

// Pieces of a side of a raster in longitude and latitude, and of a circle around the globe.
enum { SIDE_PIECES = 8, CIRCLE_PIECES = 64 };

// Rows between rasters that still go on in each other: they may overlap or stand apart by one.
#define GAP_ROWS 1.5

// A chord of the border, on the sphere of geodetic latitude, in metres.
struct piece {
    dvec3 from, along; // the end is from + along
    double length2, width;
    int input;
};

// All points up to a distance from a centre.
struct disc {
    dvec3 centre;
    double radius;
};

struct outline {
    double radius;
    struct piece *pieces;
    int count, room;
};

static dvec3 direction(double lat, double lon)
{
    return dvec3_make(cos(lat) * cos(lon), cos(lat) * sin(lon), sin(lat));
}

static dvec3 middle(const struct piece *p)
{
    return dvec3_mad(p->from, p->along, 0.5);
}

static double distance2(const struct piece *p, dvec3 at)
{
    dvec3 to = dvec3_sub(at, p->from);
    double t = dvec3_dot(to, p->along) / p->length2;
    dvec3 off = dvec3_mad(to, p->along, t < 0 ? -0.0 : t > 1 ? -1.0 : -t);
    return dvec3_dot(off, off);
}

// Does the closed line wind around the point? By the bearings of its points.
static bool winds_around(const raster_outline *o, double lat, double lon)
{
    double sum = 0, before = 0;
    for (int i = 0; i <= o->count; i++) {
        int k = i % o->count;
        double d = o->lon[k] - lon;
        double bearing = atan2(sin(d) * cos(o->lat[k]),
                               cos(lat) * sin(o->lat[k]) - sin(lat) * cos(o->lat[k]) * cos(d));
        if (i) sum += geo_wrap_lon(bearing - before);
        before = bearing;
    }
    return fabs(sum) > M_PI;
}

bool outline_holds(const raster_grid *g, double lat, double lon)
{
    if (lat < g->south || lat > g->north) return false;
    double east = lon - g->west;
    east -= 2 * M_PI * floor(east / (2 * M_PI));
    if (!g->full_circle && east > g->east - g->west) return false;
    return g->outline.count == 0 || winds_around(&g->outline, lat, lon);
}

static void add_piece(struct outline *o, int input, double lat0, double lon0, double lat1,
                      double lon1)
{
    dvec3 a = dvec3_scale(direction(lat0, lon0), o->radius);
    dvec3 along = dvec3_sub(dvec3_scale(direction(lat1, lon1), o->radius), a);
    double length2 = dvec3_dot(along, along);
    if (!(length2 > 1e-6)) return; // a side at a pole
    if (o->count == o->room) {
        o->room = 2 * o->room + 64;
        struct piece *more = NEW_ARRAY(struct piece, (size_t)o->room);
        if (o->count) memcpy(more, o->pieces, (size_t)o->count * sizeof *more);
        free(o->pieces);
        o->pieces = more;
    }
    o->pieces[o->count++] = (struct piece){a, along, length2, 0, input};
}

static void add_line(struct outline *o, int input, int pieces, double lat0, double lon0,
                     double lat1, double lon1)
{
    for (int i = 0; i < pieces; i++) {
        double s = (double)i / pieces, t = (i + 1.0) / pieces;
        add_piece(o, input, lat0 + s * (lat1 - lat0), lon0 + s * (lon1 - lon0),
                  lat0 + t * (lat1 - lat0), lon0 + t * (lon1 - lon0));
    }
}

static void add_raster(struct outline *o, int input, const raster_grid *g)
{
    const raster_outline *line = &g->outline;
    for (int i = 0; i < line->count; i++) {
        int next = (i + 1) % line->count;
        add_piece(o, input, line->lat[i], line->lon[i], line->lat[next], line->lon[next]);
    }
    if (line->count) return;
    int across = g->full_circle ? CIRCLE_PIECES : SIDE_PIECES;
    add_line(o, input, across, g->north, g->west, g->north, g->east);
    add_line(o, input, across, g->south, g->west, g->south, g->east);
    if (g->full_circle) return;
    add_line(o, input, SIDE_PIECES, g->south, g->west, g->north, g->west);
    add_line(o, input, SIDE_PIECES, g->south, g->east, g->north, g->east);
}

static bool any_holds(const raster_grid *grids, const int *order, int count, dvec3 at)
{
    double lat = atan2(at.z, hypot(at.x, at.y)), lon = atan2(at.y, at.x);
    if (M_PI / 2 - fabs(lat) < 1e-9) return true; // rasters end there
    for (int i = 0; i < count; i++)
        if (outline_holds(&grids[order[i]], lat, lon)) return true;
    return false;
}

// Leaves the pieces that have the mosaic on one side only and something below them.
static void keep_border(struct outline *o, const raster_grid *grids, const int *order, int count,
                        outline_width width, void *user)
{
    int kept = 0;
    for (int i = 0; i < o->count; i++) {
        struct piece p = o->pieces[i];
        dvec3 mid = middle(&p), side = dvec3_cross(mid, p.along);
        double step = GAP_ROWS * grids[p.input].dlat * o->radius / dvec3_length(side);
        if (any_holds(grids, order, count, dvec3_mad(mid, side, step)) &&
            any_holds(grids, order, count, dvec3_mad(mid, side, -step)))
            continue;
        p.width = width(user, atan2(mid.z, hypot(mid.x, mid.y)), atan2(mid.y, mid.x));
        if (p.width > 0) o->pieces[kept++] = p;
    }
    o->count = kept;
}

static dvec3 centre_of(const raster_grid *g, double radius)
{
    dvec3 sum = direction((g->north + g->south) / 2, (g->west + g->east) / 2);
    if (g->outline.count) sum = dvec3_make(0, 0, 0);
    for (int i = 0; i < g->outline.count; i++)
        sum = dvec3_add(sum, direction(g->outline.lat[i], g->outline.lon[i]));
    return dvec3_scale(sum, radius / dvec3_length(sum));
}

// About a raster's centre, inside the mosaic.
static struct disc greatest_disc(const struct outline *o, const raster_grid *g)
{
    struct disc d = {centre_of(g, o->radius), INFINITY};
    // A belt around the globe has no centre.
    if (g->full_circle && !g->outline.count) d.radius = (g->north - g->south) / 2 * o->radius;
    for (int i = 0; i < o->count && (!g->full_circle || g->outline.count); i++)
        d.radius = fmin(d.radius, sqrt(distance2(&o->pieces[i], d.centre)));
    return d;
}

static void limit_widths(struct outline *o, const raster_grid *grids, const int *order, int count)
{
    struct disc *discs = NEW_ARRAY(struct disc, (size_t)count);
    for (int i = 0; i < count; i++) discs[i] = greatest_disc(o, &grids[order[i]]);
    for (int i = 0; i < o->count; i++) {
        struct piece *p = &o->pieces[i];
        double most = 0;
        for (int k = 0; k < count; k++) {
            double radius = discs[k].radius;
            if (radius <= most) continue;
            dvec3 off = dvec3_sub(discs[k].centre, middle(p));
            double reach = 1.5 * radius;
            if (order[k] == p->input || dvec3_dot(off, off) <= reach * reach) most = radius;
        }
        p->width = fmin(p->width, most / 2);
    }
    free(discs);
}

struct outline *outline_create(const raster_grid *grids, const int *order, int count, double radius,
                               outline_width width, void *user)
{
    struct outline *o = NEW(struct outline);
    o->radius = radius;
    for (int i = 0; i < count; i++) add_raster(o, order[i], &grids[order[i]]);
    keep_border(o, grids, order, count, width, user);
    limit_widths(o, grids, order, count);
    return o;
}

void outline_destroy(struct outline **outline)
{
    if (!*outline) return;
    free((*outline)->pieces);
    free(*outline);
    *outline = NULL;
}

// A ball around all of a tile's samples.
static struct disc ball_of(const struct outline *o, tile_id id)
{
    double west, south, east, north;
    grid_bounds(id, &west, &south, &east, &north);
    struct disc ball = {dvec3_scale(direction((south + north) / 2, (west + east) / 2), o->radius),
                        0};
    for (int i = 0; i < 9; i++) {
        dvec3 at = direction(south + i / 3 * (north - south) / 2, west + i % 3 * (east - west) / 2);
        dvec3 off = dvec3_sub(dvec3_scale(at, o->radius), ball.centre);
        ball.radius = fmax(ball.radius, dvec3_length(off));
    }
    return ball;
}

static bool is_near(const struct piece *p, const struct disc *ball, double margin)
{
    double most = ball->radius + p->width + margin;
    return distance2(p, ball->centre) < most * most;
}

bool outline_meets(const struct outline *o, tile_id id, double margin)
{
    struct disc ball = ball_of(o, id);
    for (int i = 0; i < o->count; i++)
        if (is_near(&o->pieces[i], &ball, margin)) return true;
    return false;
}

// The pieces within their width and the margin of any of the tile's samples.
static int near_pieces(const struct outline *o, tile_id id, double margin,
                       const struct piece **near)
{
    struct disc ball = ball_of(o, id);
    int count = 0;
    for (int i = 0; i < o->count; i++)
        if (is_near(&o->pieces[i], &ball, margin)) near[count++] = &o->pieces[i];
    return count;
}

static float weight_at(const struct piece *const *near, int count, double margin, dvec3 at)
{
    double least = 1;
    for (int i = 0; i < count && least > 0; i++) {
        double width = near[i]->width, d2 = distance2(near[i], at), far = least * width + margin;
        if (d2 < far * far) least = fmax(0, (sqrt(d2) - margin) / width);
    }
    return fmaxf(BLEND_LEAST_WEIGHT, (float)(least * least * (3 - 2 * least)));
}

status outline_lower(const struct outline *o, tile_id id, double margin, float *weights)
{
    const struct piece **near = calloc((size_t)o->count + 1, sizeof *near);
    if (!near) return ERR_MEMORY;
    int count = near_pieces(o, id, margin, near);
    double west, south, east, north, step = grid_step_lon(id.zoom, id.row);
    grid_bounds(id, &west, &south, &east, &north);
    for (int y = 0; y < TILE_SIZE && count; y++) {
        double lat = grid_lat(id.zoom, (int64_t)id.row * TILE_SIZE + y);
        double ring = o->radius * cos(lat), z = o->radius * sin(lat);
        for (int x = 0; x < TILE_SIZE; x++) {
            double lon = west + (x + 0.5) * step;
            float w =
                weight_at(near, count, margin, dvec3_make(ring * cos(lon), ring * sin(lon), z));
            float *to = &weights[y * TILE_SIZE + x];
            *to = fminf(*to, w);
        }
    }
    free(near);
    return OK;
}
