#include "app/command_reference.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "app/default_earth.h"
#include "app/image_exr.h"
#include "app/image_png.h"
#include "app/interrupt.h"
#include "app/output_file.h"
#include "app/progress.h"
#include "app/session.h"
#include "base/log.h"
#include "geo/sun.h"
#include "reference/reference.h"

enum { WIDTH = 1280, HEIGHT = 960, SIZE_MAX_PX = 16384, ZOOM_TEXT_SIZE = 80 };

struct trial {
    struct session session; // planet and camera only
    perigee_camera camera;
    struct planet_file *file;
    struct pyramid *pyramid;
    int width, height, samples;
    struct progress progress;
    sight_ground ground;
};

static bool report(void *user, double done)
{
    struct trial *t = user;
    progress_update(&t->progress, "reference", done);
    return interrupt_requested();
}

static status open_trial(const struct options *o, struct trial *t)
{
    char earth[OUTPUT_PATH_SIZE];
    pyramid_params tiles = {.cache_bytes = o->planet_params.cache_bytes,
                            .synthesis = !o->planet_params.no_synthesis};
    status s = session_open_planet(o, &t->session);
    if (!s) s = session_camera(&t->session, &t->camera);
    if (!s && !o->planet) s = default_earth_find(o, earth, sizeof earth);
    if (!s) s = planet_file_open(o->planet ? o->planet : earth, &t->file);
    if (!s) s = pyramid_create(t->file, &tiles, &t->pyramid);
    if (!s) session_credit(&t->session);
    return s;
}

static void close_trial(struct trial *t)
{
    pyramid_destroy(&t->pyramid);
    planet_file_close(&t->file);
    session_close(&t->session);
}

static status render(struct trial *t, const reference_planes *planes)
{
    const struct options *o = t->session.options;
    const perigee_camera *c = &t->camera;
    reference_params params = {
        .pyramid = t->pyramid,
        .camera = {c->lat_deg, c->lon_deg, c->alt_m, c->heading_deg, c->pitch_deg, c->roll_deg,
                   c->fov_deg},
        .width = t->width * t->samples,
        .height = t->height * t->samples,
        .zoom = o->zoom,
        .error_px = isnan(o->zoom_error_px) ? 0 : o->zoom_error_px,
        .ground = &t->ground,
        .threads = o->view_params.threads,
        .has_sun = o->time_given,
        .progress = {report, t},
    };
    if (o->time_given) params.sun = geo_sun_direction(o->unix_time_s);
    interrupt_catch();
    progress_start(&t->progress, stderr, o->quiet);
    status s = reference_render(&params, planes);
    progress_finish(&t->progress);
    if (s == ERR_CANCELLED) log_error("interrupted: %s is not written", o->output);
    return s;
}

// "12", or "5 to 13 by distance, within 0.02 px of the limit".
static void name_zoom(const struct trial *t, char text[ZOOM_TEXT_SIZE])
{
    const sight_ground *g = &t->ground;
    if (t->session.options->zoom != SIGHT_AUTO) snprintf(text, ZOOM_TEXT_SIZE, "%d", g->zoom_min);
    else
        snprintf(text, ZOOM_TEXT_SIZE, "%d to %d by distance, within %.2g px of the limit",
                 g->zoom_min, g->zoom_max, g->error_px);
}

static void *plane_memory(const struct trial *t, size_t bytes_per_pixel)
{
    size_t pixels = (size_t)t->width * (size_t)t->height * (size_t)t->samples * (size_t)t->samples;
    void *memory = calloc(pixels, bytes_per_pixel);
    if (!memory)
        log_error("--size %dx%d --samples %d: out of memory", t->width, t->height, t->samples);
    return memory;
}

static status write_exr(struct trial *t)
{
    const struct options *o = t->session.options;
    size_t n = (size_t)t->width * (size_t)t->height;
    float *f = plane_memory(t, 6 * sizeof *f);
    double *d = f ? plane_memory(t, 2 * sizeof *d) : NULL;
    status s = f && d ? OK : ERR_MEMORY;
    if (!s) {
        reference_planes planes = {.r = f,
                                   .g = f + n,
                                   .b = f + 2 * n,
                                   .z_m = f + 3 * n,
                                   .height_m = f + 4 * n,
                                   .lat_deg = d,
                                   .lon_deg = d + n,
                                   .level = f + 5 * n};
        char zoom[ZOOM_TEXT_SIZE];
        image_exr image = {.width = t->width,
                           .height = t->height,
                           .planes = {.r = planes.r,
                                      .g = planes.g,
                                      .b = planes.b,
                                      .z_m = planes.z_m,
                                      .height_m = planes.height_m,
                                      .lat_deg = planes.lat_deg,
                                      .lon_deg = planes.lon_deg,
                                      .level = planes.level},
                           .half_color = o->half,
                           .camera = t->camera,
                           .planet = t->session.info.name,
                           .attribution = t->session.info.attribution,
                           .zoom = zoom};
        s = render(t, &planes);
        name_zoom(t, zoom);
        if (!s) s = image_exr_write(o->output, &image);
    }
    free(f);
    free(d);
    return s;
}

static uint8_t encode(double c)
{
    c = fmin(fmax(c, 0), 1);
    c = c <= 0.0031308 ? 12.92 * c : 1.055 * pow(c, 1 / 2.4) - 0.055;
    return (uint8_t)(255 * c + 0.5);
}

// The mean of a pixel's samples in linear light.
static double mean(const struct trial *t, const float *plane, int x, int y)
{
    double sum = 0;
    size_t stride = (size_t)t->width * (size_t)t->samples;
    for (int j = 0; j < t->samples; j++)
        for (int i = 0; i < t->samples; i++)
            sum += plane[(size_t)(y * t->samples + j) * stride + (size_t)(x * t->samples + i)];
    return sum / (t->samples * t->samples);
}

static status write_png(struct trial *t)
{
    size_t n = (size_t)t->width * (size_t)t->height * (size_t)t->samples * (size_t)t->samples;
    float *light = plane_memory(t, 3 * sizeof *light);
    uint8_t *rgb = light ? plane_memory(t, 3) : NULL;
    status s = rgb ? OK : ERR_MEMORY;
    if (!s) {
        reference_planes planes = {.r = light, .g = light + n, .b = light + 2 * n};
        s = render(t, &planes);
    }
    for (int i = 0; !s && i < t->width * t->height; i++)
        for (size_t k = 0; k < 3; k++)
            rgb[3 * (size_t)i + k] = encode(mean(t, light + k * n, i % t->width, i / t->width));
    char line[SESSION_CAMERA_SIZE];
    struct image_text texts[SESSION_TEXTS];
    int count = session_texts(&t->session, &t->camera, line, texts);
    if (!s) s = image_png_write(t->session.options->output, t->width, t->height, rgb, texts, count);
    free(light);
    free(rgb);
    return s;
}

static status check_options(const struct options *o, const struct trial *t)
{
    if (o->stats) {
        log_error("--stats: not with --mode reference, which uses no GPU");
        return ERR_ARGUMENT;
    }
    if (t->width * t->samples <= SIZE_MAX_PX && t->height * t->samples <= SIZE_MAX_PX) return OK;
    log_error("--size %dx%d --samples %d: more than %d rays across", t->width, t->height,
              t->samples, SIZE_MAX_PX);
    return ERR_ARGUMENT;
}

status command_reference(const struct options *o, bool exr)
{
    struct trial t = {.width = o->width ? o->width : WIDTH,
                      .height = o->height ? o->height : HEIGHT,
                      .samples = !exr && o->samples ? o->samples : 1};
    status s = check_options(o, &t);
    if (!s) s = open_trial(o, &t);
    if (!s) s = exr ? write_exr(&t) : write_png(&t);
    close_trial(&t);
    return s;
}
