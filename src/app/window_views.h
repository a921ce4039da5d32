// What a window shows of a planet: one mode, or two side by side at the same camera with their
// difference. The modes are those that the library lists (perigee_mode_name). Main only, with the
// GL context current.
//
// A split has a view for each half, each with windows, mesh and workers of its own: GPU memory and
// threads double while it is on, and are given back when it is off. While a mode is exchanged there
// is one view more.
#ifndef PERIGEE_APP_WINDOW_VIEWS_H
#define PERIGEE_APP_WINDOW_VIEWS_H

#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"
#include "perigee.h"

struct window_views;

// Of the encoded colours, in the pictures of a split.
#define WINDOW_VIEWS_GAIN 16

// planet: borrowed. params: of all views but for the mode, which is the first one's; NULL: the
// defaults. Logged.
status window_views_create(perigee_planet *planet, const perigee_view_params *params,
                           struct window_views **out);
void window_views_destroy(struct window_views **views);

// The next mode, after the last the first; of the right half in a split. On failure, which is
// logged, all stays as it was, and the next call tries the mode after the refused one.
status window_views_next_mode(struct window_views *views);

// On: the right half has the mode after the left one's. Off: the left one stays. Size of the
// pictures in pixels. On failure, which is logged, all stays as it was.
status window_views_toggle_split(struct window_views *views, int width, int height);
bool window_views_is_split(const struct window_views *views);

// The share of a split's rows, from below, that shows the difference: a third at first, then all of
// them, none, a third.
void window_views_next_difference(struct window_views *views);
double window_views_difference(const struct window_views *views);

// The name of the mode; side 1 is the right half of a split (else NULL).
const char *window_views_mode(const struct window_views *views, int side);

// Draws one frame of (0, 0, width, height) into `framebuffer`. unix_time_s: of the sun; NaN: noon.
status window_views_render(struct window_views *views, const perigee_camera *camera,
                           double unix_time_s, int width, int height, unsigned framebuffer);

// The picture as it would be drawn now, but supersampled where there is no split. rgb: width *
// height * 3 bytes, top row first.
status window_views_picture(struct window_views *views, const perigee_camera *camera,
                            double unix_time_s, int width, int height, uint8_t *rgb);

// Of a side as above; all zero when it is not there.
perigee_stats window_views_stats(const struct window_views *views, int side);
bool window_views_need_redraw(const struct window_views *views);
// As perigee_view_missing, of both sides.
int window_views_missing(const struct window_views *views, char *text, size_t size);
// As perigee_view_pick.
bool window_views_pick(struct window_views *views, double x_px, double y_px, double *lat_deg,
                       double *lon_deg, double *height_m);

#endif
