// Windows made on the GPU from residuals against windows filled by the processor: the same bits,
// in flight and at rest, at the antimeridian, where columns double and at a pole; and the picture
// that they give. The rounding is the test's own arithmetic.
#include "render/temporal.h"

#include "clipmap/clipmap.h"
#include "gpu/gpu_fixture.h"
#include "render/view.h"

static const double RAD = M_PI / 180;

static const perigee_view_params PLAIN = {.mode = PERIGEE_MODE_PLANAR, .texels = 256};

// What heights of a zoom are whole multiples of: perigee.h.
static double quantum_of(int zoom)
{
    return fmax(ldexp(1, 5 - zoom), ldexp(1, -10));
}

static float *filled_by_the_processor(perigee_view *view, const window *held, window_shape shape)
{
    window_rect r = held->rect;
    size_t cols = (size_t)(r.col1 - r.col0), count = (size_t)(r.row1 - r.row0) * cols;
    float *heights = calloc(count, sizeof *heights);
    double q = quantum_of(held->zoom);
    assert_non_null(heights);
    assert_int_equal(clipmap_fill(view->planet->pyramid, LAYER_HEIGHT, &shape, held, r, heights),
                     OK);
    for (size_t i = 0; i < count; i++)
        heights[i] = (float)(nearbyint((double)heights[i] / q) * q + 0.0);
    return heights;
}

// Returns the samples that differ in any bit.
static size_t check_level(perigee_view *view, int level, const float *texture)
{
    window_shape shape = windows_height_samples(view->windows);
    window held = windows_held(view->windows, level);
    float *want = filled_by_the_processor(view, &held, shape);
    const float *next = want;
    size_t different = 0;
    for (int64_t row = held.rect.row0; row < held.rect.row1; row++) {
        const float *line = texture + (size_t)window_texel(row, shape.rows) * (size_t)shape.cols;
        for (int64_t col = held.rect.col0; col < held.rect.col1; col++, next++)
            different += memcmp(line + window_texel(col, shape.cols), next, sizeof *next) != 0;
    }
    free(want);
    return different;
}

static void check_windows(perigee_view *view, const char *where)
{
    window_shape shape = windows_height_samples(view->windows);
    size_t count = (size_t)shape.rows * (size_t)shape.cols, different = 0;
    float *texture = calloc(count, sizeof *texture);
    int last = windows_last_height(view->windows);
    struct windows_counters c;
    assert_non_null(texture);
    for (int i = 0; i <= last; i++) {
        glGetTextureSubImage(windows_heights(view->windows), 0, 0, 0, i, shape.cols, shape.rows, 1,
                             GL_RED, GL_FLOAT, (GLsizei)(count * sizeof *texture), texture);
        different += check_level(view, i, texture);
    }
    windows_count(view->windows, &c);
    print_message("%-28s: levels 0 to %d, %zu samples, %zu differ; %.3f of all so far came as "
                  "residuals\n",
                  where, last, count * (size_t)(last + 1), different,
                  (double)c.residuals / (double)c.heights);
    assert_int_equal(different, 0);
    free(texture);
}

static perigee_camera camera_at(double lat_deg, double lon_deg, double above_m)
{
    perigee_camera c = {.lat_deg = lat_deg, .lon_deg = lon_deg, .pitch_deg = -20, .fov_deg = 60};
    c.alt_m = above_m + analytic_height(lat_deg * RAD, lon_deg * RAD);
    return c;
}

// Frames that do not wait for their data.
static void fly(perigee_view *view, perigee_camera c, double north_deg, double east_deg, int frames)
{
    for (int i = 0; i < frames; i++, c.lat_deg += north_deg, c.lon_deg += east_deg) {
        scene_bind(64, 64);
        assert_int_equal(perigee_view_set_camera(view, &c), 0);
        assert_int_equal(perigee_view_render(view, 64, 64), 0);
    }
    scene_render(view, &c, 64, 64);
}

static void test_same_bits_as_the_processor(void **state)
{
    (void)state;
    perigee_planet *planet = scene_planet();
    perigee_view_params p = PLAIN;
    p.planar_residuals = true;
    p.threads = 1; // strips come coarse to fine
    perigee_view *view = scene_view(planet, &p);
    scene_render(view, &(perigee_camera){.alt_m = 2e7, .pitch_deg = -90, .fov_deg = 40}, 64, 64);
    check_windows(view, "from far away");
    fly(view, camera_at(12, 34, 900), 0, 0, 1);
    check_windows(view, "down to the ground");
    fly(view, camera_at(12, 34, 900), 0.0007, -0.0003, 20);
    check_windows(view, "a flight");
    fly(view, camera_at(-47, 179.9, 2e4), 0.01, 0.02, 20);
    check_windows(view, "over the antimeridian");
    fly(view, camera_at(59.9, -20, 5e3), 0.02, 0, 20);
    check_windows(view, "where columns double");
    fly(view, camera_at(89.95, 10, 5e3), 0.005, 0, 9);
    check_windows(view, "to the pole");
    struct windows_counters c;
    windows_count(view->windows, &c);
    assert_true(c.residuals > c.heights / 2);
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
}

// Heights are rounded by a five thousandth of the distance of their samples at most, of which a
// pixel covers a third or more.
static void test_the_same_picture(void **state)
{
    (void)state;
    static const double places[][3] = {{31, 12, 150}, {-47, 179.9, 2e4}, {59.9, -20, 5e3}};
    static temporal_picture a, b;
    perigee_view_params p = PLAIN;
    temporal_scene plain = temporal_open(temporal_rough(), true, &p);
    p.planar_residuals = true;
    temporal_scene added = temporal_open(temporal_rough(), true, &p);
    for (int i = 0; i < 3; i++) {
        perigee_camera c = {
            .lat_deg = places[i][0], .lon_deg = places[i][1], .pitch_deg = -20, .fov_deg = 60};
        c.alt_m = temporal_ground(&plain, c.lat_deg, c.lon_deg) + places[i][2];
        temporal_see(&plain, &c, &a);
        temporal_see(&added, &c, &b);
        temporal_change change = temporal_compare(&plain, &c, &a, &b, NULL, NULL);
        print_message("%g m up: %.4f rms, %.4f 99.9 %%, %.4f px, colour %.3f / 255, %d pixels\n",
                      places[i][2], change.rms_px, change.p999_px, change.worst_px, change.rms,
                      change.compared);
        assert_true(change.compared > TEMPORAL_PIXELS / 8);
        assert_true(change.p999_px <= 0.001 + 2 * gpu_fixture_snap_px());
        assert_true(change.rms <= 0.3);
    }
    temporal_close(&plain);
    temporal_close(&added);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_same_bits_as_the_processor),
                                       cmocka_unit_test(test_the_same_picture)};
    int rc = scene_open();
    return rc ? rc : scene_close(cmocka_run_group_tests(tests, NULL, NULL));
}
