// The persistent grid's mode: what it refuses, that its frames depend on nothing but the camera,
// what it counts, that a view of nothing is nothing.
#include "render/scene.h"

#include "render/view.h"

static const perigee_camera AIR = {.lat_deg = 46,
                                   .lon_deg = -179.98,
                                   .alt_m = 9000,
                                   .heading_deg = 280,
                                   .pitch_deg = -12,
                                   .roll_deg = 7,
                                   .fov_deg = 70};

static void refused(perigee_planet *planet, perigee_view_params params, const char *why)
{
    perigee_view *view;
    params.mode = PERIGEE_MODE_GRID;
    assert_int_not_equal(perigee_view_create(planet, &params, &view), 0);
    assert_null(view);
    if (!strstr(perigee_last_error(), why))
        fail_msg("'%s' does not say '%s'", perigee_last_error(), why);
}

static void test_impossible_grids(void **state)
{
    (void)state;
    perigee_planet *planet = scene_planet();
    refused(planet, (perigee_view_params){.grid_rows = 1, .grid_columns = 9}, "1 x 9");
    refused(planet, (perigee_view_params){.grid_rows = 0, .grid_columns = 9}, "0 x 9");
    refused(planet, (perigee_view_params){.grid_rows = -3, .grid_columns = 9}, "-3 x 9");
    refused(planet, (perigee_view_params){.grid_rows = 5000, .grid_columns = 9}, "5000 x 9");
    refused(planet, (perigee_view_params){.grid_rows = 4096, .grid_columns = 4096}, "4194304");
    refused(planet, (perigee_view_params){.grid_denser = 0.95}, "0.95");
    refused(planet, (perigee_view_params){.grid_denser = NAN}, "nan");
    perigee_planet_close(&planet);
}

// The lowest ground bounds the camera; the rings can look at it from below.
static void test_inside_the_planet(void **state)
{
    (void)state;
    perigee_planet *planet = scene_planet();
    perigee_planet_info info;
    perigee_planet_get_info(planet, &info);
    perigee_view_params params = {.mode = PERIGEE_MODE_GRID, .grid_rows = 40, .grid_columns = 50};
    perigee_view *view = scene_view(planet, &params);
    perigee_camera c = AIR;
    c.alt_m = info.height_min_m - 1;
    assert_int_not_equal(perigee_view_set_camera(view, &c), 0);
    assert_non_null(strstr(perigee_last_error(), "altitude"));
    c.alt_m = info.height_min_m + 1; // under most of the ground: a frame, if a strange one
    scene_render(view, &c, 64, 48);
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
}

static void read_depth(perigee_view *view, float *z)
{
    perigee_planes planes = {.z_m = z};
    assert_int_equal(perigee_view_read_planes(view, &planes), 0);
}

// By whatever way the camera has come, the frame has the same bits.
static void test_same_frame_by_any_way(void **state)
{
    (void)state;
    enum { N = SCENE_WIDTH * SCENE_HEIGHT };
    static float direct[N], travelled[N], turned[N];
    perigee_planet *planet = scene_planet();
    perigee_view_params params = {.mode = PERIGEE_MODE_GRID};
    perigee_view *a = scene_view(planet, &params), *b = scene_view(planet, &params);
    scene_render(a, &AIR, SCENE_WIDTH, SCENE_HEIGHT);
    read_depth(a, direct);
    perigee_camera c = AIR;
    for (int i = 0; i < 3; i++) {
        c.lat_deg = AIR.lat_deg - 0.3 * (3 - i);
        c.alt_m = AIR.alt_m * (4 - i);
        scene_render(b, &c, SCENE_WIDTH, SCENE_HEIGHT);
    }
    scene_render(b, &AIR, SCENE_WIDTH, SCENE_HEIGHT);
    read_depth(b, travelled);
    assert_memory_equal(direct, travelled, sizeof direct);
    c = AIR; // a turn alone throws the rays anew
    c.heading_deg += 1;
    scene_render(b, &c, SCENE_WIDTH, SCENE_HEIGHT);
    read_depth(b, turned);
    assert_memory_not_equal(direct, turned, sizeof direct);
    perigee_view_destroy(&a);
    perigee_view_destroy(&b);
    perigee_planet_close(&planet);
}

// The grid's base follows the bounds of the windows' heights: those too must not remember what the
// windows held on the way, a few samples beside where they come to rest.
static void test_same_bounds_by_any_way(void **state)
{
    (void)state;
    enum { N = SCENE_WIDTH * SCENE_HEIGHT, STEPS = 24 };
    static const double ways[][2] = {{1, 0}, {-0.4, 1}, {0.3, -1}}; // degrees north, east; of 100
    static float direct[N], travelled[N];
    perigee_planet *planet = scene_planet();
    perigee_view_params params = {.mode = PERIGEE_MODE_GRID};
    perigee_view *a = scene_view(planet, &params), *b = scene_view(planet, &params);
    scene_render(a, &AIR, SCENE_WIDTH, SCENE_HEIGHT);
    read_depth(a, direct);
    for (int way = 0; way < 3; way++) {
        for (int i = STEPS; i >= 0; i--) {
            perigee_camera c = AIR;
            c.lat_deg += 0.01 * i * ways[way][0];
            c.lon_deg += 0.01 * i * ways[way][1];
            scene_render(b, &c, i ? 64 : SCENE_WIDTH, i ? 48 : SCENE_HEIGHT);
        }
        for (int level = 0; level <= windows_last_height(a->windows); level++) {
            double low[2], high[2];
            windows_height_bounds(a->windows, level, &low[0], &high[0]);
            windows_height_bounds(b->windows, level, &low[1], &high[1]);
            if (low[0] == low[1] && high[0] == high[1]) continue;
            fail_msg("way %d, level %d: %.9g to %.9g m, but %.9g to %.9g m directly", way, level,
                     low[1], high[1], low[0], high[0]);
        }
        read_depth(b, travelled);
        assert_memory_equal(direct, travelled, sizeof direct);
    }
    perigee_view_destroy(&a);
    perigee_view_destroy(&b);
    perigee_planet_close(&planet);
}

// Every vertex is placed once when the camera moves and none when it does not; the triangles are
// always as many, but for a frame of sky, which has none.
static void test_counts(void **state)
{
    (void)state;
    perigee_planet *planet = scene_planet();
    perigee_view_params params = {.mode = PERIGEE_MODE_GRID, .grid_rows = 31, .grid_columns = 43};
    perigee_view *view = scene_view(planet, &params);
    perigee_stats s;
    scene_render(view, &AIR, SCENE_WIDTH, SCENE_HEIGHT);
    perigee_view_get_stats(view, &s);
    assert_int_equal(s.triangles_drawn, 2 * 30 * 42);
    assert_int_equal(s.vertices_placed, 31 * 43);
    scene_render(view, &AIR, SCENE_WIDTH, SCENE_HEIGHT);
    perigee_view_get_stats(view, &s);
    assert_int_equal(s.vertices_placed, 0);
    perigee_camera sky = AIR;
    sky.alt_m = 1e6;
    sky.pitch_deg = 60;
    scene_render(view, &sky, SCENE_WIDTH, SCENE_HEIGHT);
    perigee_view_get_stats(view, &s);
    assert_int_equal(s.triangles_drawn, 0);
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_impossible_grids), cmocka_unit_test(test_inside_the_planet),
        cmocka_unit_test(test_same_frame_by_any_way), cmocka_unit_test(test_same_bounds_by_any_way),
        cmocka_unit_test(test_counts)};
    int rc = scene_open();
    return rc ? rc : scene_close(cmocka_run_group_tests(tests, NULL, NULL));
}
