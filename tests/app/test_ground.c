// Terrain for the camera: exact when it could be met, never waited for when it cannot.
#include "check.h"

#include <time.h>
#include <unistd.h>

#include "app/window_ground.h"
#include "planet/analytic_planet.h"

#define DEG    (M_PI / 180)
#define PLANET "ground.planet"

static perigee_planet *planet;

static double truth(double lat, double lon)
{
    double height = NAN;
    assert_int_equal(perigee_planet_height(planet, lat / DEG, lon / DEG, &height), 0);
    return height;
}

static void wait_for_news(struct window_ground *g)
{
    for (int i = 0; i < 2000; i++) {
        if (window_ground_take_news(g)) return;
        nanosleep(&(struct timespec){0, 5000000}, NULL);
    }
    fail_msg("the worker does not answer");
}

// Near the ground too nobody waits: nothing is known at first, what was read is exact.
static void exact_when_near(void **state)
{
    (void)state;
    perigee_planet *fresh;
    assert_int_equal(perigee_planet_open(PLANET, NULL, &fresh), 0);
    struct window_ground *g = window_ground_create(fresh);
    for (int i = 0; i < 8; i++) {
        double lat = (-80 + 20 * i) * DEG, lon = (i * 50 - 180) * DEG, exact = truth(lat, lon);
        double first = window_ground_at(g, lat, lon, 10); // from tiles of the places before
        assert_true(i ? fabs(first - exact) < 12e3 : isnan(first));
        wait_for_news(g);
        check_near(window_ground_at(g, lat, lon, 10), exact, 0);
        check_near(window_ground_at(g, lat + 1e-7, lon, 10), truth(lat + 1e-7, lon), 0);
    }
    window_ground_destroy(&g);
    assert_null(g);
    perigee_planet_close(&fresh);
}

static void guesses_do_not_wait(void **state)
{
    (void)state;
    struct window_ground *g = window_ground_create(planet);
    assert_true(isnan(window_ground_at(g, 0.5, 0.5, INFINITY)));
    wait_for_news(g);
    check_near(window_ground_at(g, 0.5, 0.5, INFINITY), truth(0.5, 0.5), 0);
    assert_false(window_ground_take_news(g));
    // Half a kilometre on, from 10 km above, the neighbour's answer does until the place's own is
    // there.
    check_near(window_ground_at(g, 0.5001, 0.5, 10e3), truth(0.5, 0.5), 0);
    wait_for_news(g);
    check_near(window_ground_at(g, 0.5001, 0.5, 10e3), truth(0.5001, 0.5), 0);
    check_near(window_ground_at(g, 1, 1, 300e3), 0, 0);
    window_ground_destroy(&g);
}

// Over a random walk on ground that is in memory nobody who trusts the answer meets the terrain.
static void never_off_by_more_than_the_room(void **state)
{
    (void)state;
    struct check_random r = {31};
    struct window_ground *g = window_ground_create(planet);
    double lat = 0.3, lon = 3.1;
    for (int i = 0; i < 400; i++) {
        double room = pow(10, check_random_range(&r, 0, 5));
        lat += check_random_range(&r, -1, 1) * room / 6.4e6;
        lon += check_random_range(&r, -1, 1) * room / 6.4e6;
        double exact = truth(lat, lon);
        assert_true(exact < window_ground_at(g, lat, lon, room) + room);
    }
    window_ground_destroy(&g);
}

static int open_planet(void **state)
{
    (void)state;
    if (access(PLANET, F_OK) != 0 && analytic_planet_make(PLANET, 3) != 0) return -1;
    return perigee_planet_open(PLANET, NULL, &planet);
}

static int close_planet(void **state)
{
    (void)state;
    perigee_planet_close(&planet);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(exact_when_near),
        cmocka_unit_test(guesses_do_not_wait),
        cmocka_unit_test(never_off_by_more_than_the_room),
    };
    return cmocka_run_group_tests(tests, open_planet, close_planet);
}
