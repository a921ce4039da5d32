#include "app/reference_picture.h"

#include <math.h>
#include <stdlib.h>

#include "app/default_earth.h"
#include "app/output_file.h"
#include "base/log.h"
#include "geo/sun.h"
#include "planet/source_set.h"

enum { SIZE_MAX_PX = 16384 };

status reference_source_init(struct reference_source *s, const struct options *o)
{
    *s = (struct reference_source){.options = o};
    char earth[OUTPUT_PATH_SIZE];
    pyramid_params tiles = {.cache_bytes = o->planet_params.cache_bytes,
                            .synthesis = o->planet_params.no_synthesis      ? SYNTHESIS_NONE
                                         : o->planet_params.plain_synthesis ? SYNTHESIS_PLAIN
                                                                            : SYNTHESIS_ERODED};
    s->set = source_set_create(&(source_set_params){.flat = o->planet_params.flat});
    status failed = o->planet ? OK : default_earth_find(o, earth, sizeof earth);
    if (!failed) failed = source_set_add(s->set, o->planet ? o->planet : earth, LAYER_COUNT, 1);
    if (!failed) failed = source_set_pyramid(s->set, &tiles, &s->pyramid);
    return failed;
}

void reference_source_deinit(struct reference_source *s)
{
    pyramid_destroy(&s->pyramid);
    source_set_destroy(&s->set);
}

status reference_source_check(const struct reference_source *s, const perigee_camera *camera,
                              const double *lat_deg, const double *lon_deg, size_t pixels)
{
    bool ground = false, known = false;
    for (size_t i = 0; i < pixels; i++) ground |= isfinite(lat_deg[i]) != 0;
    if (!ground || pyramid_meta(s->pyramid)->max_zoom[LAYER_HEIGHT] < 0) return OK;
    status failed = pyramid_knows_any(s->pyramid, lat_deg, lon_deg, pixels, &known);
    if (failed || known) return failed;
    log_error("%s: holds no heights that the camera over %.6f, %.6f can see; the reference has "
              "nothing to "
              "judge by there",
              s->options->planet ? s->options->planet : pyramid_meta(s->pyramid)->name,
              camera->lat_deg, camera->lon_deg);
    return ERR_ARGUMENT;
}

// On a plane as it stands over the camera.
static dvec3 sun_over(const struct reference_source *s, const perigee_camera *c, dvec3 sun)
{
    double lat_deg = c->lat_deg, lon_deg = c->lon_deg;
    if (!s->options->planet_params.flat) return sun;
    if (source_set_map(s->set))
        plane_map_to_geographic(source_set_map(s->set), 1, &lat_deg, &lon_deg);
    dmat3 ecef_from_enu = geo_ecef_from_enu(lat_deg * (M_PI / 180), lon_deg * (M_PI / 180));
    dvec3 enu = dmat3_mul(dmat3_transpose(ecef_from_enu), sun);
    return (dvec3){enu.z, enu.x, enu.y};
}

reference_params reference_source_params(const struct reference_source *s, const perigee_camera *c,
                                         int width, int height)
{
    const struct options *o = s->options;
    reference_params params = {
        .pyramid = s->pyramid,
        .camera = {c->lat_deg, c->lon_deg, c->alt_m, c->heading_deg, c->pitch_deg, c->roll_deg,
                   c->fov_deg},
        .width = width,
        .height = height,
        .zoom = o->zoom,
        .error_px = isnan(o->zoom_error_px) ? 0 : o->zoom_error_px,
        .bicubic = o->bicubic,
        .threads = o->view_params.threads,
        .has_sun = o->time_given,
    };
    if (o->time_given) params.sun = sun_over(s, c, geo_sun_direction(o->unix_time_s));
    return params;
}

static uint8_t encode(double c)
{
    c = fmin(fmax(c, 0), 1);
    c = c <= 0.0031308 ? 12.92 * c : 1.055 * pow(c, 1 / 2.4) - 0.055;
    return (uint8_t)(255 * c + 0.5);
}

double reference_picture_mean(const float *plane, int width, int samples, int x, int y)
{
    double sum = 0;
    size_t stride = (size_t)width * (size_t)samples;
    for (int j = 0; j < samples; j++)
        for (int i = 0; i < samples; i++)
            sum += plane[(size_t)(y * samples + j) * stride + (size_t)(x * samples + i)];
    return sum / (samples * samples);
}

status reference_picture(const reference_params *params, int samples, uint8_t *rgb)
{
    int width = params->width, height = params->height;
    reference_params fine = *params;
    fine.width *= samples;
    fine.height *= samples;
    size_t n = (size_t)fine.width * (size_t)fine.height;
    float *light = calloc(3 * n, sizeof *light);
    if (!light) {
        log_error("--size %dx%d --samples %d: out of memory", width, height, samples);
        return ERR_MEMORY;
    }
    reference_planes planes = {.r = light, .g = light + n, .b = light + 2 * n};
    status s = reference_render(&fine, &planes);
    for (int i = 0; !s && i < width * height; i++)
        for (size_t k = 0; k < 3; k++)
            rgb[3 * (size_t)i + k] =
                encode(reference_picture_mean(light + k * n, width, samples, i % width, i / width));
    free(light);
    return s;
}

status reference_check_options(const struct options *o, int width, int height, int samples)
{
    if (o->stats) {
        log_error("--stats: not with --mode reference, which uses no GPU");
        return ERR_ARGUMENT;
    }
    if (width * samples <= SIZE_MAX_PX && height * samples <= SIZE_MAX_PX) return OK;
    log_error("--size %dx%d --samples %d: more than %d rays across", width, height, samples,
              SIZE_MAX_PX);
    return ERR_ARGUMENT;
}
