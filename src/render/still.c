// Pictures and per-pixel truth read back from the GPU: stills, EXR planes, picking.
#include <math.h>
#include <stdlib.h>

#include "base/log.h"
#include "render/view.h"

#define DEG(rad) ((rad) * (180 / M_PI))

// Encoded 8-bit sRGB of linear light, with the resolve shader's dither (a function of the pixel
// alone).
static uint8_t encode(float c, int x, int y)
{
    c = c < 0 ? 0 : c > 1 ? 1 : c;
    float e = c <= 0.0031308f ? 12.92f * c : 1.055f * powf(c, 1 / 2.4f) - 0.055f;
    uint32_t h = (uint32_t)x * 0x9E3779B1u ^ (uint32_t)y * 0x85EBCA77u;
    h = (h ^ (h >> 15)) * 0x2C1B3C6Du;
    h = (h ^ (h >> 12)) * 0x297A2D39u;
    float dither = (float)((h ^ (h >> 15)) >> 8) * 0x1p-24f - 0.5f;
    float v = e * 255 + dither + 0.5f;
    return (uint8_t)(v < 0 ? 0 : v > 255 ? 255 : v);
}

static status image_supersampled(perigee_view *v, int width, int height, int samples, uint8_t *rgb)
{
    size_t n = (size_t)width * (size_t)height;
    float *one = malloc(n * 4 * sizeof *one), *sum = calloc(n * 3, sizeof *sum);
    status s = one && sum ? view_prepare(v, width, height) : ERR_MEMORY;
    if (s == ERR_MEMORY) log_error("no memory for a picture of %d x %d", width, height);
    float weight = 1.0f / (float)(samples * samples);
    for (int i = 0; !s && i < samples * samples; i++) {
        view_draw(v, (i % samples + 0.5) / samples - 0.5, (i / samples + 0.5) / samples - 0.5);
        gpu_target_read(&v->frame.light, v->frame.light.colors[0], GL_RGBA, GL_FLOAT, 16, one);
        for (size_t k = 0; k < n; k++)
            for (int c = 0; c < 3; c++) sum[3 * k + (size_t)c] += weight * one[4 * k + (size_t)c];
    }
    if (!s)
        for (size_t k = 0; k < 3 * n; k++)
            rgb[k] = encode(sum[k], (int)(k / 3 % (size_t)width),
                            height - 1 - (int)(k / 3 / (size_t)width));
    free(one);
    free(sum);
    v->dirty = true; // the light target holds a jittered picture
    return s;
}

static status image_single(perigee_view *v, int width, int height, uint8_t *rgb)
{
    gpu_target t;
    const GLenum formats[1] = {GL_RGBA8};
    status s = view_prepare(v, width, height);
    if (!s) s = gpu_target_init(&t, width, height, formats, 1, 0);
    if (s) return s;
    view_draw(v, 0, 0);
    frame_resolve(&v->frame, t.framebuffer, !v->params.no_antialias);
    gpu_target_read(&t, t.colors[0], GL_RGB, GL_UNSIGNED_BYTE, 3, rgb);
    gpu_target_deinit(&t);
    return OK;
}

perigee_status perigee_view_render_image(perigee_view *v, int width, int height, int samples,
                                         uint8_t *rgb)
{
    if (samples < 1 || samples > 8) {
        log_error("impossible number of samples a side: %d (1 to 8)", samples);
        return ERR_ARGUMENT;
    }
    struct frame_state state;
    frame_state_save(&state);
    status s = view_prepare(v, width, height);
    if (!s) {
        view_stream(v);
        v->stats.vertices_placed = v->stats.draws = 0;
        s = samples == 1 ? image_single(v, width, height, rgb)
                         : image_supersampled(v, width, height, samples, rgb);
    }
    view_count_frame(v);
    frame_state_restore(&state);
    return (perigee_status)s;
}

static void write_light(const perigee_view *v, const float *rgba, perigee_planes *planes)
{
    size_t n = (size_t)v->frame.light.width * (size_t)v->frame.light.height;
    for (size_t k = 0; k < n; k++) {
        if (planes->r) planes->r[k] = rgba[4 * k];
        if (planes->g) planes->g[k] = rgba[4 * k + 1];
        if (planes->b) planes->b[k] = rgba[4 * k + 2];
    }
}

// Geodetic point at a pixel of the last frame, from its depth.
static geodetic point_at(const perigee_view *v, double x_px, double y_px, double z)
{
    const projection *p = &v->projection;
    dvec3 m = projection_unproject(p, x_px, y_px, z);
    dvec3 ecef =
        dvec3_add(p->camera_ecef, dmat3_mul(dmat3_transpose(p->focus.meridian_from_ecef), m));
    return geo_geodetic_from_ecef(p->ellipsoid, ecef);
}

static double level_at(const perigee_view *v, geodetic g)
{
    const projection *p = &v->projection;
    if (geo_is_plane(p->ellipsoid)) {
        double distance = hypot(g.lat - p->focus.lat, g.lon - p->focus.lon);
        return fmin(ring_level_of_angle(ring_plane_angle(distance)), v->last + 1.0);
    }
    double b = geo_reduced_from_geodetic(p->ellipsoid, g.lat), db = b - p->focus.reduced,
           dl = g.lon - p->focus.lon;
    double s = sin(db / 2), t = sin(dl / 2);
    double angle = 2 * asin(sqrt(fmin(1, s * s + cos(b) * p->focus.cb * t * t)));
    return fmin(ring_level_of_angle(angle), v->last + 1.0);
}

static void write_points(const perigee_view *v, const float *depth, perigee_planes *planes)
{
    int width = v->frame.light.width, height = v->frame.light.height;
    for (int y = 0; y < height; y++) {
        for (int x = 0; x < width; x++) {
            size_t k = (size_t)y * (size_t)width + (size_t)x;
            bool sky = !(depth[k] > 0);
            double z = sky ? NAN : PROJECTION_NEAR_M / (double)depth[k];
            geodetic g = sky ? (geodetic){NAN, NAN, NAN} : point_at(v, x + 0.5, y + 0.5, z);
            if (planes->z_m) planes->z_m[k] = (float)z;
            if (planes->height_m) planes->height_m[k] = (float)g.height;
            if (planes->lat_deg) planes->lat_deg[k] = DEG(g.lat);
            if (planes->lon_deg) planes->lon_deg[k] = DEG(g.lon);
            if (planes->level) planes->level[k] = sky ? -1 : (float)level_at(v, g);
        }
    }
}

perigee_status perigee_view_read_planes(perigee_view *v, perigee_planes *planes)
{
    const frame *f = &v->frame;
    size_t n = (size_t)f->light.width * (size_t)f->light.height;
    if (!n) {
        log_error("no frame has been rendered yet");
        return ERR_NOT_FOUND;
    }
    float *rgba = malloc(n * 4 * sizeof *rgba), *depth = malloc(n * sizeof *depth);
    status s = rgba && depth ? OK : ERR_MEMORY;
    if (s) log_error("no memory to read a frame of %d x %d", f->light.width, f->light.height);
    if (!s) {
        gpu_target_read(&f->light, f->light.colors[0], GL_RGBA, GL_FLOAT, 16, rgba);
        gpu_target_read(&f->geometry, f->geometry.depth, GL_DEPTH_COMPONENT, GL_FLOAT, 4, depth);
        write_light(v, rgba, planes);
        write_points(v, depth, planes);
    }
    free(rgba);
    free(depth);
    return (perigee_status)s;
}

perigee_status perigee_view_pick(perigee_view *v, double x_px, double y_px, double *lat_deg,
                                 double *lon_deg, double *height_m)
{
    const frame *f = &v->frame;
    bool inside = x_px >= 0 && y_px >= 0 && x_px < f->light.width && y_px < f->light.height;
    if (!inside) return ERR_NOT_FOUND;
    int x = (int)x_px, y = (int)y_px;
    float depth = 0;
    glGetTextureSubImage(f->geometry.depth, 0, x, f->geometry.height - 1 - y, 0, 1, 1, 1,
                         GL_DEPTH_COMPONENT, GL_FLOAT, sizeof depth, &depth);
    if (!(depth > 0)) return ERR_NOT_FOUND;
    geodetic g = point_at(v, x_px, y_px, PROJECTION_NEAR_M / (double)depth);
    *lat_deg = DEG(g.lat);
    *lon_deg = DEG(g.lon);
    *height_m = g.height;
    return OK;
}
