// Where the light comes from: day over the subsolar point, night over its antipode, the terminator
// the right way round. The expected places are from the almanac, not from src/geo.
#include "render/scene.h"

#include <stdlib.h>

enum { SIZE = 96 };

// Mean of the green plane over a band of columns, sky left out.
static double mean_light(const float *g, const float *z, int x0, int x1)
{
    double sum = 0;
    int count = 0;
    for (int y = 0; y < SIZE; y++) {
        for (int x = x0; x < x1; x++) {
            if (isnan(z[y * SIZE + x])) continue;
            sum += g[y * SIZE + x];
            count++;
        }
    }
    return count ? sum / count : NAN;
}

static double light_from(perigee_view *view, double lat, double lon, double time_s, double *left,
                         double *right)
{
    static float g[SIZE * SIZE], z[SIZE * SIZE];
    perigee_camera c = {
        .lat_deg = lat, .lon_deg = lon, .alt_m = 1.2e7, .pitch_deg = -90, .fov_deg = 50};
    assert_int_equal(perigee_view_set_time(view, time_s), 0);
    scene_render(view, &c, SIZE, SIZE);
    perigee_planes planes = {.g = g, .z_m = z};
    assert_int_equal(perigee_view_read_planes(view, &planes), 0);
    *left = mean_light(g, z, 0, SIZE / 2 - 8);
    *right = mean_light(g, z, SIZE / 2 + 8, SIZE);
    return mean_light(g, z, 0, SIZE);
}

static void test_day_and_night(void **state)
{
    (void)state;
    perigee_planet *planet = scene_planet();
    perigee_view *view = scene_view(planet, NULL);
    double left, right;
    // Solstice of June 2026, noon at Greenwich: the sun stands over 23.4 N, 0.5 E.
    const double solstice = 1782043200;
    double day = light_from(view, 23.4, 0.5, solstice, &left, &right);
    double night = light_from(view, -23.4, -179.5, solstice, &left, &right);
    print_message("day %.4f, night %.4f\n", day, night);
    assert_true(day > 0.05);
    assert_true(night < 0.05 * day);
    // Both poles: the northern one lit, the southern one dark.
    double north = light_from(view, 90, 0, solstice, &left, &right);
    double south = light_from(view, -90, 0, solstice, &left, &right);
    print_message("north %.4f, south %.4f\n", north, south);
    assert_true(south < 0.3 * north);
    // Equinox of March 2026, noon at Greenwich: seen from 90 E, north up, the sun is in the west,
    // which is left.
    light_from(view, 0, 90, 1774008000, &left, &right);
    print_message("west %.4f, east %.4f\n", left, right);
    assert_true(right < 0.2 * left);
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
}

// A direction in place of a time: the lit side follows it, its length does not matter, and the time
// is taken back by it.
static void test_sun_of_a_direction(void **state)
{
    (void)state;
    static float g[SIZE * SIZE], again[SIZE * SIZE];
    perigee_planet *planet = scene_planet();
    perigee_view *view = scene_view(planet, NULL);
    perigee_planes planes = {.g = g};
    double left, right;
    perigee_camera c = {.alt_m = 1.2e7, .pitch_deg = -90, .fov_deg = 50};
    for (int side = -1; side <= 1; side += 2) {
        light_from(view, 0, 0, 1782043200, &left, &right); // some time
        const double to_sun[3] = {0, side, 0}, far_sun[3] = {0, side * 1.5e11, 0};
        assert_int_equal(perigee_view_set_sun(view, to_sun), 0);
        scene_render(view, &c, SIZE, SIZE);
        planes.g = g;
        assert_int_equal(perigee_view_read_planes(view, &planes), 0);
        double west = g[SIZE / 2 * SIZE + SIZE / 4], east = g[SIZE / 2 * SIZE + SIZE * 3 / 4];
        print_message("sun over %d E: west %.4f, east %.4f\n", 90 * side, west, east);
        assert_true(side > 0 ? west < 0.2 * east : east < 0.2 * west);
        assert_int_equal(perigee_view_set_sun(view, far_sun), 0);
        scene_render(view, &c, SIZE, SIZE);
        planes.g = again;
        assert_int_equal(perigee_view_read_planes(view, &planes), 0);
        assert_memory_equal(g, again, sizeof g);
    }
    const double nowhere[3] = {0}, wrong[3] = {0, NAN, 1}, beyond[3] = {INFINITY, 0, 1};
    assert_int_not_equal(perigee_view_set_sun(view, nowhere), 0);
    assert_non_null(strstr(perigee_last_error(), "impossible direction of the sun: 0 0 0"));
    assert_int_not_equal(perigee_view_set_sun(view, wrong), 0);
    assert_int_not_equal(perigee_view_set_sun(view, beyond), 0);
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
}

// Without a time it is day everywhere, and crossing a pole or the date line changes nothing at
// once.
static void test_perpetual_day(void **state)
{
    (void)state;
    perigee_planet *planet = scene_planet();
    perigee_view *view = scene_view(planet, NULL);
    double left, right, reference = light_from(view, 0, 0, 1782043200, &left, &right);
    static float g[SIZE * SIZE], z[SIZE * SIZE];
    const double places[][2] = {{0, 0}, {50, 120}, {-60, -100}, {90, 0}, {-90, 50}, {10, 180}};
    perigee_view_set_time_noon(view);
    for (int i = 0; i < 6; i++) {
        perigee_camera c = {.lat_deg = places[i][0],
                            .lon_deg = places[i][1],
                            .alt_m = 1.2e7,
                            .pitch_deg = -90,
                            .fov_deg = 50};
        scene_render(view, &c, SIZE, SIZE);
        perigee_planes planes = {.g = g, .z_m = z};
        assert_int_equal(perigee_view_read_planes(view, &planes), 0);
        assert_true(mean_light(g, z, 0, SIZE) > 0.4 * reference);
    }
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
}

// The colour windows' coarsest level has nothing coarser to blend with: from far away, in few
// pixels, the planet keeps its colour. (It was grey once: level 0 gave its share away.)
static void test_far_and_small_keeps_its_light(void **state)
{
    (void)state;
    perigee_planet *planet = scene_planet();
    perigee_view *view = scene_view(planet, NULL);
    double near = 0;
    for (int i = 0; i < 4; i++) {
        static float g[SIZE * SIZE], b[SIZE * SIZE], z[SIZE * SIZE];
        perigee_camera c = {.lat_deg = 24,
                            .lon_deg = 10,
                            .alt_m = 1e7 * pow(2, i),
                            .pitch_deg = -90,
                            .fov_deg = 60};
        scene_render(view, &c, SIZE, SIZE);
        perigee_planes planes = {.g = g, .b = b, .z_m = z};
        assert_int_equal(perigee_view_read_planes(view, &planes), 0);
        double at_nadir = g[(SIZE / 2) * SIZE + SIZE / 2];
        print_message("%g m: %.4f\n", c.alt_m, at_nadir);
        if (i == 0) near = at_nadir;
        check_near(at_nadir, near, 0.05 * near);
    }
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
}

struct lights {
    float r[SIZE * SIZE], g[SIZE * SIZE], b[SIZE * SIZE];
};

static void see_by(const char *compute, const perigee_camera *c, struct lights *out)
{
    perigee_planet *planet = scene_planet();
    setenv("PERIGEE_COMPUTE", compute, 1);
    perigee_view *view = scene_view(planet, NULL);
    unsetenv("PERIGEE_COMPUTE");
    scene_render(view, c, SIZE, SIZE);
    perigee_planes planes = {.r = out->r, .g = out->g, .b = out->b};
    assert_int_equal(perigee_view_read_planes(view, &planes), 0);
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
}

// What a graphics card shades by a compute shader and a software driver by fragments, planet and
// sky. Mutations: a pixel's ray half a pixel off; the sky left out.
static void test_two_ways_to_shade(void **state)
{
    (void)state;
    static struct lights fragments, compute;
    perigee_camera cameras[] = {
        {.lat_deg = 10, .lon_deg = 20, .alt_m = 1.2e7, .pitch_deg = -90, .fov_deg = 70},
        {.lat_deg = 40, .lon_deg = 12, .pitch_deg = -5, .fov_deg = 60},
    };
    cameras[1].alt_m = 150 + analytic_height(40 * M_PI / 180, 12 * M_PI / 180);
    for (int i = 0; i < 2; i++) {
        double worst = 0, lit = 0;
        see_by("0", &cameras[i], &fragments);
        see_by("1", &cameras[i], &compute);
        for (int k = 0; k < SIZE * SIZE; k++) {
            const double a[] = {fragments.r[k], fragments.g[k], fragments.b[k]};
            const double b[] = {compute.r[k], compute.g[k], compute.b[k]};
            for (int c = 0; c < 3; c++) {
                worst = fmax(worst, fabs(scene_encoded(a[c]) - scene_encoded(b[c])));
                lit += a[c] > 0.02;
            }
        }
        print_message("%g m up: at most %.3f / 255\n", cameras[i].alt_m, worst);
        assert_true(lit > SIZE * SIZE / 2);
        assert_true(worst <= 0.25);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_day_and_night),
        cmocka_unit_test(test_sun_of_a_direction),
        cmocka_unit_test(test_perpetual_day),
        cmocka_unit_test(test_far_and_small_keeps_its_light),
        cmocka_unit_test(test_two_ways_to_shade),
    };
    int rc = scene_open();
    return rc ? rc : scene_close(cmocka_run_group_tests(tests, NULL, NULL));
}
