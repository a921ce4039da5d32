// The overlay over the planet: position, frame, what is missing, attribution, help. One thin
// wrapper of Dear ImGui. Main only, with the window's GL context current.
#ifndef PERIGEE_APP_UI_H
#define PERIGEE_APP_UI_H

#include <stdbool.h>

#include "perigee.h"

#ifdef __cplusplus
extern "C" {
#endif

struct GLFWwindow;

struct ui_state {
    perigee_camera camera;
    double ground_m; // terrain below the camera
    double frame_ms;
    const char *modes[2];   // of the picture, or of the halves of a split; NULL: none
    perigee_stats stats[2]; // of these
    double difference;      // share of the rows, from below, that shows it; 0: none
    int gain;               // by which it is amplified
    const char *missing;    // lines; "" when complete
    int missing_count;
    const char *time;
    const char *attribution;
    const char *message; // shown for a while; "" when there is none
    bool flying;
    bool *help; // shown; cleared when its close button is pressed
};

// After the window's own callbacks are installed: the overlay's are chained to them. false when it
// cannot start.
bool ui_init(struct GLFWwindow *window, float scale);
void ui_deinit(void);

// Draws over the framebuffer bound now.
void ui_draw(const struct ui_state *state);

// true when the overlay takes what the mouse or the keyboard does now.
bool ui_wants_mouse(void);
bool ui_wants_keyboard(void);

#ifdef __cplusplus
}
#endif

#endif
