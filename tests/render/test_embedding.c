// A foreign context keeps its state, and impossible values are refused with one clear line.
#include "render/scene.h"

#include <epoxy/gl.h>
#include <unistd.h>

#include "base/log.h"

static void test_state_is_left_alone(void **state)
{
    (void)state;
    perigee_planet *planet = scene_planet();
    perigee_view *view = scene_view(planet, NULL);
    perigee_camera c = {.lat_deg = 10, .alt_m = 1e7, .pitch_deg = -90};
    scene_render(view, &c, 64, 64);
    glEnable(GL_BLEND);
    glEnable(GL_SCISSOR_TEST);
    glDisable(GL_DEPTH_TEST);
    glDepthFunc(GL_LEQUAL);
    glDepthMask(GL_FALSE);
    glViewport(3, 4, 5, 6);
    glScissor(0, 0, 1, 1);
    glFrontFace(GL_CW);
    GLint framebuffer, found, viewport[4];
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &framebuffer);
    c.heading_deg = 5;
    assert_int_equal(perigee_view_set_camera(view, &c), 0);
    assert_int_equal(perigee_view_render(view, 64, 64), 0);
    assert_true(glIsEnabled(GL_BLEND));
    assert_true(glIsEnabled(GL_SCISSOR_TEST));
    assert_false(glIsEnabled(GL_DEPTH_TEST));
    glGetIntegerv(GL_DEPTH_FUNC, &found);
    assert_int_equal(found, GL_LEQUAL);
    glGetIntegerv(GL_FRONT_FACE, &found);
    assert_int_equal(found, GL_CW);
    glGetIntegerv(GL_CLIP_DEPTH_MODE, &found);
    assert_int_equal(found, GL_NEGATIVE_ONE_TO_ONE);
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &found);
    assert_int_equal(found, framebuffer);
    glGetIntegerv(GL_VIEWPORT, viewport);
    assert_int_equal(viewport[2], 5);
    uint8_t pixel[4] = {0};
    glReadPixels(32, 32, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, pixel);
    assert_true(pixel[0] + pixel[1] + pixel[2] >
                30); // drawn although the caller's scissor was one pixel
    assert_int_equal(glGetError(), GL_NO_ERROR);
    glDisable(GL_BLEND);
    glDisable(GL_SCISSOR_TEST);
    glDepthMask(GL_TRUE);
    glFrontFace(GL_CCW);
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
}

static void test_impossible_values(void **state)
{
    (void)state;
    perigee_planet *planet = scene_planet();
    perigee_view *view = scene_view(planet, NULL);
    const struct {
        perigee_camera c;
        const char *says;
    } cases[] = {
        {{.lat_deg = 91}, "latitude"},        {{.lat_deg = NAN}, "latitude"},
        {{.lon_deg = INFINITY}, "longitude"}, {{.alt_m = -7e6}, "altitude"},
        {{.alt_m = NAN}, "altitude"},         {{.fov_deg = 180}, "field of view"},
        {{.fov_deg = -3}, "field of view"},   {{.pitch_deg = NAN}, "pitch"},
    };
    log_set_level((enum log_level) - 1);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        assert_int_not_equal(perigee_view_set_camera(view, &cases[i].c), 0);
        assert_non_null(strstr(perigee_last_error(), cases[i].says));
    }
    assert_int_not_equal(perigee_view_render(view, 0, 10), 0);
    assert_non_null(strstr(perigee_last_error(), "0 x 10"));
    assert_int_not_equal(perigee_view_render(view, 10, 100000), 0);
    const struct {
        perigee_view_params p;
        const char *says;
    } bad[] = {
        {{.azimuth_steps = 100}, "100"},
        {{.threads = -1}, "-1"},
        {{.threads = 100000}, "100000"},
        {{.first_level = 24}, "24"},
        {{.last_level = 24}, "24"},
        {{.levels = 25}, "25"},
        {{.rings_per_level = 3}, "3"},
        {{.transform = 77}, "77"},
        {{.mode = 77}, "mode: 77"},
        {{.mode = PERIGEE_MODE_PLANAR, .planar_form = 5}, "planar mode: 5"},
        {{.mode = PERIGEE_MODE_PLANAR, .planar_triangles = 5000}, "bound of 5000 triangles"},
        {{.mode = PERIGEE_MODE_PLANAR, .planar_n = 64}, "across a square: 64"},
        {{.mode = PERIGEE_MODE_PLANAR, .planar_n = 15}, "across a square: 15"},
        {{.mode = PERIGEE_MODE_PLANAR, .planar_n = -1}, "across a square: -1"},
        {{.mode = PERIGEE_MODE_PLANAR, .planar_n = 511}, "511, more than the windows' 256"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        perigee_view *none;
        assert_int_not_equal(perigee_view_create(planet, &bad[i].p, &none), 0);
        assert_null(none);
        assert_non_null(strstr(perigee_last_error(), bad[i].says));
    }
    log_set_level(LOG_INFO);
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
}

static GLenum GLAPIENTRY always_lost(void)
{
    return GL_CONTEXT_LOST;
}

// A context that was lost has errors without end: a view of it is refused, and nothing waits for
// the last of them.
static void test_lost_context(void **state)
{
    (void)state;
    static const enum perigee_mode modes[] = {PERIGEE_MODE_SPHERICAL, PERIGEE_MODE_PLANAR,
                                              PERIGEE_MODE_GRID};
    perigee_planet *planet = scene_planet();
    PFNGLGETERRORPROC own = epoxy_glGetError;
    log_set_level((enum log_level) - 1);
    for (size_t i = 0; i < sizeof modes / sizeof *modes; i++) {
        const perigee_view_params params = {.mode = modes[i]};
        perigee_view *view;
        epoxy_glGetError = always_lost;
        int refused = perigee_view_create(planet, &params, &view);
        epoxy_glGetError = own;
        assert_int_not_equal(refused, 0);
        assert_null(view);
        assert_true(strlen(perigee_last_error()) > 10);
    }
    log_set_level(LOG_INFO);
    perigee_planet_close(&planet);
}

// Late data: only the coarsest level is loaded, the first frame shows it, and what is missing is
// told.
static void test_missing_is_told(void **state)
{
    (void)state;
    perigee_planet *planet = scene_planet();
    // Less a frame than a level has, so that a wait of no time is too short however late it comes.
    const perigee_view_params params = {.upload_bytes_frame = 256 << 10};
    perigee_view *view = scene_view(planet, &params);
    perigee_camera c = {.lat_deg = 10, .alt_m = 5e4, .pitch_deg = -30};
    assert_int_equal(perigee_view_set_camera(view, &c), 0);
    scene_bind(64, 64);
    assert_int_equal(perigee_view_render(view, 64, 64), 0);
    static float height[64 * 64];
    perigee_planes planes = {.height_m = height};
    assert_int_equal(perigee_view_read_planes(view, &planes), 0);
    double at_edge = height[63 * 64 + 32], truth = analytic_height(10 * M_PI / 180, 0);
    print_message("first frame: %.0f m, truth nearby %.0f m\n", at_edge, truth);
    check_near(at_edge, truth, 100); // 78 km a sample
    assert_int_not_equal(perigee_view_wait(view, 64, 64, 0), 0);
    assert_non_null(strstr(perigee_last_error(), "missing: height level"));
    char text[4096];
    int missing = perigee_view_missing(view, text, sizeof text);
    assert_true(missing > 0);
    assert_non_null(strstr(text, "height level"));
    assert_int_equal(perigee_view_wait(view, 64, 64, 60), 0);
    assert_int_equal(perigee_view_missing(view, text, sizeof text), 0);
    assert_string_equal(text, "");
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
}

// Without waiting, pictures sharpen as data come: what is complete is also shown after the fades'
// third of a second. (Fades once stood still in pictures rendered off screen.)
static void test_late_data_fades_in(void **state)
{
    (void)state;
    enum { SIZE = 64 };
    static uint8_t first[SIZE * SIZE * 3], late[SIZE * SIZE * 3], whole[SIZE * SIZE * 3];
    perigee_planet *planet = scene_planet();
    perigee_view *view = scene_view(planet, NULL);
    perigee_camera c = {.lat_deg = 10, .alt_m = 5e4, .pitch_deg = -30};
    assert_int_equal(perigee_view_set_camera(view, &c), 0);
    assert_int_equal(perigee_view_render_image(view, SIZE, SIZE, 1, first), 0);
    perigee_stats s = {.needs_redraw = true};
    for (int i = 0; i < 2000 && s.needs_redraw; i++) {
        usleep(2000);
        assert_int_equal(perigee_view_render_image(view, SIZE, SIZE, 1, late), 0);
        perigee_view_get_stats(view, &s);
    }
    assert_false(s.needs_redraw);
    assert_int_equal(perigee_view_wait(view, SIZE, SIZE, 60), 0);
    assert_int_equal(perigee_view_render_image(view, SIZE, SIZE, 1, whole), 0);
    assert_memory_equal(late, whole, sizeof whole);
    assert_memory_not_equal(first, whole, sizeof whole);
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_state_is_left_alone), cmocka_unit_test(test_impossible_values),
        cmocka_unit_test(test_lost_context),        cmocka_unit_test(test_missing_is_told),
        cmocka_unit_test(test_late_data_fades_in),
    };
    int rc = scene_open();
    return rc ? rc : scene_close(cmocka_run_group_tests(tests, NULL, NULL));
}
