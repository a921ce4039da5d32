#include "render/scene.h"

#include <epoxy/gl.h>
#include <unistd.h>

#include "gpu/gpu_fixture.h"
#include "gpu/target.h"

#define RAD(deg) ((deg) * (3.14159265358979323846 / 180))

static const double A = 6378137.0, B = 6356752.314245179;
static gpu_target target;
static const scene_map *flat;

const scene_map scene_analytic_map = {6378137.0,
                                      RAD(-90),
                                      RAD(90),
                                      RAD(-180),
                                      RAD(180),
                                      analytic_height,
                                      -ANALYTIC_HEIGHT_MAX,
                                      ANALYTIC_HEIGHT_MAX};

void scene_set_flat(const scene_map *map)
{
    flat = map;
}

const scene_map *scene_flat(void)
{
    return flat;
}

perigee_planet *scene_planet(void)
{
    const char *path = "analytic.planet";
    FILE *f = fopen(path, "rb");
    if (f) fclose(f);
    else {
        char own[64];
        snprintf(own, sizeof own, "analytic-%d.planet", (int)getpid());
        assert_int_equal(analytic_planet_make(own, 4), 0);
        assert_int_equal(rename(own, path), 0);
    }
    perigee_planet *planet;
    perigee_planet_params params = {.no_synthesis = true, .flat = flat != NULL};
    assert_int_equal(perigee_planet_open(path, &params, &planet), 0);
    return planet;
}

perigee_view *scene_view(perigee_planet *planet, const perigee_view_params *params)
{
    perigee_view *view;
    assert_int_equal(perigee_view_create(planet, params, &view), 0);
    return view;
}

void scene_bind(int width, int height)
{
    if (target.width != width || target.height != height) {
        const GLenum format[1] = {GL_RGBA8};
        gpu_target_deinit(&target);
        assert_int_equal(gpu_target_init(&target, width, height, format, 1, 0), 0);
    }
    glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
}

void scene_render(perigee_view *view, const perigee_camera *camera, int width, int height)
{
    scene_bind(width, height);
    assert_int_equal(perigee_view_set_camera(view, camera), 0);
    assert_int_equal(perigee_view_wait(view, width, height, 60), 0);
    assert_int_equal(perigee_view_render(view, width, height), 0);
}

void scene_ray(const perigee_camera *c, int width, int height, double x_px, double y_px,
               double origin[3], double direction[3])
{
    double lat = RAD(c->lat_deg), lon = RAD(c->lon_deg), e2 = 1 - B * B / (A * A);
    double n = A / sqrt(1 - e2 * sin(lat) * sin(lat));
    origin[0] = (n + c->alt_m) * cos(lat) * cos(lon);
    origin[1] = (n + c->alt_m) * cos(lat) * sin(lon);
    origin[2] = (n * (1 - e2) + c->alt_m) * sin(lat);
    double east[3] = {-sin(lon), cos(lon), 0},
           north[3] = {-sin(lat) * cos(lon), -sin(lat) * sin(lon), cos(lat)};
    double up[3] = {cos(lat) * cos(lon), cos(lat) * sin(lon), sin(lat)};
    if (flat) {
        const double axes[4][3] = {
            {c->alt_m, flat->radius * lon, flat->radius * lat}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}};
        memcpy(origin, axes[0], sizeof axes[0]);
        memcpy(east, axes[1], sizeof east);
        memcpy(north, axes[2], sizeof north);
        memcpy(up, axes[3], sizeof up);
    }
    double h = RAD(c->heading_deg), p = RAD(c->pitch_deg),
           t = tan(RAD(c->fov_deg ? c->fov_deg : 60) / 2);
    double u = (2 * x_px / width - 1) * t * width / height, v = (1 - 2 * y_px / height) * t;
    for (int i = 0; i < 3; i++) {
        double level = sin(h) * east[i] + cos(h) * north[i],
               right = cos(h) * east[i] - sin(h) * north[i];
        double ahead = cos(p) * level + sin(p) * up[i], above = cos(p) * up[i] - sin(p) * level;
        direction[i] = ahead + u * right + v * above;
    }
}

void scene_geodetic(const double p[3], double *lat, double *lon, double *height)
{
    if (flat) {
        *lat = p[2] / flat->radius;
        *lon = p[1] / flat->radius;
        *height = p[0];
        return;
    }
    double rho = hypot(p[0], p[1]), e2 = 1 - B * B / (A * A);
    *lon = atan2(p[1], p[0]);
    *lat = atan2(p[2], rho * (1 - e2));
    for (int i = 0; i < 12; i++) {
        double s = sin(*lat), n = A / sqrt(1 - e2 * s * s);
        *lat = atan2(p[2] + e2 * n * s, rho);
    }
    double s = sin(*lat), c = cos(*lat), n = A / sqrt(1 - e2 * s * s);
    *height = rho * c + p[2] * s - A * A / n;
}

static double above_terrain(const double o[3], const double d[3], double t)
{
    double p[3], lat, lon, height;
    for (int i = 0; i < 3; i++) p[i] = o[i] + t * d[i];
    scene_geodetic(p, &lat, &lon, &height);
    if (!flat) return height - analytic_height(lat, lon);
    if (lat < flat->south || lat > flat->north || lon < flat->west || lon > flat->east) return NAN;
    return height - flat->height(lat, lon);
}

double scene_trace(const double o[3], const double d[3])
{
    double t = 0, step = 0;
    for (int i = 0; i < 20000; i++) {
        double clear = above_terrain(o, d, t + step);
        if (isnan(clear)) return NAN;
        if (clear <= 0) break;
        t += step;
        // The field's slope is below 1, so a step of half the clearance cannot cross it.
        step = fmax(0.5 * clear, 0.5);
        if (clear > 2e8 || t > 1e9) return NAN;
        if (i == 19999) return NAN;
    }
    double low = t, high = t + step;
    for (int i = 0; i < 80; i++) {
        double mid = 0.5 * (low + high);
        if (above_terrain(o, d, mid) > 0) low = mid;
        else high = mid;
    }
    return 0.5 * (low + high);
}

double scene_encoded(double light)
{
    double c = fmin(fmax(light, 0), 1);
    return 255 * (c <= 0.0031308 ? 12.92 * c : 1.055 * pow(c, 1 / 2.4) - 0.055);
}

int scene_open(void)
{
    return gpu_fixture_open();
}

int scene_close(int failed)
{
    gpu_target_deinit(&target);
    return gpu_fixture_close(failed);
}
