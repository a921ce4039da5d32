#include "app/command.h"

#include <stdlib.h>

#include "app/command_reference.h"
#include "app/image_exr.h"
#include "app/image_png.h"
#include "app/output_file.h"
#include "app/session.h"
#include "app/stats_file.h"
#include "base/log.h"
#include "gpu/target.h"

enum { WIDTH = 1280, HEIGHT = 960, SAMPLES = 2 };

struct shot {
    struct session session;
    perigee_camera camera;
    int width, height, samples;
};

static void *picture_memory(const struct shot *shot, size_t bytes_per_pixel)
{
    void *memory = calloc((size_t)shot->width * (size_t)shot->height, bytes_per_pixel);
    if (!memory) log_error("--size %dx%d: out of memory", shot->width, shot->height);
    return memory;
}

static status write_png(struct shot *shot)
{
    uint8_t *rgb = picture_memory(shot, 3);
    if (!rgb) return ERR_MEMORY;
    status s = (status)perigee_view_render_image(shot->session.view, shot->width, shot->height,
                                                 shot->samples, rgb);
    char line[SESSION_CAMERA_SIZE];
    struct image_text texts[SESSION_TEXTS];
    int count = session_texts(&shot->session, &shot->camera, line, texts);
    if (!s)
        s = image_png_write(shot->session.options->output, shot->width, shot->height, rgb, texts,
                            count);
    free(rgb);
    return s;
}

static status render_to_target(struct shot *shot)
{
    const GLenum format = GL_RGBA8;
    gpu_target target;
    status s = gpu_target_init(&target, shot->width, shot->height, &format, 1, 0);
    if (s) return s;
    glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
    s = (status)perigee_view_render(shot->session.view, shot->width, shot->height);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    gpu_target_deinit(&target);
    return s;
}

static status write_exr(struct shot *shot)
{
    size_t pixels = (size_t)shot->width * (size_t)shot->height;
    float *f = picture_memory(shot, 6 * sizeof(float));
    double *d = picture_memory(shot, 2 * sizeof(double)), *coordinates = NULL;
    status s = f && d ? render_to_target(shot) : ERR_MEMORY;
    if (!s) {
        perigee_planes planes = {.r = f,
                                 .g = f + pixels,
                                 .b = f + 2 * pixels,
                                 .z_m = f + 3 * pixels,
                                 .height_m = f + 4 * pixels,
                                 .level = f + 5 * pixels,
                                 .lat_deg = d,
                                 .lon_deg = d + pixels};
        const struct options *o = shot->session.options;
        image_exr image = {.width = shot->width,
                           .height = shot->height,
                           .planes = planes,
                           .half_color = o->half,
                           .camera = session_geographic(&shot->session, &shot->camera),
                           .planet = shot->session.info.name,
                           .attribution = shot->session.info.attribution};
        s = (status)perigee_view_read_planes(shot->session.view, &planes);
        if (!s)
            s = session_tell_places(&shot->session, pixels, planes.lat_deg, planes.lon_deg,
                                    &coordinates);
        image.easting = coordinates;
        image.northing = coordinates ? coordinates + pixels : NULL;
        if (!s) s = image_exr_write(o->output, &image);
    }
    free(f);
    free(d);
    free(coordinates);
    return s;
}

static status render_shot(struct shot *shot, bool exr, struct stats_file *stats)
{
    struct session *session = &shot->session;
    status s = session_camera(session, &shot->camera);
    if (!s) s = session_open_view(session);
    if (!s) s = (status)perigee_view_set_camera(session->view, &shot->camera);
    if (s) return s;
    status waited = session_wait(session, shot->width, shot->height);
    if (waited && waited != ERR_TIMEOUT) return waited;
    s = exr ? write_exr(shot) : write_png(shot);
    if (!s) stats_file_add(stats, session, 0, 0, &shot->camera);
    return s ? s : waited;
}

static status check_output(const struct options *o, bool *exr)
{
    *exr = output_has_extension(o->output, ".exr");
    if (*exr || output_has_extension(o->output, ".png")) return output_check(o->output);
    log_error("-o %s: neither .png nor .exr", o->output);
    return ERR_ARGUMENT;
}

status command_render(const struct options *o)
{
    bool exr;
    struct stats_file stats = {0};
    struct shot shot = {.width = o->width ? o->width : WIDTH,
                        .height = o->height ? o->height : HEIGHT};
    status s = check_output(o, &exr);
    if (s) return s;
    if (o->reference) return command_reference(o, exr);
    shot.samples = exr ? 1 : o->samples ? o->samples : SAMPLES;
    s = session_open_planet(o, &shot.session);
    if (!s) s = stats_file_open(&stats, o->stats);
    if (!s) s = render_shot(&shot, exr, &stats);
    session_close(&shot.session);
    status closed = stats_file_close(&stats);
    return s ? s : closed;
}
