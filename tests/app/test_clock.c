// The window's clock: noon until started, rates both ways, texts.
#include "check.h"

#include "app/window_clock.h"

#define NOW_S 1718972400.0 // 2024-06-21 12:20:00 UTC

static void noon_until_started(void **state)
{
    (void)state;
    struct window_clock c = window_clock_make(NAN);
    char text[80];
    window_clock_step(&c, 100);
    assert_true(isnan(c.unix_time_s));
    check_near(window_clock_rate(&c), 0, 0);
    window_clock_text(&c, text, sizeof text);
    assert_string_equal(text, "noon at the camera");
    // Noon at 45 E is 9:00 UTC.
    window_clock_toggle(&c, NOW_S, 45);
    check_near(c.unix_time_s, NOW_S - 20 * 60 - 3 * 3600, 0);
    window_clock_step(&c, 100);
    check_near(c.unix_time_s, NOW_S - 20 * 60 - 3 * 3600 + 100, 0);
}

static void rates_and_pause(void **state)
{
    (void)state;
    struct window_clock c = window_clock_make(NOW_S);
    char text[80];
    window_clock_step(&c, 2);
    check_near(c.unix_time_s, NOW_S + 2, 0);
    window_clock_change_speed(&c, 1, 0, 0);
    window_clock_change_speed(&c, 1, 0, 0);
    window_clock_step(&c, 2);
    check_near(c.unix_time_s, NOW_S + 2 + 120, 0);
    window_clock_text(&c, text, sizeof text);
    assert_string_equal(text, "2024-06-21 12:22:02 UTC, x60");
    window_clock_toggle(&c, 0, 0);
    window_clock_step(&c, 1e6);
    check_near(c.unix_time_s, NOW_S + 122, 0);
    window_clock_text(&c, text, sizeof text);
    assert_string_equal(text, "2024-06-21 12:22:02 UTC, paused");
    for (int i = 0; i < 3; i++) window_clock_change_speed(&c, -1, 0, 0);
    check_near(window_clock_rate(&c), -1, 0);
}

static void stays_within_four_digit_years(void **state)
{
    (void)state;
    struct window_clock c = window_clock_make(NOW_S);
    for (int i = 0; i < 100; i++) window_clock_change_speed(&c, 1, 0, 0);
    check_near(window_clock_rate(&c), 86400, 0);
    window_clock_step(&c, 1e9);
    check_near(c.unix_time_s, 7258118400.0, 0); // 2200-01-01
    for (int i = 0; i < 100; i++) window_clock_change_speed(&c, -1, 0, 0);
    window_clock_step(&c, 1e9);
    check_near(c.unix_time_s, -2208988800.0, 0); // 1900-01-01
    double before = c.unix_time_s;
    window_clock_step(&c, NAN);
    window_clock_step(&c, -5);
    check_near(c.unix_time_s, before, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(noon_until_started),
        cmocka_unit_test(rates_and_pause),
        cmocka_unit_test(stays_within_four_digit_years),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
