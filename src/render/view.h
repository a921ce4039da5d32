// What stands behind perigee_view. Main only.
#ifndef PERIGEE_RENDER_VIEW_H
#define PERIGEE_RENDER_VIEW_H

#include "gpu/timer.h"
#include "render/frame.h"
#include "render/geometry.h"
#include "render/planet_handle.h"
#include "render/scout.h"

struct perigee_view {
    perigee_planet *planet;
    perigee_view_params params;
    struct pool *pool;
    struct scout *scout;
    struct windows *windows;
    struct geometry *geometry;
    frame frame;
    struct gpu_timer *timer;

    geo_camera camera;
    bool has_sun; // the sun stands in the direction `sun`; else always high over the camera
    dvec3 sun;    // unit vector, ECEF

    gaze gaze;             // of the last frame
    projection projection; // of the last frame, with `levels` of it
    int first, last, finest;
    bool dirty;        // something but the windows changed since the last frame
    bool placed_dirty; // the camera moved since vertices were placed
    bool outage;       // stand-ins outlasted the patience of who waited for a picture
    double clock_s;    // of the last frame
    perigee_stats stats;
};

// Sets up projection, levels and windows for the camera and a size; plans streaming.
status view_prepare(perigee_view *v, int width, int height);

// Draws into the light target, jittered by so many pixels; only what changed is done again.
void view_draw(perigee_view *v, double jitter_x, double jitter_y);

// Uploads what has come, advances the fades by the time since the last call, counts the bytes.
void view_stream(perigee_view *v);

// Adds the frame just drawn to the statistics.
void view_count_frame(perigee_view *v);

#endif
