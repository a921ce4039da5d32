#include "app/compare_side.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "app/interrupt.h"
#include "app/option_values.h"
#include "app/output_file.h"
#include "base/log.h"
#include "gpu/target.h"

status compare_side_open(const char *name, struct compare_side *out)
{
    *out = (struct compare_side){.name = name, .mode = option_mode_find(name)};
    if (out->mode >= 0) return OK;
    if (output_has_extension(name, ".exr")) return image_exr_read(name, &out->picture);
    char names[128];
    log_error("%s: neither a mode (%s, reference) nor an .exr file", name,
              option_mode_names(names, sizeof names));
    return ERR_ARGUMENT;
}

void compare_side_close(struct compare_side *side)
{
    if (side->view) perigee_view_destroy(&side->view);
    image_exr_file_deinit(&side->picture);
}

static bool is_view(const struct compare_side *side)
{
    return side->mode >= 0 && side->mode != MODE_REFERENCE;
}

status compare_side_view(struct compare_side *side, const struct compare_stage *stage,
                         const perigee_view_params *params)
{
    perigee_view_params own = *params;
    own.mode = (enum perigee_mode)side->mode;
    own.no_sky_glow = true; // the reference has no air
    if (side->view) perigee_view_destroy(&side->view);
    return (status)perigee_view_create(stage->session.planet, &own, &side->view);
}

static status open_views(struct compare_stage *stage, struct compare_side *sides, int count)
{
    status s = OK;
    for (int i = 0; i < count && !s; i++) {
        if (!is_view(&sides[i])) continue;
        if (!stage->session.gpu) s = session_open_gpu(&stage->session);
        if (!s) s = compare_side_view(&sides[i], stage, &stage->options.view_params);
        if (s) return s;
        perigee_stats stats;
        perigee_view_get_stats(sides[i].view, &stats);
        log_info("GPU memory of %s: %.1f MiB for terrain and geometry", sides[i].name,
                 (double)stats.gpu_bytes / 0x1p20);
    }
    return s;
}

status compare_stage_open(struct compare_stage *stage, struct compare_side *sides, int count)
{
    bool planet = false, reference = false;
    for (int i = 0; i < count; i++) {
        planet = planet || sides[i].mode >= 0;
        reference = reference || sides[i].mode == MODE_REFERENCE;
    }
    if (!planet) return OK;
    status s = session_open_planet(&stage->options, &stage->session);
    if (s) return s;
    session_credit(&stage->session);
    s = open_views(stage, sides, count);
    return s || !reference ? s : reference_source_init(&stage->source, &stage->options);
}

void compare_stage_close(struct compare_stage *stage)
{
    reference_source_deinit(&stage->source);
    session_close(&stage->session);
}

// All planes of a picture of the stage's size, once.
static status take_memory(const struct compare_stage *stage, image_exr_file *p)
{
    size_t pixels = (size_t)stage->width * (size_t)stage->height;
    float **const floats[] = {&p->r,          &p->g,          &p->b,
                              &p->z_m,        &p->height_m,   &p->level,
                              &p->normals[0], &p->normals[1], &p->normals[2]};
    if (p->z_m) return OK;
    bool all = true;
    for (size_t i = 0; i < sizeof floats / sizeof floats[0]; i++) {
        *floats[i] = calloc(pixels, sizeof(float));
        all = all && *floats[i];
    }
    p->lat_deg = calloc(pixels, sizeof(double));
    p->lon_deg = calloc(pixels, sizeof(double));
    p->width = stage->width;
    p->height = stage->height;
    if (all && p->lat_deg && p->lon_deg) return OK;
    log_error("--size %dx%d: out of memory", stage->width, stage->height);
    return ERR_MEMORY;
}

// planes NULL: the frame is finished, not read.
static status render_view(const struct compare_side *side, const struct compare_stage *stage,
                          const perigee_camera *camera, int width, int height,
                          perigee_planes *planes)
{
    const GLenum format = GL_RGBA8;
    const struct options *o = &stage->options;
    gpu_target target;
    status s = (status)perigee_view_set_camera(side->view, camera);
    if (!s && o->time_given) s = (status)perigee_view_set_time(side->view, o->unix_time_s);
    if (!s) s = (status)perigee_view_wait(side->view, width, height, o->timeout_s);
    if (!s) s = gpu_target_init(&target, width, height, &format, 1, 0);
    if (s) return s;
    glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
    s = (status)perigee_view_render(side->view, width, height);
    if (!s && planes) s = (status)perigee_view_read_planes(side->view, planes);
    else glFinish();
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    gpu_target_deinit(&target);
    return s;
}

status compare_side_frame(const struct compare_side *side, const struct compare_stage *stage,
                          const perigee_camera *camera)
{
    return render_view(side, stage, camera, stage->width, stage->height, NULL);
}

static bool report(void *user, double done)
{
    struct compare_stage *stage = user;
    progress_update(&stage->progress, "compare", stage->done + stage->share * done);
    return interrupt_requested();
}

static status render_reference(struct compare_stage *stage, const perigee_camera *c, int width,
                               int height, const reference_planes *planes)
{
    reference_params params = reference_source_params(&stage->source, c, width, height);
    params.progress = (reference_progress){report, stage};
    return reference_render(&params, planes);
}

// Everything, by the pixels' centres.
static status render_centres(const struct compare_side *side, struct compare_stage *stage,
                             const perigee_camera *camera)
{
    const image_exr_file *p = &side->picture;
    if (is_view(side)) {
        perigee_planes planes = {.r = p->r,
                                 .g = p->g,
                                 .b = p->b,
                                 .z_m = p->z_m,
                                 .height_m = p->height_m,
                                 .lat_deg = p->lat_deg,
                                 .lon_deg = p->lon_deg,
                                 .level = p->level};
        return render_view(side, stage, camera, stage->width, stage->height, &planes);
    }
    const reference_planes planes = {.r = p->r,
                                     .g = p->g,
                                     .b = p->b,
                                     .z_m = p->z_m,
                                     .height_m = p->height_m,
                                     .lat_deg = p->lat_deg,
                                     .lon_deg = p->lon_deg,
                                     .level = p->level,
                                     .nx = p->normals[0],
                                     .ny = p->normals[1],
                                     .nz = p->normals[2]};
    status s = render_reference(stage, camera, stage->width, stage->height, &planes);
    size_t pixels = (size_t)stage->width * (size_t)stage->height;
    return s ? s : reference_source_check(&stage->source, camera, p->lat_deg, p->lon_deg, pixels);
}

// Colours once more, of a picture as many times as large, whose means replace the centres'.
static status render_colors(const struct compare_side *side, struct compare_stage *stage,
                            const perigee_camera *camera)
{
    int samples = stage->samples, width = stage->width * samples, height = stage->height * samples;
    size_t n = (size_t)width * (size_t)height;
    float *light = calloc(n, 3 * sizeof *light);
    if (!light) {
        log_error("--size %dx%d --samples %d: out of memory", stage->width, stage->height, samples);
        return ERR_MEMORY;
    }
    perigee_planes seen = {.r = light, .g = light + n, .b = light + 2 * n};
    const reference_planes cast = {.r = light, .g = light + n, .b = light + 2 * n};
    status s = is_view(side) ? render_view(side, stage, camera, width, height, &seen)
                             : render_reference(stage, camera, width, height, &cast);
    float *const planes[] = {side->picture.r, side->picture.g, side->picture.b};
    for (size_t k = 0; k < 3 && !s; k++)
        for (int i = 0; i < stage->width * stage->height; i++)
            planes[k][i] = (float)reference_picture_mean(light + k * n, stage->width, samples,
                                                         i % stage->width, i / stage->width);
    free(light);
    return s;
}

status compare_side_render(struct compare_side *side, struct compare_stage *stage,
                           const perigee_camera *camera)
{
    if (side->mode < 0) return OK;
    if (report(stage, 0)) return ERR_CANCELLED;
    status s = take_memory(stage, &side->picture);
    double share = stage->share, rays = 1 + stage->samples * stage->samples;
    if (stage->samples > 1) stage->share = share / rays;
    if (!s) s = render_centres(side, stage, camera);
    for (int i = 0; i < 3 && is_view(side); i++) { // a view knows no normals of its own
        free(side->picture.normals[i]);
        side->picture.normals[i] = NULL;
    }
    if (s || stage->samples == 1) return s;
    stage->done += stage->share;
    stage->share = share - stage->share;
    return render_colors(side, stage, camera);
}

compare_picture compare_side_planes(const struct compare_side *side)
{
    const image_exr_file *p = &side->picture;
    return (compare_picture){.z_m = p->z_m,
                             .lat_deg = p->lat_deg,
                             .lon_deg = p->lon_deg,
                             .r = p->r,
                             .g = p->g,
                             .b = p->b,
                             .nx = p->normals[0],
                             .ny = p->normals[1],
                             .nz = p->normals[2]};
}

status compare_side_judge(const struct compare_side *a, const struct compare_side *b,
                          const struct compare_stage *stage, const perigee_camera *camera,
                          const compare_maps *maps, compare_result *out)
{
    compare_params params = {
        // No measure depends on its size: only directions are taken.
        .ellipsoid = stage->options.planet_params.flat ? geo_plane_of(GEO_WGS84) : GEO_WGS84,
        .camera = {camera->lat_deg, camera->lon_deg, camera->alt_m, camera->heading_deg,
                   camera->pitch_deg, camera->roll_deg, camera->fov_deg},
        .width = stage->width,
        .height = stage->height,
        .a = compare_side_planes(a),
        .b = compare_side_planes(b)};
    return compare_pictures(&params, maps, out);
}

void compare_side_tell(const struct compare_side *judge, const struct compare_stage *stage,
                       compare_row *row)
{
    compare_result *r = &row->result;
    compare_stat *const stats[] = {&r->geometric_px, &r->geometric_all_px, &r->distance_px,
                                   &r->depth_m,      &r->depth_relative,   &r->limb_px,
                                   &r->ridge_px};
    const struct session *session = &stage->session;
    if (!session_map_coordinates(session, &row->camera, &row->easting, &row->northing)) return;
    row->camera = session_geographic(session, &row->camera);
    for (size_t i = 0; judge->mode >= 0 && i < sizeof stats / sizeof stats[0]; i++)
        perigee_planet_geographic(session->planet, 1, &stats[i]->lat_deg, &stats[i]->lon_deg);
}

void compare_side_zooms(const struct compare_side *side, double *low, double *high)
{
    const float *level = side->mode == MODE_REFERENCE ? side->picture.level : NULL;
    size_t pixels = (size_t)side->picture.width * (size_t)side->picture.height;
    *low = *high = NAN;
    for (size_t i = 0; level && i < pixels; i++) {
        if (level[i] < 0) continue;
        *low = fmin(*low, level[i]);
        *high = fmax(*high, level[i]);
    }
}
