// Screen-space geometric error against triangles: bench_error PLANET [PART-OF-A-VIEW'S-NAME]
//
// Per view and setting: each ninth pixel's point, its distance from the surface of the finest data
// along that surface's normal, projected to the screen (px): rms, 99.9 %, maximum; triangles drawn
// for each pixel of ground.
#include <epoxy/gl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "bench/error_views.h"
#include "gpu/context.h"
#include "gpu/target.h"
#include "perigee.h"
#include "planet/planet_file.h"
#include "planet/pyramid.h"

enum { WIDTH = 1280, HEIGHT = 960, PIXELS = WIDTH * HEIGHT, STEP = 3 };

struct setting {
    const char *name;
    perigee_view_params params;
};

static const struct setting SETTINGS[] = {
    {"default", {0}},
    {"paper", {.quality = PERIGEE_QUALITY_PAPER}},
    {"low", {.quality = PERIGEE_QUALITY_LOW}},
    {"high", {.quality = PERIGEE_QUALITY_HIGH}},
};

struct judge {
    struct pyramid *pyramid;
    geo_ellipsoid e;
    int zoom;
};

static double ground(const struct judge *j, double lat, double lon)
{
    double h = 0;
    pyramid_height_at(j->pyramid, j->zoom, lat, lon, &h);
    return h;
}

// Upper normal of the surface by differences of half a sample.
static dvec3 normal_at(const struct judge *j, double lat, double lon)
{
    double step = 0.5 * M_PI / ldexp(256, j->zoom), wide = step / fmax(cos(lat), 1e-3);
    dvec3 s = geo_ecef_from_geodetic(j->e, (geodetic){lat - step, lon, ground(j, lat - step, lon)}),
          n = geo_ecef_from_geodetic(j->e, (geodetic){lat + step, lon, ground(j, lat + step, lon)}),
          w = geo_ecef_from_geodetic(j->e, (geodetic){lat, lon - wide, ground(j, lat, lon - wide)}),
          o = geo_ecef_from_geodetic(j->e, (geodetic){lat, lon + wide, ground(j, lat, lon + wide)});
    if (fabs(lat) > M_PI / 2 - 4 * step) return geo_normal(lat, lon);
    return dvec3_normalize(dvec3_cross(dvec3_sub(o, w), dvec3_sub(n, s)));
}

static int ascending(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

struct frame_planes {
    float *z, *height, *level;
    double *lat, *lon;
};

static void judge_frame(const struct judge *j, const perigee_camera *c,
                        const struct frame_planes *f, const perigee_stats *s, const char *view,
                        const char *setting, double ms)
{
    static float errors[PIXELS];
    double sum = 0, lsum[32] = {0}, worst = 0;
    int n = 0, ln[32] = {0}, ground_px = 0, at = 0;
    double rad = M_PI / 180;
    dvec3 eye =
        geo_ecef_from_geodetic(j->e, (geodetic){c->lat_deg * rad, c->lon_deg * rad, c->alt_m});
    for (int i = 0; i < PIXELS; i++) {
        if (isnan(f->z[i])) continue;
        ground_px++;
        if (i % WIDTH % STEP != 1 || i / WIDTH % STEP != 1) continue;
        double lat = f->lat[i] * rad, lon = f->lon[i] * rad;
        double dh = f->height[i] - ground(j, lat, lon);
        dvec3 p = geo_ecef_from_geodetic(j->e, (geodetic){lat, lon, f->height[i]});
        dvec3 up = geo_normal(lat, lon), nrm = normal_at(j, lat, lon);
        dvec3 ray = dvec3_sub(p, eye);
        double dist = dvec3_length(ray);
        ray = dvec3_scale(ray, 1 / dist);
        double d = dh * dvec3_dot(up, nrm);
        double across = dvec3_length(dvec3_cross(nrm, ray));
        double pixel = 2 * tan(c->fov_deg * rad / 2) / HEIGHT * f->z[i];
        double e = fabs(d) * across / pixel; // off-axis stretch left out
        errors[n++] = (float)e;
        sum += e * e;
        if (e > worst) worst = e, at = i;
        int l = (int)f->level[i];
        if (l >= 0 && l < 32) lsum[l] += e * e, ln[l]++;
    }
    qsort(errors, (size_t)n, sizeof *errors, ascending);
    printf("%-26s %-12s rms %6.3f  99.9 %7.3f  max %8.2f at %4d,%3d  levels %2u-%2u  tri %7llu  "
           "tri/px %.3f  vis/px %.3f |",
           view, setting, n ? sqrt(sum / n) : 0, n ? errors[(int)(0.999 * n)] : 0, worst,
           at % WIDTH, at / WIDTH, s->first_level, s->last_level,
           (unsigned long long)s->triangles_drawn,
           (double)s->triangles_drawn / (ground_px ? ground_px : 1), ms);
    for (int l = 0; l < 32; l++)
        if (ln[l] && getenv("LEVELS")) printf(" %d:%.2f", l, sqrt(lsum[l] / ln[l]));
    printf("\n");
    fflush(stdout);
}

int main(int argc, char **argv)
{
    if (argc < 2) return 2;
    struct gpu_context *gpu;
    if (gpu_context_create(&gpu)) return 1;
    struct judge j;
    struct planet_file *file;
    pyramid_params tiles = {.cache_bytes = (size_t)512 << 20};
    perigee_planet *planet;
    perigee_planet_params pp = {.no_synthesis = true};
    if (planet_file_open(argv[1], &file) || pyramid_create(file, &tiles, &j.pyramid)) return 1;
    j.e = planet_file_meta(file)->ellipsoid;
    if (perigee_planet_open(argv[1], &pp, &planet)) return 1;
    gpu_target t;
    const GLenum formats[1] = {GL_RGBA8};
    if (gpu_target_init(&t, WIDTH, HEIGHT, formats, 1, 0)) return 1;
    struct frame_planes f = {malloc(PIXELS * 4), malloc(PIXELS * 4), malloc(PIXELS * 4),
                             malloc(PIXELS * 8), malloc(PIXELS * 8)};
    for (int s = 0; s < (int)(sizeof SETTINGS / sizeof *SETTINGS); s++) {
        if (argc > 3 && !strstr(SETTINGS[s].name, argv[3])) continue;
        perigee_view *view;
        perigee_view_params vp = SETTINGS[s].params;
        vp.identify = true;
        if (perigee_view_create(planet, &vp, &view)) return 1;
        for (int i = 0; i < ERROR_VIEW_COUNT; i++) {
            const struct error_view *v = &ERROR_VIEWS[i];
            if (argc > 2 && !strstr(v->name, argv[2])) continue;
            perigee_camera c = {.lat_deg = v->lat_deg,
                                .lon_deg = v->lon_deg,
                                .heading_deg = v->heading_deg,
                                .pitch_deg = v->pitch_deg,
                                .fov_deg = v->fov_deg};
            double h = 0;
            pyramid_height_at(j.pyramid, 14, c.lat_deg * M_PI / 180, c.lon_deg * M_PI / 180, &h);
            c.alt_m = v->above_m + h;
            j.zoom = v->above_m < 20 ? 18 : v->above_m < 2000 ? 15 : 12;
            if (v->above_m > 9e4 && v->fov_deg > 50) j.zoom = 10;
            glBindFramebuffer(GL_FRAMEBUFFER, t.framebuffer);
            perigee_view_set_camera(view, &c);
            if (perigee_view_wait(view, WIDTH, HEIGHT, 120)) return 1;
            perigee_view_render(view, WIDTH, HEIGHT);
            perigee_planes p = {.z_m = f.z,
                                .height_m = f.height,
                                .lat_deg = f.lat,
                                .lon_deg = f.lon,
                                .level = f.level};
            if (perigee_view_read_planes(view, &p)) return 1;
            perigee_stats st;
            perigee_view_get_stats(view, &st);
            perigee_triangles tr = {0};
            perigee_view_read_triangles(view, &tr);
            judge_frame(&j, &c, &f, &st, v->name, SETTINGS[s].name,
                        (double)tr.visible / (double)tr.ground_pixels);
        }
        perigee_view_destroy(&view);
    }
    return 0;
}
