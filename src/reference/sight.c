#include "reference/sight.h"

#include <math.h>
#include <stdlib.h>

#include "base/log.h"
#include "base/memory.h"
#include "reference/body.h"

// Doublings from a decimetre to beyond 10^12 m.
enum { MAX_SHELLS = 48, SHELL_TILES = 8192 };

#define LEAST_CLEARANCE_M 0.5
// Samples a pixel at which data finer than this zoom no longer shows.
#define SAMPLES_A_PIXEL 4

// The ground from `near` to `far` metres of the eye.
struct shell {
    double near, far;
    struct field *field;
};

struct sight {
    sight_params params;
    struct shell shell[MAX_SHELLS];
    int shells;
    sight_ground ground;
};

struct task {
    struct sight *sight;
    struct pool *pool;
    const reference_progress *progress;
    double done, share; // of the whole work: before this field, and of this field
};

static bool report_part(void *user, double done)
{
    const struct task *t = user;
    return t->progress->report && t->progress->report(t->progress->user, t->done + t->share * done);
}

static int finest_stored(const struct planet_meta *m)
{
    return m->max_zoom[LAYER_HEIGHT] < 0 ? 0 : m->max_zoom[LAYER_HEIGHT];
}

static field_params params_of(const struct sight *s, const struct shell *shell, int zoom)
{
    field_params f = {s->params.pyramid, zoom, s->params.view, s->params.bicubic};
    f.sight.near = shell->near;
    f.sight.far = shell->far;
    return f;
}

static status create_field(struct task *t, struct shell *shell, int zoom)
{
    field_params params = params_of(t->sight, shell, zoom);
    const reference_progress part = {report_part, t};
    field_destroy(&shell->field);
    return field_create(&params, t->pool, &part, &shell->field);
}

// A zoom at which four samples fall on a pixel at `distance`.
static int pixel_zoom(const struct sight *s, double distance)
{
    double a = pyramid_meta(s->params.pyramid)->ellipsoid.a;
    double step = s->params.pixel * distance / SAMPLES_A_PIXEL / a;
    return (int)clamp_double(ceil(log2(grid_step_lat(0) / step)), 0, GRID_MAX_ZOOM);
}

// What the field misses of the limit, in pixels at the nearer end of the shell.
static double missed_px(const struct sight *s, const struct shell *shell, double distance,
                        bool synthesis)
{
    bool more =
        synthesis || field_zoom(shell->field) < finest_stored(pyramid_meta(s->params.pyramid));
    return field_bend(shell->field) / (more ? 2 : 6) / (s->params.pixel * distance);
}

// From a fitting zoom on, finer until the error holds. A zoom takes at most three quarters of the
// error away, so whole powers of four are leapt over.
static status choose_zoom(struct task *t, struct shell *shell, double distance)
{
    struct sight *s = t->sight;
    bool synthesis = pyramid_synthesises(s->params.pyramid);
    int zoom = pixel_zoom(s, distance), stored = finest_stored(pyramid_meta(s->params.pyramid));
    double error, want = s->params.error_px;
    if (zoom > stored) zoom = stored;
    for (;;) {
        status failed = create_field(t, shell, zoom);
        if (failed) return failed;
        error = missed_px(s, shell, distance, synthesis);
        if (error <= want || zoom == GRID_MAX_ZOOM) break;
        int next = zoom + (int)clamp_double(floor(log2(error / want) / 2), 1, GRID_MAX_ZOOM - zoom);
        field_params finer = params_of(s, shell, next);
        while (next > zoom && field_count_tiles(&finer) > SHELL_TILES) finer.zoom = --next;
        if (next == zoom) break;
        zoom = next;
    }
    if (!field_tiles(shell->field)) return OK;
    s->ground.error_px = fmax(s->ground.error_px, error);
    s->ground.zoom_min = zoom < s->ground.zoom_min ? zoom : s->ground.zoom_min;
    s->ground.zoom_max = zoom > s->ground.zoom_max ? zoom : s->ground.zoom_max;
    return OK;
}

static status clearance_of(const struct sight *s, double *clearance)
{
    const struct planet_meta *m = pyramid_meta(s->params.pyramid);
    dvec3 eye = s->params.view.eye;
    double lat, lon, height, ground;
    body_locate(m->ellipsoid, eye, &lat, &lon, &height);
    status failed = pyramid_height_at(s->params.pyramid, finest_stored(m), lat * (M_PI / 180),
                                      lon * (M_PI / 180), &ground);
    *clearance = fmax(height - ground, LEAST_CLEARANCE_M);
    return failed;
}

static status create_shells(struct task *t)
{
    struct sight *s = t->sight;
    const struct planet_meta *m = pyramid_meta(s->params.pyramid);
    double clearance, reach = body_reach(m->ellipsoid, s->params.view.eye);
    status failed = clearance_of(s, &clearance);
    double first = 0.25 * clearance;
    int count = 1 + (int)ceil(log2(reach / first));
    s->ground.zoom_min = GRID_MAX_ZOOM;
    t->share /= count;
    for (int i = 0; i < count && i < MAX_SHELLS && !failed; i++) {
        struct shell *shell = &s->shell[i];
        *shell = (struct shell){.near = i ? ldexp(first, i) : 0, .far = ldexp(first, i + 1)};
        s->shells = i + 1;
        failed = choose_zoom(t, shell, ldexp(first, i));
        t->done += t->share;
    }
    if (s->ground.zoom_min > s->ground.zoom_max) s->ground.zoom_min = s->ground.zoom_max;
    return failed;
}

static status create_single(struct task *t)
{
    struct sight *s = t->sight;
    int stored = finest_stored(pyramid_meta(s->params.pyramid));
    int zoom = s->params.zoom < 0 ? stored : s->params.zoom;
    s->shell[0] = (struct shell){.far = INFINITY};
    s->shells = 1;
    s->ground = (sight_ground){zoom, zoom, 0};
    field_params params = params_of(s, &s->shell[0], zoom);
    params.sight.far = 0;
    const reference_progress part = {report_part, t};
    return field_create(&params, t->pool, &part, &s->shell[0].field);
}

static void log_ground(const struct sight *s)
{
    sight_ground g = s->ground;
    if (s->params.zoom != SIGHT_AUTO) log_debug("reference: heights of zoom %d", g.zoom_min);
    else if (g.error_px <= s->params.error_px)
        log_debug("reference: heights of zooms %d to %d by distance, within %.2g px of the limit",
                  g.zoom_min, g.zoom_max, g.error_px);
    else
        log_warn("reference: heights of zooms %d to %d by distance, only within %.2g px of the "
                 "limit where the ground is steepest (wanted: %g px)",
                 g.zoom_min, g.zoom_max, g.error_px, s->params.error_px);
}

status sight_create(const sight_params *params, struct pool *pool,
                    const reference_progress *progress, struct sight **out)
{
    struct sight *s = NEW(struct sight);
    s->params = *params;
    struct task task = {s, pool, progress, 0, 1};
    status failed = params->zoom == SIGHT_AUTO ? create_shells(&task) : create_single(&task);
    if (failed) sight_destroy(&s);
    else log_ground(s);
    *out = s;
    return failed;
}

void sight_destroy(struct sight **sight)
{
    if (!*sight) return;
    for (int i = 0; i < (*sight)->shells; i++) field_destroy(&(*sight)->shell[i].field);
    free(*sight);
    *sight = NULL;
}

sight_ground sight_get_ground(const struct sight *s)
{
    return s->ground;
}

const struct field *sight_nearest(const struct sight *s)
{
    return s->shell[0].field;
}

// Shells without ground are passed over, but for the first, in whose ground the eye may be.
bool sight_cast(const struct sight *s, struct field_reader *reader, dvec3 dir, ray_hit *hit)
{
    for (int i = 0; i < s->shells; i++) {
        const struct shell *shell = &s->shell[i];
        if (i && !field_tiles(shell->field)) continue;
        reader->field = shell->field;
        if (ray_cast_between(reader, s->params.view.eye, dir, s->params.pixel, shell->near,
                             shell->far, hit))
            return true;
    }
    return false;
}
