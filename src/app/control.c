// One gesture at a time owns the camera (enum gesture); wheel, keys and the turn to north add to
// it. Inertia lets the gesture go on with a cursor speed that fades: in screen space all gestures
// coast by the same rule.
#include "app/control.h"

#include <stdlib.h>
#include <string.h>

#include "app/control_pose.h"
#include "base/memory.h"
#include "geo/flight.h"

// Fading of what coasts, of what a held key builds up, of a wheel step and of the measured cursor
// speed, seconds.
#define COAST_S 0.30
#define KEY_S   0.12
#define WHEEL_S 0.10
#define SPEED_S 0.04
#define LIFT_S  0.15
// Below this the cursor's speed has come to rest, px/s.
#define REST_PX_S 3.0
// One wheel step multiplies the distance by exp(-WHEEL_STEP).
#define WHEEL_STEP    0.3
#define WHEEL_PENDING 8.0
#define ORBIT_PER_PX  0.005
#define STEP_MAX_S    0.1

enum gesture { GESTURE_NONE, GESTURE_DRAG, GESTURE_ORBIT, GESTURE_LOOK, GESTURE_FLIGHT };

struct control {
    struct control_world world;
    struct pose_screen screen;
    geo_camera camera, home, stepped; // stepped: as the last step left it
    double ground;

    enum gesture gesture;
    enum control_button button;
    bool held; // the button is down; otherwise the gesture coasts
    struct pose_grab grab;
    dvec3 pivot, pivot_ray;
    double x, y;             // cursor
    double moved_x, moved_y; // since the last step
    double speed_x, speed_y; // px/s

    double zoom_pending; // logarithm of the distance still to go
    dvec3 zoom_point, zoom_ray;
    bool zoom_hits;

    bool keys[CONTROL_KEYS];
    double pan_x, pan_y, turn, tilt, zoom, rise, roll; // speeds that held keys build up

    bool north_pending, fly;
    double north_s;

    struct flight *flight;
    double flight_s, flight_lift;
    dvec3 last_position; // for the look ahead
};

static double ask_ground(struct control *c, double lat, double lon, double room)
{
    double h = c->world.ground(c->world.user, lat, lon, room);
    return isfinite(h) ? h : c->ground;
}

// Keeps the altitude legal; says whether the terrain or the ceiling stopped it.
static bool keep_clear(struct control *c)
{
    geodetic *p = &c->camera.position;
    c->ground = ask_ground(c, p->lat, p->lon, p->height - c->ground);
    double low = c->ground + CONTROL_CLEARANCE, height = p->height;
    p->height = fmax(fmin(height, CONTROL_ALTITUDE_MAX), low);
    return p->height != height;
}

static geo_camera whole_planet(geo_ellipsoid e)
{
    return (geo_camera){.position.height = 2.5 * e.a, .pitch = -M_PI / 2, .fov_y = M_PI / 3};
}

// A camera that every function here can work with.
static geo_camera sane(geo_ellipsoid e, const geo_camera *c)
{
    if (!pose_is_finite(c)) return whole_planet(e);
    geo_camera out = *c;
    out.position.lat = clamp_double(c->position.lat, -M_PI / 2, M_PI / 2);
    out.position.lon = geo_wrap_lon(c->position.lon);
    if (geo_is_plane(e)) out.position.lon = clamp_double(c->position.lon, -M_PI, 0.999999 * M_PI);
    out.position.height = clamp_double(c->position.height, -0.01 * e.b, CONTROL_ALTITUDE_MAX);
    out.heading = remainder(c->heading, 2 * M_PI);
    out.pitch = clamp_double(c->pitch, -M_PI / 2, M_PI / 2);
    out.roll = remainder(c->roll, 2 * M_PI);
    out.fov_y = clamp_double(c->fov_y, 1e-3, 3.0);
    return out;
}

struct control *control_create(const struct control_world *world, const geo_camera *start,
                               int width_px, int height_px)
{
    struct control *c = NEW(struct control);
    c->world = *world;
    c->camera = sane(world->ellipsoid, start);
    control_resize(c, width_px, height_px);
    keep_clear(c);
    c->home = c->stepped = c->camera;
    c->last_position = geo_ecef_from_geodetic(world->ellipsoid, c->camera.position);
    return c;
}

void control_destroy(struct control **control)
{
    if (!*control) return;
    flight_destroy(&(*control)->flight);
    free(*control);
    *control = NULL;
}

void control_resize(struct control *c, int width_px, int height_px)
{
    c->screen = (struct pose_screen){width_px > 1 ? width_px : 1, height_px > 1 ? height_px : 1};
}

const geo_camera *control_camera(const struct control *c)
{
    return &c->camera;
}

double control_ground(const struct control *c)
{
    return c->ground;
}

bool control_is_flying(const struct control *c)
{
    return c->fly;
}

static double above_ground(const struct control *c)
{
    return fmax(c->camera.position.height - c->ground, CONTROL_CLEARANCE);
}

static void end_gesture(struct control *c)
{
    flight_destroy(&c->flight);
    c->gesture = GESTURE_NONE;
    c->held = false;
    c->speed_x = c->speed_y = c->moved_x = c->moved_y = 0;
}

// What every new gesture stops.
static void begin_gesture(struct control *c)
{
    end_gesture(c);
    c->zoom_pending = 0;
    c->north_pending = false;
}

static bool on_screen(double x, double y)
{
    return fabs(x) < 1e6 && fabs(y) < 1e6; // and not NaN
}

static bool pick(struct control *c, double x, double y, dvec3 *point)
{
    geodetic g;
    if (!c->world.pick(c->world.user, x, y, &g)) return false;
    *point = geo_ecef_from_geodetic(c->world.ellipsoid, g);
    return isfinite(point->x) && isfinite(point->y) && isfinite(point->z);
}

void control_press(struct control *c, enum control_button button, double x, double y)
{
    if (!on_screen(x, y) || (c->held && c->button != button)) return;
    begin_gesture(c);
    c->x = x;
    c->y = y;
    c->button = button;
    c->held = true;
    geo_ellipsoid e = c->world.ellipsoid;
    c->pivot_ray = pose_eye_ray(&c->camera, c->screen, x, y);
    bool hit = pick(c, x, y, &c->pivot);
    bool space = c->camera.position.height > 0.2 * e.a;
    c->gesture = GESTURE_LOOK;
    if (button == CONTROL_DRAG && !c->fly && (hit || space)) {
        c->gesture = GESTURE_DRAG;
        c->grab = hit ? pose_grab_make(e, &c->camera, c->pivot)
                      : pose_grab_sphere(e, &c->camera, c->pivot_ray, e.a);
    }
    if (button == CONTROL_ORBIT && hit) c->gesture = GESTURE_ORBIT;
}

// A cursor's way dx, dy under the gesture. Dragging by hand follows the grabbed point; coasting
// takes a new point under the resting cursor each time, so that it never runs over the limb.
static void apply_gesture(struct control *c, double dx, double dy, bool coasting)
{
    geo_ellipsoid e = c->world.ellipsoid;
    double per_px = c->camera.fov_y / c->screen.height;
    switch (c->gesture) {
    case GESTURE_DRAG:
        if (coasting) {
            double radius = dvec3_length(c->grab.point);
            dvec3 ray = pose_eye_ray(&c->camera, c->screen, c->x, c->y);
            c->grab = pose_grab_sphere(e, &c->camera, ray, radius);
        }
        dvec3 ray = pose_eye_ray(&c->camera, c->screen, c->x + dx, c->y + dy);
        pose_drag(e, &c->camera, &c->grab, ray);
        break;
    case GESTURE_ORBIT:
        pose_orbit(e, &c->camera, c->pivot, c->pivot_ray, dx * ORBIT_PER_PX, -dy * ORBIT_PER_PX);
        break;
    case GESTURE_LOOK:
        pose_look(&c->camera, -dx * per_px, dy * per_px);
        break;
    default:
        break;
    }
}

void control_move(struct control *c, double x, double y)
{
    if (!on_screen(x, y) || !c->held) return;
    double dx = x - c->x, dy = y - c->y;
    apply_gesture(c, dx, dy, false);
    c->x = x;
    c->y = y;
    c->moved_x += dx;
    c->moved_y += dy;
    keep_clear(c);
}

void control_release(struct control *c, enum control_button button)
{
    if (c->held && c->button == button) c->held = false;
}

// Takes the zoom's fixed point; the sky has none, there only the altitude changes.
static void aim_zoom(struct control *c, double x, double y)
{
    c->zoom_hits = pick(c, x, y, &c->zoom_point);
    c->zoom_ray = pose_eye_ray(&c->camera, c->screen, x, y);
}

void control_wheel(struct control *c, double steps, double x, double y)
{
    if (!on_screen(x, y) || !isfinite(steps) || c->held) return;
    end_gesture(c);
    aim_zoom(c, x, y);
    double pending = c->zoom_pending - steps * WHEEL_STEP;
    c->zoom_pending = clamp_double(pending, -WHEEL_PENDING, WHEEL_PENDING);
}

static double axis(const struct control *c, enum control_key minus, enum control_key plus)
{
    return (double)c->keys[plus] - (double)c->keys[minus];
}

// Turning and tilting by keys goes about the middle of the picture; without ground there, about the
// camera.
static void orbit_center(struct control *c)
{
    c->pivot_ray = (dvec3){0, 0, -1};
    bool hit = pick(c, 0.5 * c->screen.width, 0.5 * c->screen.height, &c->pivot);
    c->gesture = hit && !c->fly ? GESTURE_ORBIT : GESTURE_LOOK;
}

void control_key(struct control *c, enum control_key key, bool down)
{
    bool zooms = key == CONTROL_ZOOM_IN || key == CONTROL_ZOOM_OUT;
    bool was = c->keys[key];
    c->keys[key] = down;
    if (!down || was || c->held || (key >= CONTROL_FLY_AHEAD && !c->fly)) return;
    bool arrows =
        axis(c, CONTROL_LEFT, CONTROL_RIGHT) != 0 || axis(c, CONTROL_DOWN, CONTROL_UP) != 0;
    if (key == CONTROL_SHIFT && !arrows) return;
    begin_gesture(c);
    if (zooms) aim_zoom(c, 0.5 * c->screen.width, 0.5 * c->screen.height);
    if (arrows && c->keys[CONTROL_SHIFT]) orbit_center(c);
}

void control_stop(struct control *c)
{
    begin_gesture(c);
    memset(c->keys, 0, sizeof c->keys);
    c->pan_x = c->pan_y = c->turn = c->tilt = c->zoom = c->rise = c->roll = 0;
}

void control_set_fly(struct control *c, bool fly)
{
    begin_gesture(c);
    c->fly = fly;
}

void control_north_up(struct control *c)
{
    if (c->held) return;
    begin_gesture(c);
    c->north_pending = true;
    c->north_s = 0;
    orbit_center(c);
}

// Starts a flight to a camera. The flight's altitudes must be positive: both ends are lifted alike,
// and lowered again on the way.
static void fly_to(struct control *c, const geo_camera *target, double duration_s)
{
    begin_gesture(c);
    flight_key keys[2] = {{0, c->camera}, {duration_s, *target}};
    double low = fmin(c->camera.position.height, target->position.height);
    c->flight_lift = fmax(0, 1 - low);
    for (int i = 0; i < 2; i++) keys[i].camera.position.height += c->flight_lift;
    c->flight = flight_create(c->world.ellipsoid, keys, 2);
    c->flight_s = 0;
    if (c->flight) c->gesture = GESTURE_FLIGHT;
    else c->camera = *target;
}

void control_home(struct control *c)
{
    if (!c->held) fly_to(c, &c->home, 2.5);
}

void control_double_click(struct control *c, double x, double y)
{
    dvec3 point;
    if (!on_screen(x, y)) return;
    begin_gesture(c);
    if (!pick(c, x, y, &point)) return;
    geo_ellipsoid e = c->world.ellipsoid;
    geo_camera to = c->camera;
    double distance = dvec3_length(dvec3_sub(point, geo_ecef_from_geodetic(e, to.position)));
    distance = fmax(0.25 * distance, fmin(distance, 30));
    // Seen from the point: the camera stands back along its own view, looking down at least a
    // little.
    to.pitch = fmin(to.pitch, -0.3);
    to.roll = 0;
    to.position = geo_geodetic_from_ecef(e, point);
    dvec3 ahead = pose_ray(e, &to, c->screen, 0.5 * c->screen.width, 0.5 * c->screen.height);
    dvec3 back = dvec3_mad(point, ahead, -distance);
    to.position = geo_geodetic_from_ecef(e, back);
    pose_aim(e, &to, point, (dvec3){0, 0, -1});
    double low = ask_ground(c, to.position.lat, to.position.lon, INFINITY) + CONTROL_CLEARANCE;
    to.position.height = clamp_double(to.position.height, low, CONTROL_ALTITUDE_MAX);
    if (pose_is_finite(&to)) fly_to(c, &to, 1.6);
}

// The part of a change that dt brings when it approaches its end with time constant tau.
static double share(double dt, double tau)
{
    return -expm1(-dt / tau);
}

static void step_flight(struct control *c, double dt)
{
    c->flight_s += dt;
    c->camera = flight_at(c->flight, c->flight_s);
    c->camera.position.height -= c->flight_lift;
    if (c->flight_s >= flight_duration_s(c->flight)) end_gesture(c);
}

static void step_gesture(struct control *c, double dt)
{
    if (c->gesture == GESTURE_FLIGHT) {
        step_flight(c, dt);
        return;
    }
    if (c->held || c->moved_x != 0 || c->moved_y != 0) {
        double k = share(dt, SPEED_S);
        c->speed_x += (c->moved_x / dt - c->speed_x) * k;
        c->speed_y += (c->moved_y / dt - c->speed_y) * k;
        c->moved_x = c->moved_y = 0;
    }
    if (hypot(c->speed_x, c->speed_y) < REST_PX_S) c->speed_x = c->speed_y = 0;
    if (c->held || (c->speed_x == 0 && c->speed_y == 0)) return;
    double way = COAST_S * share(dt, COAST_S);
    apply_gesture(c, c->speed_x * way, c->speed_y * way, true);
    c->speed_x *= 1 - share(dt, COAST_S);
    c->speed_y *= 1 - share(dt, COAST_S);
}

static void step_zoom(struct control *c, double dt)
{
    double part = c->zoom_pending * share(dt, WHEEL_S) + c->zoom * dt;
    if (fabs(c->zoom_pending) < 1e-4) part = c->zoom_pending + c->zoom * dt;
    c->zoom_pending = fabs(c->zoom_pending) < 1e-4 ? 0 : c->zoom_pending * (1 - share(dt, WHEEL_S));
    if (part == 0) return;
    geo_camera before = c->camera;
    if (c->zoom_hits) {
        pose_zoom(c->world.ellipsoid, &c->camera, c->zoom_point, c->zoom_ray, exp(part));
    } else {
        double h = above_ground(c) * exp(part);
        c->camera.position.height = c->ground + fmax(h, CONTROL_CLEARANCE);
    }
    if (c->camera.position.height > CONTROL_ALTITUDE_MAX) {
        c->camera = before;
        c->zoom_pending = 0;
    }
}

static void ease(double *value, double target, double dt)
{
    *value += (target - *value) * share(dt, KEY_S);
    if (fabs(*value - target) < 1e-3 * fmax(fabs(target), 0.01)) *value = target;
}

static void step_keys(struct control *c, double dt)
{
    bool shift = c->keys[CONTROL_SHIFT];
    double x = axis(c, CONTROL_LEFT, CONTROL_RIGHT), y = axis(c, CONTROL_DOWN, CONTROL_UP);
    double fly = c->fly ? (shift ? 4 : 1) : 0;
    double side = fly * axis(c, CONTROL_FLY_LEFT, CONTROL_FLY_RIGHT);
    double ahead = fly * axis(c, CONTROL_FLY_BACK, CONTROL_FLY_AHEAD);
    ease(&c->pan_x, (shift ? 0 : x) + side, dt);
    ease(&c->pan_y, (shift ? 0 : y) + ahead, dt);
    ease(&c->turn, shift ? x : 0, dt);
    ease(&c->tilt, shift ? y : 0, dt);
    ease(&c->zoom, 1.5 * axis(c, CONTROL_ZOOM_IN, CONTROL_ZOOM_OUT), dt);
    ease(&c->rise, fly * axis(c, CONTROL_FLY_SINK, CONTROL_FLY_RISE), dt);
    ease(&c->roll, fly > 0 ? axis(c, CONTROL_ROLL_LEFT, CONTROL_ROLL_RIGHT) : 0, dt);
    geo_ellipsoid e = c->world.ellipsoid;
    double reach = fmin(above_ground(c), 0.5 * e.a) * dt;
    pose_move(e, &c->camera, c->pan_x * reach, c->pan_y * reach);
    c->camera.position.height += c->rise * above_ground(c) * dt;
    c->camera.roll = remainder(c->camera.roll + c->roll * dt, 2 * M_PI);
    if (c->turn == 0 && c->tilt == 0) return;
    if (c->gesture == GESTURE_ORBIT)
        pose_orbit(e, &c->camera, c->pivot, c->pivot_ray, c->turn * dt, c->tilt * dt);
    else pose_look(&c->camera, c->turn * dt, c->tilt * dt);
}

static void step_north(struct control *c, double dt)
{
    if (!c->north_pending) return;
    c->north_s += dt;
    double part = share(dt, 0.15), turn = -c->camera.heading * part;
    if (c->gesture == GESTURE_ORBIT)
        pose_orbit(c->world.ellipsoid, &c->camera, c->pivot, c->pivot_ray, turn, 0);
    else pose_look(&c->camera, turn, 0);
    c->camera.roll *= 1 - part;
    if (c->north_s < 1.5 && hypot(c->camera.heading, c->camera.roll) > 1e-4) return;
    c->camera.heading = c->camera.roll = 0;
    begin_gesture(c);
}

// Lifts the camera early and gently where its way leads into rising ground; keep_clear has the last
// word.
static void step_terrain(struct control *c, double dt)
{
    static const double ahead_s[] = {0.25, 0.8};
    geo_ellipsoid e = c->world.ellipsoid;
    double *height = &c->camera.position.height, low = *height;
    dvec3 p = geo_ecef_from_geodetic(e, c->camera.position);
    dvec3 speed = dvec3_scale(dvec3_sub(p, c->last_position), 1 / dt);
    double pace = dvec3_length(speed);
    for (int i = 0; i < 2 && pace > 0 && fmax(pace, above_ground(c)) < 0.01 * e.b; i++) {
        geodetic next = geo_geodetic_from_ecef(e, dvec3_mad(p, speed, ahead_s[i]));
        low = fmax(low, ask_ground(c, next.lat, next.lon, INFINITY) + CONTROL_CLEARANCE);
    }
    *height += (low - *height) * share(dt, LIFT_S);
    if (keep_clear(c) && c->zoom_pending < 0) c->zoom_pending = 0;
    c->last_position = geo_ecef_from_geodetic(e, c->camera.position);
}

static bool same_camera(const geo_camera *a, const geo_camera *b)
{
    return a->position.lat == b->position.lat && a->position.lon == b->position.lon &&
           a->position.height == b->position.height && a->heading == b->heading &&
           a->pitch == b->pitch && a->roll == b->roll && a->fov_y == b->fov_y;
}

bool control_step(struct control *c, double dt)
{
    if (!(dt > 0) || !isfinite(dt)) dt = 1e-3;
    // The cursor's speed is measured over the true time, motion is bounded to what one frame may
    // show.
    step_gesture(c, c->held ? dt : fmin(dt, STEP_MAX_S));
    dt = fmin(dt, STEP_MAX_S);
    step_zoom(c, dt);
    step_keys(c, dt);
    step_north(c, dt);
    if (!pose_is_finite(&c->camera)) c->camera = c->stepped;
    step_terrain(c, dt);
    bool changed = !same_camera(&c->camera, &c->stepped);
    c->stepped = c->camera;
    return changed;
}

bool control_is_moving(const struct control *c)
{
    bool keyed = c->pan_x != 0 || c->pan_y != 0 || c->turn != 0 || c->tilt != 0 || c->zoom != 0 ||
                 c->rise != 0 || c->roll != 0;
    for (int k = 0; k < CONTROL_KEYS; k++)
        keyed = keyed || (c->keys[k] && k != CONTROL_SHIFT && (c->fly || k < CONTROL_FLY_AHEAD));
    return keyed || c->speed_x != 0 || c->speed_y != 0 || c->zoom_pending != 0 ||
           c->north_pending || c->flight;
}
