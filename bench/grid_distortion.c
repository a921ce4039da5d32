#include "bench/grid_distortion.h"

#include <stdlib.h>

#include "base/memory.h"
#include "geo/grid_rays.h"
#include "planet/grid.h"

enum {
    WIDTH = DISTORTION_WIDTH,
    HEIGHT = DISTORTION_HEIGHT,
    CELL = 2,
    ACROSS = WIDTH / CELL,
    DOWN = HEIGHT / CELL
};

// A vector of the scaled space about the focus, in ECEF metres.
static dvec3 to_ecef(const struct geo_focus *f, const double v[3])
{
    double a = f->ellipsoid.a, b = f->ellipsoid.b;
    dvec3 meridian = {a * (f->cb * v[0] - f->sb * v[2]), a * v[1],
                      b * (f->sb * v[0] + f->cb * v[2])};
    return dmat3_mul(dmat3_transpose(f->meridian_from_ecef), meridian);
}

static struct point project(const grid_params *p, dvec3 from_camera)
{
    dvec3 e = dmat3_mul(geo_eye_over(p->ellipsoid, &p->camera), from_camera);
    double k = e.z < 0 ? HEIGHT / (2 * tan(p->camera.fov_y / 2)) / -e.z : NAN;
    return (struct point){k * e.x, k * e.y, false};
}

// To the farthest neighbour; the places of a grid's row follow those of the row before.
static double spacing_of(const grid_params *p, const double (*place)[3], int i)
{
    int row = i / p->columns, column = i % p->columns, count = 0, near[4];
    double most = 1e-12;
    if (row > 0) near[count++] = i - p->columns;
    if (row < p->rows - 1) near[count++] = i + p->columns;
    if (column > 0) near[count++] = i - 1;
    if (column < p->columns - 1) near[count++] = i + 1;
    for (int k = 0; k < count; k++) {
        const double *a = place[i], *b = place[near[k]];
        most = fmax(most, hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]));
    }
    return most;
}

// At the level of detail that the farthest neighbour allows.
static double height_at(const struct scene *s, geodetic at, double spacing)
{
    int zoom;
    float coarser;
    double fine = s->constant_m, coarse = 0;
    if (!s->pyramid) return fine;
    grid_level((float)(grid_step_lat(0) / spacing), (float)s->finest, &zoom, &coarser);
    if (pyramid_height_at(s->pyramid, zoom, at.lat, at.lon, &fine)) exit(1);
    if (coarser > 0 && pyramid_height_at(s->pyramid, zoom - 1, at.lat, at.lon, &coarse)) exit(1);
    return fine + (double)coarser * (coarse - fine);
}

static struct point lift(const struct scene *s, const double place[3], double spacing)
{
    const struct geo_focus *f = &s->focus;
    geo_ellipsoid e = s->p.ellipsoid;
    geodetic at = geo_is_plane(e) ? (geodetic){f->lat + place[2], f->lon + place[1], 0}
                                  : geo_geodetic_from_ecef(e, to_ecef(f, place));
    at.height = height_at(s, at, spacing);
    return project(&s->p, dvec3_sub(geo_ecef_from_geodetic(e, at),
                                    geo_ecef_from_geodetic(e, s->p.camera.position)));
}

// Both sets, row by row.
static void make_sets(struct scene *s, struct point *uniform, struct point *mesh)
{
    const grid_params *p = &s->p;
    s->p.focus = &s->focus;
    struct grid_block b;
    struct grid_column *columns = NEW_ARRAY(struct grid_column, (size_t)p->columns);
    int count = p->rows * p->columns;
    double(*place)[3] = memory_new((size_t)count, sizeof *place);
    if (!grid_make(p, &b, columns)) exit(1);
    for (int i = 0; i < count; i++) {
        double d[3];
        grid_ray(p, &b, &columns[i % p->columns], i / p->columns, d, place[i]);
        double down = -(d[0] * b.axis[0] + d[1] * b.axis[1] + d[2] * b.axis[2]);
        double all = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
        uniform[i] = project(p, to_ecef(&s->focus, d));
        uniform[i].beyond = down < b.limb[0] * sqrt(fmax(all - down * down, 0)) * (1 - 1e-9);
    }
    for (int i = 0; i < count; i++) {
        mesh[i] = lift(s, place[i], spacing_of(p, (const double(*)[3])place, i));
        mesh[i].beyond = uniform[i].beyond;
    }
    free(place);
    free(columns);
}

// Cell of a point; what lies outside the picture is held by the cells at its edge.
static int cell_of(struct point p)
{
    return (int)clamp_double(floor((p.y + HEIGHT / 2.0) / CELL), 0, DOWN - 1) * ACROSS +
           (int)clamp_double(floor((p.x + WIDTH / 2.0) / CELL), 0, ACROSS - 1);
}

static double nearest_in(const struct point *to, int i, const int *next, struct point p)
{
    double best = INFINITY;
    for (; i >= 0; i = next[i]) best = fmin(best, hypot(to[i].x - p.x, to[i].y - p.y));
    return best;
}

// By rings of cells: what is not met after ring r is farther than r cells.
static double nearest(const struct point *to, const int *head, const int *next, struct point p)
{
    int cell = cell_of(p), cx = cell % ACROSS, cy = cell / ACROSS;
    double best = INFINITY;
    for (int r = 0; r <= ACROSS && best > (r - 1) * CELL; r++)
        for (int y = cy - r; y <= cy + r; y++)
            for (int x = cx - r; x <= cx + r; x += y == cy - r || y == cy + r ? 1 : 2 * r)
                if (x >= 0 && y >= 0 && x < ACROSS && y < DOWN)
                    best = fmin(best, nearest_in(to, head[y * ACROSS + x], next, p));
    return best;
}

bool in_picture(struct point p)
{
    return fabs(p.x) <= WIDTH / 2.0 && fabs(p.y) <= HEIGHT / 2.0;
}

// The greatest distance from one set to the other.
static double directed(const struct point *from, const struct point *to, int count)
{
    static int head[ACROSS * DOWN];
    int *next = NEW_ARRAY(int, (size_t)count);
    double most = 0;
    for (int i = 0; i < ACROSS * DOWN; i++) head[i] = -1;
    for (int i = 0; i < count; i++) {
        if (isnan(to[i].x)) continue;
        next[i] = head[cell_of(to[i])];
        head[cell_of(to[i])] = i;
    }
    for (int i = 0; i < count; i++) {
        if (from[i].beyond || !in_picture(from[i])) continue; // NaN is not in it
        most = fmax(most, nearest(to, head, next, from[i]));
    }
    free(next);
    return most;
}

struct ways distortion(struct scene *s, struct point *uniform, struct point *mesh)
{
    int count = s->p.rows * s->p.columns;
    make_sets(s, uniform, mesh);
    return (struct ways){directed(uniform, mesh, count), directed(mesh, uniform, count)};
}
