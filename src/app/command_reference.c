#include "app/command_reference.h"

#include <stdio.h>
#include <stdlib.h>

#include "app/image_exr.h"
#include "app/image_png.h"
#include "app/interrupt.h"
#include "app/output_file.h"
#include "app/progress.h"
#include "app/reference_picture.h"
#include "app/session.h"
#include "base/log.h"

enum { WIDTH = 1280, HEIGHT = 960, ZOOM_TEXT_SIZE = 80 };

struct trial {
    struct session session; // planet and camera only
    perigee_camera camera;
    struct reference_source source;
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
    status s = session_open_planet(o, &t->session);
    if (!s) s = session_camera(&t->session, &t->camera);
    if (!s) s = reference_source_init(&t->source, o);
    if (!s) session_credit(&t->session);
    return s;
}

static void close_trial(struct trial *t)
{
    reference_source_deinit(&t->source);
    session_close(&t->session);
}

static reference_params params_of(struct trial *t)
{
    reference_params params = reference_source_params(&t->source, &t->camera, t->width, t->height);
    params.progress = (reference_progress){report, t};
    params.ground = &t->ground;
    interrupt_catch();
    progress_start(&t->progress, stderr, t->session.options->quiet);
    return params;
}

// "12", or "5 to 13 by distance, within 0.02 px of the limit"; then ", bicubic" where they are.
static void name_zoom(const struct trial *t, char text[ZOOM_TEXT_SIZE])
{
    const sight_ground *g = &t->ground;
    const char *between = t->session.options->bicubic ? ", bicubic" : "";
    if (t->session.options->zoom != SIGHT_AUTO)
        snprintf(text, ZOOM_TEXT_SIZE, "%d%s", g->zoom_min, between);
    else
        snprintf(text, ZOOM_TEXT_SIZE, "%d to %d by distance, within %.2g px of the limit%s",
                 g->zoom_min, g->zoom_max, g->error_px, between);
}

static status finish(struct trial *t, status s)
{
    progress_finish(&t->progress);
    if (s == ERR_CANCELLED) log_error("interrupted: %s is not written", t->session.options->output);
    char zoom[ZOOM_TEXT_SIZE];
    name_zoom(t, zoom);
    if (!s) log_info("reference: heights of zoom %s", zoom);
    return s;
}

static void *plane_memory(const struct trial *t, size_t bytes_per_pixel)
{
    void *memory = calloc((size_t)t->width * (size_t)t->height, bytes_per_pixel);
    if (!memory) log_error("--size %dx%d: out of memory", t->width, t->height);
    return memory;
}

static status write_exr(struct trial *t)
{
    const struct options *o = t->session.options;
    size_t n = (size_t)t->width * (size_t)t->height;
    float *f = plane_memory(t, 9 * sizeof *f);
    double *d = f ? plane_memory(t, 2 * sizeof *d) : NULL, *coordinates = NULL;
    status s = f && d ? OK : ERR_MEMORY;
    if (!s) {
        reference_planes planes = {.r = f,
                                   .g = f + n,
                                   .b = f + 2 * n,
                                   .z_m = f + 3 * n,
                                   .height_m = f + 4 * n,
                                   .lat_deg = d,
                                   .lon_deg = d + n,
                                   .level = f + 5 * n,
                                   .nx = f + 6 * n,
                                   .ny = f + 7 * n,
                                   .nz = f + 8 * n};
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
                           .camera = session_geographic(&t->session, &t->camera),
                           .planet = t->session.info.name,
                           .attribution = t->session.info.attribution,
                           .zoom = zoom,
                           .normals = {planes.nx, planes.ny, planes.nz}};
        reference_params params = params_of(t);
        s = finish(t, reference_render(&params, &planes));
        name_zoom(t, zoom);
        if (!s)
            s = session_tell_places(&t->session, n, planes.lat_deg, planes.lon_deg, &coordinates);
        image.easting = coordinates;
        image.northing = coordinates ? coordinates + n : NULL;
        if (!s) s = image_exr_write(o->output, &image);
    }
    free(f);
    free(d);
    free(coordinates);
    return s;
}

static status write_png(struct trial *t)
{
    uint8_t *rgb = plane_memory(t, 3);
    if (!rgb) return ERR_MEMORY;
    reference_params params = params_of(t);
    status s = finish(t, reference_picture(&params, t->samples, rgb));
    char line[SESSION_CAMERA_SIZE];
    struct image_text texts[SESSION_TEXTS];
    int count = session_texts(&t->session, &t->camera, line, texts);
    if (!s) s = image_png_write(t->session.options->output, t->width, t->height, rgb, texts, count);
    free(rgb);
    return s;
}

status command_reference(const struct options *o, bool exr)
{
    struct trial t = {.width = o->width ? o->width : WIDTH,
                      .height = o->height ? o->height : HEIGHT,
                      .samples = !exr && o->samples ? o->samples : 1};
    status s = reference_check_options(o, t.width, t.height, t.samples);
    if (!s) s = open_trial(o, &t);
    if (!s) s = exr ? write_exr(&t) : write_png(&t);
    close_trial(&t);
    return s;
}
