#include "app/window_clock.h"

#include <math.h>
#include <stdio.h>
#include <time.h>

static const double rates[] = {-86400, -21600, -3600, -600, -60,  -10,   -1,
                               1,      10,     60,    600,  3600, 21600, 86400};
enum { RATES = sizeof rates / sizeof rates[0], TRUE_RATE = RATES / 2 };

#define DAY_S 86400.0
// 1900 to 2200: where the sun's formulas and four-digit years are safe.
#define TIME_MIN_S (-2208988800.0)
#define TIME_MAX_S 7258118400.0

struct window_clock window_clock_make(double unix_time_s)
{
    bool known = isfinite(unix_time_s);
    return (struct window_clock){known ? unix_time_s : (double)NAN, TRUE_RATE, known};
}

double window_clock_rate(const struct window_clock *clock)
{
    return clock->running ? rates[clock->speed] : 0;
}

void window_clock_step(struct window_clock *clock, double dt_s)
{
    if (!(dt_s > 0) || !clock->running) return;
    double t = clock->unix_time_s + dt_s * rates[clock->speed];
    clock->unix_time_s = fmin(fmax(t, TIME_MIN_S), TIME_MAX_S);
}

static void leave_noon(struct window_clock *clock, double now_s, double lon_deg)
{
    if (!isnan(clock->unix_time_s)) return;
    double day = floor(now_s / DAY_S) * DAY_S;
    clock->unix_time_s = day + (12 - lon_deg / 15) * 3600;
}

void window_clock_toggle(struct window_clock *clock, double now_s, double lon_deg)
{
    leave_noon(clock, now_s, lon_deg);
    clock->running = !clock->running;
}

void window_clock_change_speed(struct window_clock *clock, int change, double now_s, double lon_deg)
{
    leave_noon(clock, now_s, lon_deg);
    int speed = clock->speed + change;
    clock->speed = speed < 0 ? 0 : speed >= RATES ? RATES - 1 : speed;
    clock->running = true;
}

void window_clock_text(const struct window_clock *clock, char *text, size_t size)
{
    if (isnan(clock->unix_time_s)) {
        snprintf(text, size, "noon at the camera");
        return;
    }
    time_t seconds = (time_t)clock->unix_time_s;
    struct tm tm;
    char stamp[40] = "";
    if (gmtime_r(&seconds, &tm)) strftime(stamp, sizeof stamp, "%Y-%m-%d %H:%M:%S UTC", &tm);
    if (clock->running) snprintf(text, size, "%s, x%g", stamp, rates[clock->speed]);
    else snprintf(text, size, "%s, paused", stamp);
}
