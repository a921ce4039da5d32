// One frame: move the windows, upload what has come, place what is visible and stale, draw, shade,
// resolve. A frame in which nothing changed only resolves.
#include "render/view.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/memory.h"
#include "geo/sun.h"
#include "gpu/context.h"
#include "render/params.h"

#define RAD(deg) ((deg) * (M_PI / 180))

enum { MAX_SIZE = 16384 };

static double clock_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static status create_parts(perigee_view *v)
{
    geo_ellipsoid body = pyramid_meta(v->planet->pyramid)->ellipsoid;
    char defines[256];
    v->pool = pool_create(v->params.threads, 256);
    windows_params w = {.pyramid = v->planet->pyramid,
                        .pool = v->pool,
                        .levels = v->params.levels,
                        .texels = v->params.texels,
                        .derive = v->params.gpu_synthesis,
                        .fleeting = v->params.planar_memory_free,
                        .residuals = v->params.planar_residuals,
                        .upload_bytes_frame = v->params.upload_bytes_frame,
                        .update_samples_frame = v->params.update_samples_frame};
    status s = windows_create(&w, &v->windows);
    if (s) return s;
    windows_fill_coarsest(v->windows, 5);
    snprintf(defines, sizeof defines, "#define TRANSFORM %d\n%s%s%s%s%s%s",
             (int)v->params.transform, windows_defines(v->windows),
             v->params.filter == PERIGEE_FILTER_SHARP ? "#define SHARP_HEIGHTS 1\n" : "",
             v->params.filter == PERIGEE_FILTER_HARDWARE ? "#define HARDWARE_FILTER 1\n" : "",
             v->params.texcoord_vertex ? "#define TEXCOORD_VERTEX 1\n" : "",
             v->params.seam_uncorrected ? "#define SEAM_UNCORRECTED 1\n" : "",
             v->params.identify ? "#define IDENTIFY 1\n" : "");
    geometry_params g = {
        .view = &v->params, .windows = v->windows, .body = body, .defines = defines};
    v->scout = scout_create(v->planet->pyramid, v->pool);
    s = geometry_create(v->params.mode, &g, &v->geometry);
    if (!s) s = frame_init(&v->frame, defines, v->params.texcoord_vertex, v->params.identify);
    return s;
}

perigee_status perigee_view_create(perigee_planet *planet, const perigee_view_params *params,
                                   perigee_view **out)
{
    *out = NULL;
    perigee_view *v = NEW(perigee_view);
    v->planet = planet;
    if (params) v->params = *params;
    v->camera = (geo_camera){.position = {.height = 2e7}, .pitch = -M_PI / 2, .fov_y = RAD(60)};
    v->dirty = v->placed_dirty = true;
    v->clock_s = clock_s();
    status s = params_complete(&v->params);
    if (!s) s = gpu_context_check();
    if (s) {
        free(v);
        return (perigee_status)s;
    }
    struct frame_state state;
    frame_state_save(&state);
    s = create_parts(v);
    frame_state_restore(&state);
    v->timer = gpu_timer_create();
    if (s) perigee_view_destroy(&v);
    else
        v->stats.gpu_bytes =
            windows_gpu_bytes(v->windows) + v->geometry->mode->gpu_bytes(v->geometry);
    *out = v;
    return (perigee_status)s;
}

void perigee_view_destroy(perigee_view **view)
{
    perigee_view *v = *view;
    if (!v) return;
    scout_destroy(&v->scout);
    windows_destroy(&v->windows);
    geometry_destroy(&v->geometry);
    frame_deinit(&v->frame);
    gpu_timer_destroy(&v->timer);
    pool_destroy(&v->pool);
    free(v);
    *view = NULL;
}

static status camera_error(const char *what, double value)
{
    log_error("impossible camera: %s %g", what, value);
    return ERR_ARGUMENT;
}

static status check_camera(const perigee_view *v, const perigee_camera *c)
{
    const struct planet_meta *m = pyramid_meta(v->planet->pyramid);
    double low = v->geometry->mode->outside ? m->height_min : -m->ellipsoid.b / 2;
    if (!(fabs(c->lat_deg) <= 90)) return camera_error("latitude", c->lat_deg);
    if (!isfinite(c->lon_deg)) return camera_error("longitude", c->lon_deg);
    if (!(c->alt_m >= low && c->alt_m <= 1e12)) return camera_error("altitude in metres", c->alt_m);
    if (!isfinite(c->heading_deg)) return camera_error("heading", c->heading_deg);
    if (!isfinite(c->pitch_deg)) return camera_error("pitch", c->pitch_deg);
    if (!isfinite(c->roll_deg)) return camera_error("roll", c->roll_deg);
    if (!(c->fov_deg == 0 || (c->fov_deg >= 0.01 && c->fov_deg <= 179)))
        return camera_error("field of view in degrees", c->fov_deg);
    return OK;
}

perigee_status perigee_view_set_camera(perigee_view *v, const perigee_camera *c)
{
    status s = check_camera(v, c);
    if (s) return (perigee_status)s;
    geo_camera n = {.position = {RAD(c->lat_deg), geo_wrap_lon(RAD(c->lon_deg)), c->alt_m},
                    .heading = RAD(c->heading_deg),
                    .pitch = RAD(c->pitch_deg),
                    .roll = RAD(c->roll_deg),
                    .fov_y = RAD(c->fov_deg > 0 ? c->fov_deg : 60)};
    bool moved = memcmp(&n.position, &v->camera.position, sizeof n.position) != 0;
    if (memcmp(&n, &v->camera, sizeof n)) v->dirty = true;
    if (moved) v->placed_dirty = true;
    v->camera = n;
    return OK;
}

static void set_sun(perigee_view *v, dvec3 direction)
{
    v->dirty |= !v->has_sun || memcmp(&direction, &v->sun, sizeof direction);
    v->has_sun = true;
    v->sun = direction;
}

perigee_status perigee_view_set_time(perigee_view *v, double unix_time_s)
{
    if (!isfinite(unix_time_s)) {
        log_error("impossible time: %g", unix_time_s);
        return ERR_ARGUMENT;
    }
    set_sun(v, geo_sun_direction(unix_time_s));
    return OK;
}

perigee_status perigee_view_set_sun(perigee_view *v, const double direction[3])
{
    dvec3 d = {direction[0], direction[1], direction[2]};
    double length = dvec3_length(d);
    if (!(length > 0 && isfinite(length))) {
        log_error("impossible direction of the sun: %g %g %g", d.x, d.y, d.z);
        return ERR_ARGUMENT;
    }
    set_sun(v, dvec3_scale(d, 1 / length));
    return OK;
}

void perigee_view_set_time_noon(perigee_view *v)
{
    v->dirty |= v->has_sun;
    v->has_sun = false;
}

// Perpetual daylight: the camera's own direction pulled towards a fixed one, so that the sun stands
// 30 to 90 degrees high everywhere and moves smoothly over poles and meridians.
static dvec3 sun_direction(const perigee_view *v)
{
    const geodetic *at = &v->camera.position;
    bool plane = geo_is_plane(v->projection.ellipsoid);
    if (v->has_sun && plane) { // as it stands over the camera
        double lat = at->lat / RAD(1), lon = at->lon / RAD(1);
        perigee_planet_geographic(v->planet, 1, &lat, &lon);
        dvec3 s = dmat3_mul(dmat3_transpose(geo_ecef_from_enu(RAD(lat), RAD(lon))), v->sun);
        return (dvec3){s.z, s.x, s.y};
    }
    if (v->has_sun) return v->sun;
    dvec3 fixed = {0.42, -0.65, 0.38}; // shorter than 1: never night
    dvec3 up = plane ? geo_normal(0, 0) : dvec3_normalize(v->projection.camera_ecef);
    return dvec3_normalize(dvec3_add(up, fixed));
}

// True when it differs from the last frame's. Vertices stand relative to the camera, in the frame
// of the focus, as many as its distance asks for.
static bool find_gaze(perigee_view *v, double aspect)
{
    gaze was = v->gaze, now = v->gaze = scout_look(v->scout, &v->camera, aspect);
    bool moved = now.lat != was.lat || now.lon != was.lon || now.distance != was.distance ||
                 now.nearest != was.nearest;
    v->placed_dirty |= moved;
    return moved;
}

// In every mode the windows end where 256 samples across a ring are no wider than a pixel.
static int finest_windows(const perigee_view *v)
{
    return projection_last_level(&v->projection, v->gaze.distance, 256, v->params.levels);
}

static geometry_frame frame_of(const perigee_view *v)
{
    const struct planet_meta *m = pyramid_meta(v->planet->pyramid);
    return (geometry_frame){
        .projection = &v->projection,
        .windows = v->windows,
        .gaze = v->gaze,
        .view = projection_cell_view(&v->projection, m->height_min, m->height_max),
        .finest = v->finest,
        .first = v->first,
        .last = v->last,
    };
}

static void choose_levels(perigee_view *v)
{
    v->finest = v->params.last_level ? v->params.last_level : finest_windows(v);
    geometry_frame f = frame_of(v);
    v->geometry->mode->levels(v->geometry, &f, &v->first, &v->last);
    if (v->params.last_level) v->last = v->params.last_level;
    if (v->params.first_level) v->first = v->params.first_level;
    if (v->first > v->last) v->first = v->last;
}

// Samples finer than a pixel are not loaded.
static void move_windows(perigee_view *v)
{
    int enough[2];
    const int samples[2] = {v->params.texels, 256};
    for (int i = 0; i < 2; i++)
        enough[i] = projection_last_level(&v->projection, v->gaze.distance, samples[i],
                                          v->finest < 2 ? 3 : v->finest + 1);
    windows_move(v->windows, v->gaze.lat, v->gaze.lon, enough[0], enough[1]);
}

status view_prepare(perigee_view *v, int width, int height)
{
    if (width < 1 || height < 1 || width > MAX_SIZE || height > MAX_SIZE) {
        log_error("impossible picture size: %d x %d (1 to %d)", width, height, MAX_SIZE);
        return ERR_ARGUMENT;
    }
    const struct planet_meta *m = pyramid_meta(v->planet->pyramid);
    bool resized = v->frame.light.width != width || v->frame.light.height != height;
    status s = frame_resize(&v->frame, width, height);
    if (s) return s;
    v->stats.gpu_bytes_targets = frame_target_bytes(&v->frame);
    v->dirty |= resized;
    if (!v->dirty && v->gaze.exact) return OK;
    bool turned = find_gaze(v, (double)width / height);
    if (!v->dirty && !turned) return OK;
    v->dirty = true;
    v->projection =
        projection_make(m->ellipsoid, &v->camera, v->gaze.lat, v->gaze.lon, width, height);
    choose_levels(v);
    move_windows(v);
    return OK;
}

static void fill_view_block(const perigee_view *v, struct view_block *b)
{
    memset(b, 0, sizeof *b);
    projection_fill_block(&v->projection, sun_direction(v), !v->params.no_sky_glow, b);
    const uint32_t rings[4] = {(uint32_t)v->first, (uint32_t)v->last,
                               (uint32_t)v->params.rings_per_level,
                               (uint32_t)v->params.azimuth_steps + 2};
    const uint32_t layers[4] = {(uint32_t)windows_last_height(v->windows),
                                (uint32_t)windows_color_levels(v->windows) - 1};
    b->axes[2] = (float)windows_lead(v->windows);
    memcpy(b->rings, rings, sizeof rings);
    memcpy(b->layers, layers, sizeof layers);
}

void view_draw(perigee_view *v, double jitter_x, double jitter_y)
{
    projection *p = &v->projection;
    p->jitter_x = jitter_x;
    p->jitter_y = jitter_y;
    struct view_block view;
    struct levels_block levels;
    fill_view_block(v, &view);
    windows_fill_block(v->windows, &levels);
    frame_set_blocks(&v->frame, &view, &levels);
    bool heights_changed = windows_take_heights_changed(v->windows);
    if (v->placed_dirty || heights_changed) v->geometry->mode->invalidate(v->geometry);
    v->placed_dirty = false;

    geometry_frame geometry = frame_of(v);
    geometry_counts counts = {0};
    gpu_timer_begin(v->timer, 0);
    frame_begin_geometry(&v->frame, v->windows);
    v->geometry->mode->draw(v->geometry, &geometry, &counts);
    frame_shade(&v->frame, v->windows);
    gpu_timer_end(v->timer, 0);
    gpu_timer_frame(v->timer);

    v->stats.triangles_total = counts.triangles_total;
    v->stats.triangles_drawn = counts.triangles_drawn;
    v->stats.vertices_placed += counts.vertices_placed;
    v->stats.draws += counts.draws;
    v->stats.map_edge = counts.map_edge;
}

// As windows_pump(). Ground that stood in for what could not be had may have been looked at too.
static size_t pump(perigee_view *v, double dt_s)
{
    bool provisional = windows_provisional(v->windows);
    size_t bytes = windows_pump(v->windows, dt_s);
    if (provisional && !windows_provisional(v->windows)) {
        scout_forget(v->scout);
        v->gaze.exact = false;
    }
    return bytes;
}

void view_stream(perigee_view *v)
{
    double now = clock_s(), dt = now - v->clock_s;
    v->clock_s = now;
    v->stats.bytes_uploaded = pump(v, dt);
}

void view_count_frame(perigee_view *v)
{
    struct pyramid_counters tiles;
    pyramid_counters(v->planet->pyramid, &tiles);
    perigee_stats *s = &v->stats;
    struct windows_counters update;
    windows_count(v->windows, &update);
    s->samples_updated = update.samples;
    s->height_levels_yielded = update.heights_held_back;
    s->color_levels_yielded = update.colors_held_back;
    s->frames++;
    s->first_level = (uint32_t)v->first;
    s->last_level = (uint32_t)v->last;
    s->total_bytes_uploaded += s->bytes_uploaded;
    s->total_vertices_placed += s->vertices_placed;
    s->tiles_decoded = tiles.decoded;
    s->tiles_synthesised = tiles.synthesised;
    s->tiles_corrupt = tiles.corrupt;
    s->gpu_ms = gpu_timer_ms(v->timer, 0);
    s->needs_redraw =
        !windows_settled(v->windows) || windows_provisional(v->windows) || !v->gaze.exact;
}

perigee_status perigee_view_render(perigee_view *v, int width, int height)
{
    double start = clock_s();
    struct frame_state state;
    frame_state_save(&state);
    v->stats.bytes_uploaded = v->stats.vertices_placed = v->stats.draws = 0;
    status s = view_prepare(v, width, height);
    if (!s) {
        view_stream(v);
        bool changed = windows_take_changed(v->windows);
        if (v->dirty || changed) view_draw(v, 0, 0);
        v->dirty = false;
        frame_resolve(&v->frame, (GLuint)state.framebuffer, !v->params.no_antialias);
        v->stats.draws++;
        view_count_frame(v);
        v->stats.cpu_ms = (clock_s() - start) * 1e3;
    }
    frame_state_restore(&state);
    return (perigee_status)s;
}

// The lines of what is missing are told as one, with ";" between them.
static status log_timeout(const perigee_view *v, double timeout_s)
{
    char missing[768] = "";
    perigee_view_missing(v, missing, sizeof missing);
    size_t length = strlen(missing);
    while (length > 0 && missing[length - 1] == '\n') missing[--length] = '\0';
    for (char *p = missing; *p; p++)
        if (*p == '\n') *p = ';';
    log_error("not complete after %g s, missing: %s", timeout_s, missing);
    return ERR_TIMEOUT;
}

// What stands in for tiles that could not be had is given time to go before a picture is called
// complete, until `end` at most; but once in an outage, not with each of its frames.
static bool may_recover(perigee_view *v, double end, double *until)
{
    const double patience_s = 20; // a server that lost connections rests for up to some seconds
    bool provisional = windows_provisional(v->windows);
    v->outage &= provisional;
    if (!provisional || v->outage) return false;
    double now = clock_s();
    if (*until == 0) *until = fmin(now + patience_s, end);
    v->outage = now >= *until;
    if (!v->outage) clock_sleep_s(0.01);
    return !v->outage;
}

perigee_status perigee_view_wait(perigee_view *v, int width, int height, double timeout_s)
{
    double end = clock_s() + timeout_s, recovers_until = 0;
    struct frame_state state;
    frame_state_save(&state);
    status s = view_prepare(v, width, height);
    while (!s) {
        v->stats.total_bytes_uploaded += pump(v, -1);
        bool settled = windows_settled(v->windows);
        if (settled && v->gaze.exact && !may_recover(v, end, &recovers_until)) break;
        double left = end - clock_s();
        if (!(left > 0)) {
            s = log_timeout(v, timeout_s);
            break;
        }
        if (settled) scout_wait(v->scout, fmin(left, 0.05));
        if (!v->gaze.exact) s = view_prepare(v, width, height);
        // Focus unchanged: this only plans what did not fit in before.
        move_windows(v);
        glFinish();
        windows_wait(v->windows, fmin(left, 0.05));
    }
    frame_state_restore(&state);
    return (perigee_status)s;
}

int perigee_view_missing(const perigee_view *v, char *text, size_t size)
{
    int count = windows_missing(v->windows, text, size);
    size_t used = size ? strlen(text) : 0;
    if (v->gaze.exact) return count;
    if (used < size) snprintf(text + used, size - used, "ground under the view\n");
    return count + 1;
}

void perigee_view_get_stats(const perigee_view *v, perigee_stats *out)
{
    *out = v->stats;
}
