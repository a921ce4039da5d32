// The same camera gives the same pixels, whatever the thread count and whatever was seen before.
#include "render/scene.h"

enum { BYTES = SCENE_WIDTH * SCENE_HEIGHT * 3 };

static const perigee_camera STOPS[] = {
    {.lat_deg = 45.5, .lon_deg = 10.7, .alt_m = 2e7, .pitch_deg = -90, .fov_deg = 60},
    {.lat_deg = 45.5,
     .lon_deg = 10.7,
     .alt_m = 30000,
     .pitch_deg = -20,
     .heading_deg = 300,
     .fov_deg = 60},
    {.lat_deg = 89.999,
     .lon_deg = -60,
     .alt_m = 12000,
     .pitch_deg = -10,
     .heading_deg = 5,
     .fov_deg = 60},
    {.lat_deg = 12,
     .lon_deg = 179.9999,
     .alt_m = 9000,
     .pitch_deg = -5,
     .heading_deg = 90,
     .fov_deg = 60},
};
enum { STOP_COUNT = sizeof STOPS / sizeof *STOPS };

static void shoot(perigee_view *view, const perigee_camera *c, uint8_t *rgb)
{
    assert_int_equal(perigee_view_set_camera(view, c), 0);
    assert_int_equal(perigee_view_wait(view, SCENE_WIDTH, SCENE_HEIGHT, 60), 0);
    assert_int_equal(perigee_view_render_image(view, SCENE_WIDTH, SCENE_HEIGHT, 1, rgb), 0);
}

static void test_threads_and_paths(void **state)
{
    (void)state;
    static uint8_t first[STOP_COUNT][BYTES], again[BYTES];
    perigee_planet *planet = scene_planet();
    perigee_view_params params = {.threads = 1};
    perigee_view *view = scene_view(planet, &params);
    scene_render(view, &STOPS[0], SCENE_WIDTH, SCENE_HEIGHT); // binds a framebuffer
    for (int i = 0; i < STOP_COUNT; i++) shoot(view, &STOPS[i], first[i]);
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);

    planet = scene_planet();
    params.threads = 8;
    view = scene_view(planet, &params);
    for (int i = STOP_COUNT - 1; i >= 0;
         i--) { // the other way round, with a detour and without waiting
        perigee_camera detour = STOPS[i];
        detour.lat_deg -= 0.3;
        for (int k = 0; k < 6; k++) {
            detour.lat_deg += 0.04;
            assert_int_equal(perigee_view_set_camera(view, &detour), 0);
            assert_int_equal(perigee_view_render(view, SCENE_WIDTH, SCENE_HEIGHT), 0);
        }
        shoot(view, &STOPS[i], again);
        int differing = 0, lit = 0;
        for (int k = 0; k < BYTES; k++) {
            differing += first[i][k] != again[k];
            lit += again[k] > 40;
        }
        print_message("stop %d: %d of %d bytes differ\n", i, differing, BYTES);
        assert_true(lit > BYTES / 20);
        assert_int_equal(differing, 0);
    }
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_threads_and_paths)};
    int rc = scene_open();
    return rc ? rc : scene_close(cmocka_run_group_tests(tests, NULL, NULL));
}
