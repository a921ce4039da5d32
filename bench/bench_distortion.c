// How far the persistent grid's vertices stray on the screen when they are lifted to the ground
// (Livny et al. 2008, Table 4; grid_distortion.h), as CSV:
//   bench_distortion PLANET
// Without synthesis. First the measure is checked against a sea at height 0 and the closed form
// over a plane; fails when they disagree. Fails when broken: heights of the other sign give 15.5 px
// for 13.7.
#include <stdio.h>
#include <stdlib.h>

#include "base/memory.h"
#include "bench/grid_distortion.h"
#include "planet/planet_file.h"

enum { WIDTH = DISTORTION_WIDTH, HEIGHT = DISTORTION_HEIGHT, COARSE = 12 };

#define RAD (M_PI / 180)

static const int SIZES[][2] = {{150, 600}, {200, 800}, {430, 430},
                               {300, 900}, {600, 600}, {400, 1600}};
static const struct {
    const char *name;
    double lat_deg, lon_deg;
} GROUNDS[] = {{"mountains", 38.05, 128.42}, {"lowland", 36.2, 126.9}};
static const double DOWN_DEG[] = {90, 70, 50, 30, 10, 0};

static struct scene scene_at(geo_ellipsoid e, geo_camera camera)
{
    struct scene s = {.p = {.ellipsoid = e,
                            .camera = camera,
                            .aspect = (double)WIDTH / HEIGHT,
                            .rows = COARSE,
                            .columns = COARSE,
                            .discs = {{M_PI, 0, 0}},
                            .disc_count = 1,
                            .ground_m = NAN}};
    s.focus = geo_focus_make(e, camera.position.lat, camera.position.lon,
                             geo_ecef_from_geodetic(e, camera.position), 0);
    return s;
}

// Bounds of all heights in discs about the camera; where the frame has its windows, here the tiles,
// each as high as its disc's radius, and what is inside.
static void set_discs(struct scene *s)
{
    grid_params *p = &s->p;
    geodetic at = p->camera.position;
    p->disc_count = s->finest + 1;
    for (int z = s->finest; z >= 0; z--) {
        double radius = ldexp(M_PI, -z), low = INFINITY, high = -INFINITY;
        for (int row = 0; row < grid_rows(z); row++)
            for (int col = 0; col < grid_cols(z, row); col++) {
                const pyramid_tile *t;
                tile_id id = {LAYER_HEIGHT, z, row, col};
                double west, south, east, north;
                grid_bounds(id, &west, &south, &east, &north);
                double aside = fabs(geo_wrap_lon((west + east) / 2 - at.lon)) - (east - west) / 2;
                if (south > at.lat + radius || north < at.lat - radius) break;
                if (aside * cos(at.lat) > 2 * radius) continue;
                if (pyramid_acquire(s->pyramid, id, &t)) exit(1);
                low = fmin(low, (double)t->min);
                high = fmax(high, (double)t->max);
                pyramid_release(s->pyramid, &t);
            }
        if (z < s->finest) low = fmin(low, p->discs[z + 1].low);
        if (z < s->finest) high = fmax(high, p->discs[z + 1].high);
        p->discs[z] = (grid_disc){radius, low, high};
    }
}

// Where a vertex of a plane's grid goes when it is lifted by a share of the camera's height.
static struct point lifted(const grid_params *p, struct point at, double share)
{
    double k = HEIGHT / (2 * tan(p->camera.fov_y / 2)), cp = cos(p->camera.pitch),
           sp = sin(p->camera.pitch), t = -1 / (at.y / k * cp + sp), z = t + share * sp;
    return (struct point){t * at.x / z, (t * at.y + k * share * cp) / z, false};
}

// Nothing moves on a sea; over a plane lifted by less than half a step all vertices stay their own
// nearest, and the greatest way of one is the distance.
static void check(double pitch_deg, double share)
{
    geo_camera c = {{0.6, 2.2, 2000}, 0.7, pitch_deg * RAD, 0, 60 * RAD};
    struct point uniform[COARSE * COARSE], mesh[COARSE * COARSE];
    struct scene sea = scene_at(GEO_WGS84, c), plane = scene_at(geo_plane_of(GEO_WGS84), c);
    plane.constant_m = share * c.position.height;
    plane.p.discs[0].high = plane.constant_m;
    struct ways still = distortion(&sea, uniform, mesh), moved = distortion(&plane, uniform, mesh);
    double most = 0;
    for (int i = 0; i < COARSE * COARSE; i++) {
        struct point to = lifted(&plane.p, uniform[i], share);
        if (in_picture(uniform[i]) || in_picture(to))
            most = fmax(most, hypot(to.x - uniform[i].x, to.y - uniform[i].y));
    }
    fprintf(stderr, "check, down %g: sea %.1e px; plane %.6f and %.6f px, closed form %.6f\n",
            -pitch_deg, fmax(still.gap, still.stray), moved.gap, moved.stray, most);
    if (!(fmax(still.gap, still.stray) < 1e-5 && most > 8 &&
          fabs(fmax(moved.gap, moved.stray) - most) < 1e-5))
        exit(1);
}

static void measure(struct pyramid *pyramid, geo_ellipsoid e, int size, int ground, int view)
{
    geo_camera c = {{GROUNDS[ground].lat_deg * RAD, GROUNDS[ground].lon_deg * RAD, 0},
                    0,
                    -DOWN_DEG[view] * RAD,
                    0,
                    60 * RAD};
    if (pyramid_height_at(pyramid, 14, c.position.lat, c.position.lon, &c.position.height)) exit(1);
    c.position.height += 2000;
    struct scene s = scene_at(e, c);
    s.pyramid = pyramid;
    s.finest = pyramid_meta(pyramid)->max_zoom[LAYER_HEIGHT];
    s.p.rows = SIZES[size][0];
    s.p.columns = SIZES[size][1];
    set_discs(&s);
    struct point *sets = NEW_ARRAY(struct point, 2 * (size_t)(s.p.rows * s.p.columns));
    struct ways d = distortion(&s, sets, sets + s.p.rows * s.p.columns);
    printf("%s,%g,%dx%d,%.2f,%.2f,%.2f\n", GROUNDS[ground].name, DOWN_DEG[view], s.p.rows,
           s.p.columns, fmax(d.gap, d.stray), d.gap, d.stray);
    fflush(stdout);
    free(sets);
}

int main(int argc, char **argv)
{
    struct planet_file *file;
    struct pyramid *pyramid;
    pyramid_params params = {.cache_bytes = (size_t)512 << 20};
    if (argc != 2) return fprintf(stderr, "usage: bench_distortion PLANET\n"), 2;
    check(-90, 0.04);
    check(-45, 0.04);
    if (planet_file_open(argv[1], &file) || pyramid_create(file, &params, &pyramid)) return 1;
    printf("ground,down_deg,grid,hausdorff_px,uniform_to_mesh_px,mesh_to_uniform_px\n");
    for (int ground = 0; ground < 2; ground++)
        for (int view = 0; view < 6; view++)
            for (int size = 0; size < 6; size++)
                measure(pyramid, pyramid_meta(pyramid)->ellipsoid, size, ground, view);
    pyramid_destroy(&pyramid);
    planet_file_close(&file);
    return 0;
}
