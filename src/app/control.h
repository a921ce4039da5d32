// The camera controller: turns presses, drags, wheel steps and held keys into a moving camera.
// Knows no window and no GL, so every gesture can be tested. Angles in radians, pixels from the top
// left corner, seconds. Main only.
//
// Whatever comes in, the camera stays finite, at least CONTROL_CLEARANCE above the terrain and at
// most CONTROL_ALTITUDE_MAX above the ellipsoid.
#ifndef PERIGEE_APP_CONTROL_H
#define PERIGEE_APP_CONTROL_H

#include <stdbool.h>

#include "geo/camera.h"

#define CONTROL_CLEARANCE    1.7 // a walker's eye, m
#define CONTROL_ALTITUDE_MAX 1e8 // m

// What the controller asks of the planet. Called from within the functions below, on their thread.
struct control_world {
    geo_ellipsoid ellipsoid;
    void *user;
    // Terrain height above the ellipsoid, for a camera `room` metres above what was last known of
    // it: as exact as it takes not to meet the terrain. Infinite room: a guess is enough, NaN is
    // "not known". Asked at most three times a step.
    double (*ground)(void *user, double lat, double lon, double room);
    // The terrain's point under a pixel as last shown; false on sky. Asked when a gesture begins,
    // never during it.
    bool (*pick)(void *user, double x_px, double y_px, geodetic *point);
};

enum control_button { CONTROL_DRAG, CONTROL_ORBIT };

enum control_key {
    CONTROL_LEFT,
    CONTROL_RIGHT,
    CONTROL_UP,
    CONTROL_DOWN,
    CONTROL_ZOOM_IN,
    CONTROL_ZOOM_OUT,
    CONTROL_SHIFT,     // with the arrows: turn and tilt; with the fly keys: faster
    CONTROL_FLY_AHEAD, // the fly keys work in fly mode only
    CONTROL_FLY_BACK,
    CONTROL_FLY_LEFT,
    CONTROL_FLY_RIGHT,
    CONTROL_FLY_RISE,
    CONTROL_FLY_SINK,
    CONTROL_ROLL_LEFT,
    CONTROL_ROLL_RIGHT,
    CONTROL_KEYS
};

struct control;

// `start` is also the home view. Values that are not finite are replaced by the whole planet's
// view.
struct control *control_create(const struct control_world *world, const geo_camera *start,
                               int width_px, int height_px);
void control_destroy(struct control **control);

void control_resize(struct control *control, int width_px, int height_px);

// CONTROL_DRAG holds the ground under the cursor (in fly mode, and on the sky: turns the head);
// CONTROL_ORBIT turns and tilts about the ground under the cursor.
void control_press(struct control *control, enum control_button button, double x_px, double y_px);
void control_move(struct control *control, double x_px, double y_px);
void control_release(struct control *control, enum control_button button);
// Wheel steps, positive towards the ground under the cursor.
void control_wheel(struct control *control, double steps, double x_px, double y_px);
void control_double_click(struct control *control, double x_px, double y_px);
void control_key(struct control *control, enum control_key key, bool down);
// Every key up, every button released, all motion stopped: the window lost the focus.
void control_stop(struct control *control);

void control_north_up(struct control *control);
void control_home(struct control *control);
void control_set_fly(struct control *control, bool fly);
bool control_is_flying(const struct control *control);

// Advances by dt_s. True when the camera is not what the last step left.
bool control_step(struct control *control, double dt_s);
// True while the camera moves on by itself or a held key moves it: step again soon.
bool control_is_moving(const struct control *control);

const geo_camera *control_camera(const struct control *control);
// Terrain below the camera as of the last step.
double control_ground(const struct control *control);

#endif
