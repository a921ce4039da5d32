#include "app/compare_cameras.h"

#include <math.h>
#include <stdio.h>

#include "base/log.h"

enum { FRAMES = 10 };

status compare_cameras_load(struct compare_cameras *c, const struct options *o)
{
    *c = (struct compare_cameras){.options = o, .count = 1};
    if (o->path) return path_file_load(o->path, &c->path);
    status s = o->views ? views_file_load(o->views, &c->views) : OK;
    if (o->views) c->count = c->views.count;
    return s;
}

static status open_flight(struct compare_cameras *c)
{
    const struct options *o = c->options;
    status s = path_file_flight(&c->path, c->session->planet, &c->flight);
    if (s) return s;
    double duration = flight_duration_s(c->flight);
    if (o->start_s > duration) {
        log_error("--start %g: %s ends at %g s", o->start_s, o->path, duration);
        return ERR_ARGUMENT;
    }
    c->count = o->frames > 0 ? o->frames : FRAMES;
    return OK;
}

status compare_cameras_open(struct compare_cameras *c, const struct session *session)
{
    c->session = session;
    return c->options->path ? open_flight(c) : OK;
}

void compare_cameras_deinit(struct compare_cameras *c)
{
    flight_destroy(&c->flight);
    path_file_deinit(&c->path);
    views_file_deinit(&c->views);
}

bool compare_cameras_time(const struct compare_cameras *c, double *unix_time_s)
{
    if (!c->path.time_given || c->options->time_given) return false;
    *unix_time_s = c->path.unix_time_s;
    return true;
}

static double frame_time(const struct compare_cameras *c, int frame)
{
    double duration = flight_duration_s(c->flight), end = c->options->end_s;
    if (isnan(end) || end > duration) end = duration;
    double start = c->options->start_s;
    return c->count > 1 ? start + (end - start) * frame / (c->count - 1) : start;
}

static status view_camera(const struct compare_cameras *c, const named_view *view,
                          perigee_camera *out)
{
    double ground;
    *out = view->camera;
    out->lon_deg = remainder(out->lon_deg, 360);
    status s = session_place(c->session, out);
    if (s) return s;
    if (!view->above_ground && out->alt_m > c->session->info.height_max_m) return OK;
    s = (status)perigee_planet_height(c->session->planet, out->lat_deg, out->lon_deg, &ground);
    if (s) return s;
    if (view->above_ground) out->alt_m += ground;
    if (out->alt_m > ground) return OK;
    log_error("%s: view '%s': \"alt\" %.10g is below the terrain, which is %.1f m high there",
              c->views.path, view->name, out->alt_m, ground);
    return ERR_FORMAT;
}

status compare_cameras_at(const struct compare_cameras *c, int i, double later_s,
                          compare_place *out)
{
    *out = (compare_place){0};
    if (c->options->views) {
        snprintf(out->name, sizeof out->name, "%s", c->views.views[i].name);
        return view_camera(c, &c->views.views[i], &out->camera);
    }
    if (!c->flight) return session_camera(c->session, &out->camera);
    snprintf(out->name, sizeof out->name, "frame %d", i);
    double time_s = frame_time(c, i);
    out->time_s = time_s + later_s;
    if (out->time_s > flight_duration_s(c->flight)) out->time_s = fmax(0, time_s - later_s);
    return path_file_camera(c->flight, c->session->planet, out->time_s, &out->camera);
}
