// What a window shows, without a window: each mode as a view of its own shows it, the halves of a
// split as those of single pictures, their difference, and that memory comes back. The first two
// over the map as a plane too. The oracle is perigee.h alone: a fresh view for each mode, waited
// for.
#include "check.h"

#include <stdlib.h>
#include <time.h>
#include <unistd.h>

#include "app/window_views.h"
#include "gpu/gpu_fixture.h"
#include "gpu/target.h"
#include "planet/analytic_planet.h"

#define PLANET "views.planet"
#define TIME_S 1.7e9

enum { WIDTH = 160, HEIGHT = 120, BYTES = WIDTH * HEIGHT * 3, MODES_MAX = 8, NAMES = 4096 };

static const perigee_camera camera = {
    .lat_deg = 46, .lon_deg = 11, .alt_m = 4e5, .heading_deg = 30, .pitch_deg = -35};
static const perigee_view_params cheap = {.quality = PERIGEE_QUALITY_PAPER, .threads = 2};

static perigee_planet *planet;
static gpu_target target;
static int mode_count;
static bool flat;
static uint8_t truths[MODES_MAX][BYTES];

static void read_target(uint8_t *rgb)
{
    gpu_target_read(&target, target.colors[0], GL_RGB, GL_UNSIGNED_BYTE, 3, rgb);
}

static void render_truth(int mode, uint8_t *rgb)
{
    perigee_view_params params = cheap;
    perigee_view *view;
    params.mode = (enum perigee_mode)mode;
    assert_int_equal(perigee_view_create(planet, &params, &view), 0);
    assert_int_equal(perigee_view_set_camera(view, &camera), 0);
    assert_int_equal(perigee_view_set_time(view, TIME_S), 0);
    assert_int_equal(perigee_view_wait(view, WIDTH, HEIGHT, 60), 0);
    glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
    assert_int_equal(perigee_view_render(view, WIDTH, HEIGHT), 0);
    read_target(rgb);
    perigee_view_destroy(&view);
}

// Draws until nothing is missing.
static void settle(struct window_views *v)
{
    for (int i = 0; i < 20000; i++) {
        assert_int_equal(window_views_render(v, &camera, TIME_S, WIDTH, HEIGHT, target.framebuffer),
                         OK);
        if (!window_views_need_redraw(v)) return;
        nanosleep(&(struct timespec){0, 1000000}, NULL);
    }
    fail_msg("never complete");
}

static struct window_views *open_views(const perigee_view_params *params)
{
    struct window_views *v;
    assert_int_equal(window_views_create(planet, params, &v), OK);
    return v;
}

static int at(int x, int y)
{
    return 3 * (y * WIDTH + x);
}

static void check_columns(const uint8_t *got, const uint8_t *want, int from, int to, int rows)
{
    for (int y = 0; y < rows; y++)
        assert_memory_equal(got + at(from, y), want + at(from, y), 3 * (size_t)(to - from));
}

static void check_difference(const uint8_t *got, int a, int b, int first_row)
{
    for (int i = at(0, first_row); i < BYTES; i++) {
        int want = WINDOW_VIEWS_GAIN * abs(truths[a][i] - truths[b][i]);
        assert_int_equal(got[i], want < 255 ? want : 255);
    }
}

static void steps_through_all_modes(void **state)
{
    (void)state;
    static uint8_t rgb[BYTES];
    struct window_views *v = open_views(&cheap);
    assert_true(mode_count >= 2);
    assert_memory_not_equal(truths[0], truths[1], BYTES);
    for (int i = 0; i <= mode_count; i++) {
        int mode = i % mode_count;
        assert_string_equal(window_views_mode(v, 0), perigee_mode_name((enum perigee_mode)mode));
        assert_null(window_views_mode(v, 1));
        settle(v);
        read_target(rgb);
        assert_memory_equal(rgb, truths[mode], BYTES);
        assert_int_equal(window_views_next_mode(v), OK);
    }
    window_views_destroy(&v);
}

static void split_shows_both(void **state)
{
    (void)state;
    static uint8_t rgb[BYTES], shot[BYTES];
    struct window_views *v = open_views(&cheap);
    assert_int_equal(window_views_next_mode(v), OK);
    assert_int_equal(window_views_toggle_split(v, WIDTH, HEIGHT), OK);
    int left = 1, right = 2 % mode_count;
    assert_string_equal(window_views_mode(v, 1), perigee_mode_name((enum perigee_mode)right));
    for (int i = 0; i < 4; i++) { // difference below, everywhere, nowhere, below
        const int rows[] = {HEIGHT - HEIGHT / 3, 0, HEIGHT, HEIGHT - HEIGHT / 3};
        settle(v);
        read_target(rgb);
        check_near(window_views_difference(v), 1 - rows[i] / (double)HEIGHT, 1e-9);
        check_columns(rgb, truths[left], 0, WIDTH / 2, rows[i] - (rows[i] < HEIGHT));
        check_columns(rgb, truths[right], WIDTH / 2 + 1, WIDTH, rows[i] - (rows[i] < HEIGHT));
        if (rows[i]) assert_int_equal(rgb[at(WIDTH / 2, 0)], 255);
        check_difference(rgb, left, right, rows[i]);
        assert_int_equal(window_views_picture(v, &camera, TIME_S, WIDTH, HEIGHT, shot), OK);
        assert_memory_equal(shot, rgb, BYTES);
        window_views_next_difference(v);
    }
    window_views_destroy(&v);
}

static void same_mode_differs_nowhere(void **state)
{
    (void)state;
    static uint8_t rgb[BYTES];
    static const uint8_t black[BYTES];
    struct window_views *v = open_views(&cheap);
    assert_int_equal(window_views_toggle_split(v, WIDTH, HEIGHT), OK);
    window_views_next_difference(v);
    for (int mode = 1; mode <= mode_count; mode++) {
        assert_string_equal(window_views_mode(v, 0), perigee_mode_name(0));
        assert_string_equal(window_views_mode(v, 1),
                            perigee_mode_name((enum perigee_mode)(mode % mode_count)));
        settle(v);
        read_target(rgb);
        if (mode < mode_count) assert_memory_not_equal(rgb, black, BYTES);
        else assert_memory_equal(rgb, black, BYTES);
        assert_int_equal(window_views_next_mode(v), OK);
    }
    window_views_destroy(&v);
}

// A square that the planar mode refuses; what else is refused, the library says itself.
static void refused_mode_leaves_the_old_one(void **state)
{
    (void)state;
    perigee_view_params params = cheap;
    params.planar_n = 33;
    struct window_views *v = open_views(&params);
    int now = 0, refused = 0;
    for (int i = 1; i <= 2 * mode_count; i++) {
        perigee_view *view;
        params.mode = (enum perigee_mode)(i % mode_count);
        bool possible = perigee_view_create(planet, &params, &view) == 0;
        perigee_view_destroy(&view);
        if (possible) now = i % mode_count;
        else refused++;
        assert_int_equal(window_views_next_mode(v) == OK, possible);
        assert_string_equal(window_views_mode(v, 0), perigee_mode_name((enum perigee_mode)now));
        if (!possible) assert_non_null(strstr(perigee_last_error(), "33"));
    }
    assert_true(refused > 0);
    assert_int_equal(window_views_render(v, &camera, NAN, WIDTH, HEIGHT, target.framebuffer), OK);
    window_views_destroy(&v);
}

// The driver keeps a deleted program for as long as the pipeline last used it: that is not ours.
static bool is_our_program(GLuint name)
{
    GLint deleted = GL_TRUE;
    if (glIsProgram(name)) glGetProgramiv(name, GL_DELETE_STATUS, &deleted);
    return !deleted;
}

static int live_objects(void)
{
    int count = 0;
    for (GLuint i = 1; i < NAMES; i++)
        count += glIsTexture(i) + glIsBuffer(i) + is_our_program(i) + glIsFramebuffer(i) +
                 glIsVertexArray(i);
    return count;
}

static void split_gives_memory_back(void **state)
{
    (void)state;
    int none = live_objects();
    struct window_views *v = open_views(&cheap);
    settle(v);
    int one = live_objects();
    size_t bytes = window_views_stats(v, 0).gpu_bytes;
    assert_true(one > none && bytes > 0);
    assert_int_equal(window_views_stats(v, 1).gpu_bytes, 0);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(window_views_toggle_split(v, WIDTH, HEIGHT), OK);
        settle(v);
        assert_true(window_views_is_split(v) && live_objects() > one);
        assert_true(window_views_stats(v, 1).gpu_bytes > bytes / 2);
        assert_int_equal(window_views_toggle_split(v, WIDTH, HEIGHT), OK);
        settle(v);
        assert_int_equal(live_objects(), one);
        assert_int_equal(window_views_stats(v, 1).gpu_bytes, 0);
    }
    // Too large a picture: no split, and nothing of it is left.
    assert_int_not_equal(window_views_toggle_split(v, 1 << 20, 16), OK);
    assert_false(window_views_is_split(v));
    assert_int_equal(live_objects(), one);
    assert_int_equal(window_views_toggle_split(v, WIDTH, HEIGHT), OK);
    window_views_destroy(&v);
    assert_null(v);
    assert_int_equal(live_objects(), none);
}

static int set_up(void **state)
{
    (void)state;
    const GLenum format = GL_RGBA8;
    if (access(PLANET, F_OK) != 0 && analytic_planet_make(PLANET, 3) != 0) return -1;
    const perigee_planet_params params = {.flat = flat};
    if (perigee_planet_open(PLANET, &params, &planet)) return -1;
    if (gpu_target_init(&target, WIDTH, HEIGHT, &format, 1, 0)) return -1;
    mode_count = 0;
    while (perigee_mode_name((enum perigee_mode)mode_count)) mode_count++;
    if (mode_count > MODES_MAX) return -1;
    for (int i = 0; i < mode_count; i++) render_truth(i, truths[i]);
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    gpu_target_deinit(&target);
    perigee_planet_close(&planet);
    return 0;
}

int main(void)
{
    int rc = gpu_fixture_open();
    if (rc) return rc;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(steps_through_all_modes),
        cmocka_unit_test(split_shows_both),
        cmocka_unit_test(same_mode_differs_nowhere),
        cmocka_unit_test(refused_mode_leaves_the_old_one),
        cmocka_unit_test(split_gives_memory_back),
    };
    const struct CMUnitTest flat_tests[] = {
        cmocka_unit_test(steps_through_all_modes),
        cmocka_unit_test(split_shows_both),
    };
    int failed = cmocka_run_group_tests(tests, set_up, tear_down);
    flat = true;
    failed += cmocka_run_group_tests(flat_tests, set_up, tear_down);
    return gpu_fixture_close(failed);
}
