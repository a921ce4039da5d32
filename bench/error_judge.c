#include "bench/error_judge.h"

#include <math.h>
#include <stdlib.h>

#include "geo/camera.h"

enum { PIXELS = ERROR_WIDTH * ERROR_HEIGHT, STEP = 3 };

static const double RAD = M_PI / 180;

static double ground(const struct error_judge *j, int zoom, double lat, double lon)
{
    double h = 0;
    pyramid_height_at(j->pyramid, zoom, lat, lon, &h);
    return h;
}

static dvec3 point(const struct error_judge *j, int zoom, double lat, double lon)
{
    return geo_ecef_from_geodetic(j->e, (geodetic){lat, lon, ground(j, zoom, lat, lon)});
}

// Upper normal of the surface by differences of half a sample.
static dvec3 normal_at(const struct error_judge *j, int zoom, double lat, double lon)
{
    double step = 0.5 * M_PI / ldexp(256, zoom), wide = step / fmax(cos(lat), 1e-3);
    if (fabs(lat) > M_PI / 2 - 4 * step) return geo_normal(lat, lon);
    dvec3 north = dvec3_sub(point(j, zoom, lat + step, lon), point(j, zoom, lat - step, lon));
    dvec3 east = dvec3_sub(point(j, zoom, lat, lon + wide), point(j, zoom, lat, lon - wide));
    return dvec3_normalize(dvec3_cross(east, north));
}

perigee_camera error_camera(const struct error_judge *j, const named_view *v)
{
    perigee_camera c = v->camera;
    if (v->above_ground) c.alt_m += ground(j, 14, c.lat_deg * RAD, c.lon_deg * RAD);
    return c;
}

int error_zoom(const named_view *v)
{
    double above_m = v->camera.alt_m;
    if (above_m > 9e4 && v->camera.fov_deg > 50) return 10;
    return above_m < 20 ? 18 : above_m < 2000 ? 15 : 12;
}

struct planes {
    float *z, *height, *level;
    double *lat, *lon;
};

struct eye {
    dvec3 position; // ECEF
    dmat3 axes;     // right, up, backward
    double pixel;   // width of one at a metre along the view axis
};

static struct eye eye_of(const struct error_judge *j, const perigee_camera *c)
{
    geo_camera g = {.position = {c->lat_deg * RAD, c->lon_deg * RAD, c->alt_m},
                    .heading = c->heading_deg * RAD,
                    .pitch = c->pitch_deg * RAD,
                    .roll = c->roll_deg * RAD};
    return (struct eye){geo_ecef_from_geodetic(j->e, g.position), geo_eye_over(j->e, &g),
                        2 * tan(c->fov_deg * RAD / 2) / ERROR_HEIGHT};
}

static double pixel_error(const struct error_judge *j, int zoom, const struct eye *eye,
                          const struct planes *f, int i)
{
    double lat = f->lat[i] * RAD, lon = f->lon[i] * RAD, h = (double)f->height[i];
    dvec3 normal = normal_at(j, zoom, lat, lon);
    dvec3 ray = dvec3_sub(geo_ecef_from_geodetic(j->e, (geodetic){lat, lon, h}), eye->position);
    double above = (h - ground(j, zoom, lat, lon)) * dvec3_dot(geo_normal(lat, lon), normal);
    // The derivative of (x, y) / z along the normal, z times.
    dvec3 n = dmat3_mul(eye->axes, normal), r = dmat3_mul(eye->axes, ray);
    double across = hypot(n.x - r.x / r.z * n.z, n.y - r.y / r.z * n.z);
    return fabs(above) * across / (eye->pixel * (double)f->z[i]);
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static struct error_stat stat_of(double *errors, size_t count)
{
    struct error_stat s = {.count = count};
    if (!count) return s;
    qsort(errors, count, sizeof *errors, ascending);
    for (size_t i = 0; i < count; i++) {
        s.rms += errors[i] * errors[i];
        s.above += errors[i] > 1;
    }
    s.rms = sqrt(s.rms / (double)count);
    s.above /= (double)count;
    s.p999 = errors[(size_t)ceil(0.999 * (double)count) - 1];
    s.max = errors[count - 1];
    return s;
}

static void judge_planes(const struct error_judge *j, const perigee_camera *c, int zoom,
                         const struct planes *f, double *errors, struct error_result *out)
{
    static signed char levels[PIXELS];
    static double of_level[PIXELS];
    struct eye eye = eye_of(j, c);
    size_t n = 0;
    for (int i = 0; i < PIXELS; i++) {
        if (isnan(f->z[i])) continue;
        out->ground++;
        if (i % ERROR_WIDTH % STEP != 1 || i / ERROR_WIDTH % STEP != 1) continue;
        levels[n] = (signed char)f->level[i];
        errors[n++] = pixel_error(j, zoom, &eye, f, i);
    }
    for (int l = 0; l < ERROR_LEVELS; l++) {
        size_t count = 0;
        for (size_t i = 0; i < n; i++)
            if (levels[i] == l) of_level[count++] = errors[i];
        out->level[l] = stat_of(of_level, count);
    }
    out->all = stat_of(errors, n);
}

bool error_judge_frame(const struct error_judge *judge, perigee_view *frame,
                       const perigee_camera *camera, int zoom, struct error_result *out)
{
    struct planes f = {malloc(PIXELS * sizeof(float)), malloc(PIXELS * sizeof(float)),
                       malloc(PIXELS * sizeof(float)), malloc(PIXELS * sizeof(double)),
                       malloc(PIXELS * sizeof(double))};
    double *errors = malloc(PIXELS * sizeof(double));
    perigee_planes p = {
        .z_m = f.z, .height_m = f.height, .lat_deg = f.lat, .lon_deg = f.lon, .level = f.level};
    *out = (struct error_result){0};
    bool read = f.z && f.height && f.level && f.lat && f.lon && errors &&
                !perigee_view_read_planes(frame, &p);
    if (read) judge_planes(judge, camera, zoom, &f, errors, out);
    free(f.z);
    free(f.height);
    free(f.level);
    free(f.lat);
    free(f.lon);
    free(errors);
    return read;
}
