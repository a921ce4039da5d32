// What a frame costs, by counters: nothing when nothing moved, the strip's area when the camera
// did, never more than the budget; memory fixed.
#include "render/scene.h"

static void test_still_camera_costs_nothing(void **state)
{
    (void)state;
    perigee_planet *planet = scene_planet();
    perigee_view *view = scene_view(planet, NULL);
    perigee_camera c = {
        .lat_deg = 45, .lon_deg = 11, .alt_m = 9000, .pitch_deg = -20, .fov_deg = 60};
    perigee_stats s;
    scene_render(view, &c, SCENE_WIDTH, SCENE_HEIGHT);
    perigee_view_get_stats(view, &s);
    assert_true(s.vertices_placed > 0);
    assert_true(s.total_bytes_uploaded > 0);
    for (int i = 0; i < 3; i++) {
        scene_render(view, &c, SCENE_WIDTH, SCENE_HEIGHT);
        perigee_view_get_stats(view, &s);
        assert_int_equal(s.vertices_placed, 0);
        assert_int_equal(s.bytes_uploaded, 0);
        assert_false(s.needs_redraw);
    }
    // Turning on the spot places only cells that come into view, once.
    for (int turn = 0; turn < 2; turn++) {
        uint64_t placed = 0;
        for (int k = 0; k < 8; k++) {
            c.heading_deg = 45 * k;
            scene_render(view, &c, SCENE_WIDTH, SCENE_HEIGHT);
            perigee_view_get_stats(view, &s);
            assert_int_equal(s.bytes_uploaded, 0);
            placed += s.vertices_placed;
        }
        if (turn) assert_int_equal(placed, 0);
        else assert_true(placed > 0);
    }
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
}

// 250 m/s at 10 m above ground, 60 frames a second: 4.2 m a frame. Level 22's sample is 3.7 cm: a
// frame brings 112 of its 336 rows, half of that for the next, and so on.
static void test_flight_uploads_strips(void **state)
{
    (void)state;
    perigee_planet *planet = scene_planet();
    perigee_view *view = scene_view(planet, NULL);
    double lat = 45, lon = 11, step = 250.0 / 60 / 111132;
    perigee_camera c = {.lat_deg = lat, .lon_deg = lon, .pitch_deg = -5, .fov_deg = 60};
    c.alt_m = analytic_height(lat * M_PI / 180, lon * M_PI / 180) + 10;
    perigee_stats s;
    scene_render(view, &c, SCENE_WIDTH, SCENE_HEIGHT);
    perigee_view_get_stats(view, &s);
    uint64_t before = s.total_bytes_uploaded, start = before;
    assert_int_equal(s.last_level, 21);
    // Strip area of a northward step: rows * 512 columns * 4 bytes, summed over levels, plus a row
    // each for the snapping. The heights are a level finer than the rings.
    double rows = 0;
    for (int level = 1; level <= 22; level++)
        rows += step * M_PI / 180 / (M_PI / 128 * pow(0.5, level));
    double strip = rows * 512 * 4, window = 336.0 * 512 * 4;
    uint64_t worst = 0;
    for (int i = 1; i <= 20; i++) {
        c.lat_deg = lat + i * step;
        scene_render(view, &c, SCENE_WIDTH, SCENE_HEIGHT);
        perigee_view_get_stats(view, &s);
        if (s.total_bytes_uploaded - before > worst) worst = s.total_bytes_uploaded - before;
        before = s.total_bytes_uploaded;
    }
    print_message("bytes a frame: mean %.0f, worst %llu; strip area %.0f, one window %.0f\n",
                  (double)(before - start) / 20, (unsigned long long)worst, strip, window);
    assert_true((double)(before - start) / 20 <= 1.2 * strip);
    assert_true((double)worst <= strip + 24 * 2 * 512 * 4 + 0.2 * strip);
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
}

static void test_budget_and_memory(void **state)
{
    (void)state;
    perigee_planet *planet = scene_planet();
    perigee_view_params params = {.upload_bytes_frame = 1 << 20};
    perigee_view *view = scene_view(planet, &params);
    perigee_stats first, s;
    perigee_view_get_stats(view, &first);
    print_message("GPU memory: %.1f MiB\n", (double)first.gpu_bytes / 1048576);
    assert_true(first.gpu_bytes <= (size_t)122 << 20);
    perigee_camera c = {
        .lat_deg = -30, .lon_deg = 100, .alt_m = 20000, .pitch_deg = -30, .fov_deg = 60};
    assert_int_equal(perigee_view_set_camera(view, &c), 0);
    for (int i = 0; i < 200; i++) {
        assert_int_equal(perigee_view_render(view, SCENE_WIDTH, SCENE_HEIGHT), 0);
        perigee_view_get_stats(view, &s);
        assert_true(s.bytes_uploaded <= 1 << 20);
        assert_int_equal(s.gpu_bytes, first.gpu_bytes);
    }
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
}

// Clasen & Hege 2006, 5.2: ground view, n = 512, 20 rings, levels 6 to 21, about 330,000 triangles.
static void test_triangles_of_the_paper(void **state)
{
    (void)state;
    perigee_planet *planet = scene_planet();
    perigee_view_params params = {
        .azimuth_steps = 512, .rings_per_level = 20, .first_level = 6, .last_level = 21};
    perigee_view *view = scene_view(planet, &params);
    perigee_camera c = {.lat_deg = 45.45, .lon_deg = 10.75, .heading_deg = 320, .fov_deg = 60};
    c.alt_m = analytic_height(c.lat_deg * M_PI / 180, c.lon_deg * M_PI / 180) + 2;
    scene_render(view, &c, 1280, 960);
    perigee_stats s;
    perigee_view_get_stats(view, &s);
    print_message("%llu triangles, %llu after culling, %llu vertices placed, %llu draws\n",
                  (unsigned long long)s.triangles_total, (unsigned long long)s.triangles_drawn,
                  (unsigned long long)s.vertices_placed, (unsigned long long)s.draws);
    assert_in_range(s.triangles_total, 327680, 345000);
    assert_true(s.triangles_drawn < s.triangles_total / 2);
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_still_camera_costs_nothing),
        cmocka_unit_test(test_flight_uploads_strips),
        cmocka_unit_test(test_budget_and_memory),
        cmocka_unit_test(test_triangles_of_the_paper),
    };
    int rc = scene_open();
    return rc ? rc : scene_close(cmocka_run_group_tests(tests, NULL, NULL));
}
