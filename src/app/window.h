// The interactive window: a planet, a camera controller and the overlay, redrawn only when
// something changed. Main only.
#ifndef PERIGEE_APP_WINDOW_H
#define PERIGEE_APP_WINDOW_H

#include <stdbool.h>

#include "perigee.h"

struct window_params {
    perigee_planet *planet;          // borrowed
    const perigee_view_params *view; // NULL: the defaults
    perigee_camera start;            // also the home view
    int width, height;               // of the picture; 0: 1280 x 800
    bool vsync;
    double unix_time_s;         // NaN: noon at the camera
    const char *screenshot_dir; // NULL: the current folder
    const char *attribution;    // NULL: the planet's own
    double run_s;               // > 0: closes by itself after so many seconds
    int frames;                 // > 0: redraws all the time and closes after so many frames
    const char *title;          // NULL: Perigee
};

// true when a window can be opened here: DISPLAY or WAYLAND_DISPLAY is set and answers. Says
// nothing.
bool window_display_available(void);

// Shows the window until the user closes it. Returns the exit status: 0, or 1 after one line on
// what went wrong.
int window_run(const struct window_params *params);

#endif
