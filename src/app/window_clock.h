// The time that moves the sun: stands at noon over the camera until the user starts it. Plain
// value. Main only.
#ifndef PERIGEE_APP_WINDOW_CLOCK_H
#define PERIGEE_APP_WINDOW_CLOCK_H

#include <stdbool.h>
#include <stddef.h>

struct window_clock {
    double unix_time_s; // NaN: perpetual noon
    int speed;          // index into the rates
    bool running;
};

// From a time (running at the true rate) or NaN (perpetual noon).
struct window_clock window_clock_make(double unix_time_s);

void window_clock_step(struct window_clock *clock, double dt_s);

// Leaves perpetual noon for the same sun on the day of `now_s`, at the camera's longitude.
void window_clock_toggle(struct window_clock *clock, double now_s, double lon_deg);
// One rate faster (1) or slower (-1); beyond the true rate backwards.
void window_clock_change_speed(struct window_clock *clock, int change, double now_s,
                               double lon_deg);

// Seconds of planet time a second; 0 while paused.
double window_clock_rate(const struct window_clock *clock);

// "2024-06-21 12:00:00 UTC, x60", "noon at the camera".
void window_clock_text(const struct window_clock *clock, char *text, size_t size);

#endif
