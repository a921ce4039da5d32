// Whole frames: the camera, the planes, the same bits with any number of threads, cancelling, and
// what is refused.
#include "check.h"

#include <stdatomic.h>

#include "base/log.h"
#include "planet/planet_fixture.h"
#include "reference/reference.h"

enum { WIDTH = 150, HEIGHT = 90, PIXELS = WIDTH * HEIGHT };

struct frame {
    float r[PIXELS], g[PIXELS], b[PIXELS], z[PIXELS], height[PIXELS], level[PIXELS];
    double lat[PIXELS], lon[PIXELS];
};

static fixture files;
static opened planet;

static int set_up(void **state)
{
    (void)state;
    fixture_init(&files, "reference-frame");
    fixture_write(&files, 2, 0.3, fixture_smooth_height, NULL);
    planet = fixture_open(&files, 0, true);
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    fixture_close(&planet);
    fixture_deinit(&files);
    return 0;
}

static reference_params params_of(reference_camera camera, int threads)
{
    return (reference_params){.pyramid = planet.pyramid,
                              .camera = camera,
                              .width = WIDTH,
                              .height = HEIGHT,
                              .zoom = -1,
                              .threads = threads};
}

static void render(const reference_params *p, struct frame *f)
{
    reference_planes planes = {.r = f->r,
                               .g = f->g,
                               .b = f->b,
                               .z_m = f->z,
                               .height_m = f->height,
                               .lat_deg = f->lat,
                               .lon_deg = f->lon,
                               .level = f->level};
    memset(f, 0x55, sizeof *f);
    assert_int_equal(reference_render(p, &planes), OK);
}

static void test_same_with_any_threads(void **state)
{
    (void)state;
    static struct frame one, many;
    const reference_camera cameras[] = {{89.9, 30, 20000, 10, -5, 4, 70},
                                        {10, 179.9, 2e7, 0, -90, 0, 40}};
    for (int i = 0; i < 2; i++)
        for (int zoom = 2; zoom <= 3; zoom++) { // stored, and synthesised
            reference_params p = params_of(cameras[i], 1);
            p.zoom = zoom;
            render(&p, &one);
            p.threads = 5;
            render(&p, &many);
            assert_memory_equal(&one, &many, sizeof one);
        }
}

// Straight down, the middle of the picture is the ground below; turning the camera turns the
// places.
static void test_where_pixels_look(void **state)
{
    (void)state;
    static struct frame f;
    reference_camera c = {40, 20, 1e5, 90, -90, 0, 20};
    reference_params p = params_of(c, 2);
    p.width = p.height = 89;
    render(&p, &f);
    int middle = 44 * 89 + 44, top = 2 * 89 + 44, right = 44 * 89 + 86;
    check_near(f.lat[middle], 40, 1e-9);
    check_near(f.lon[middle], 20, 1e-9);
    double ground;
    assert_int_equal(
        pyramid_height_at(planet.pyramid, 2, 40 * M_PI / 180, 20 * M_PI / 180, &ground), OK);
    check_near(f.z[middle], 1e5 - ground, 0.02);
    check_near(f.height[middle], ground, 1e-3);
    assert_true(f.lon[top] > 20.1 && fabs(f.lat[top] - 40) < 0.02);     // heading east: up is east
    assert_true(f.lat[right] < 39.9 && fabs(f.lon[right] - 20) < 0.02); // and right is south
    check_near(f.level[middle], 2, 0);
    assert_true(f.r[middle] > 0 && f.g[middle] > 0 && f.b[middle] > 0);
    c = (reference_camera){40, 20, 1e5, 0, 80, 0, 20};
    p = params_of(c, 2);
    render(&p, &f);
    for (int i = 0; i < PIXELS; i++) {
        assert_true(isnan(f.z[i]) && isnan(f.height[i]) && isnan(f.lat[i]) && isnan(f.lon[i]));
        check_near(f.level[i], -1, 0);
        check_near(f.r[i] + f.g[i] + f.b[i], 0, 0);
    }
}

// Rolled clockwise by 90 degrees, the horizon's ground lies at the right... of the sky: the picture
// of a level camera turned counterclockwise.
static void test_roll(void **state)
{
    (void)state;
    static struct frame level, rolled;
    reference_camera c = {40, 20, 20000, 30, -10, 0, 40};
    reference_params p = params_of(c, 2);
    p.width = p.height = 80;
    render(&p, &level);
    p.camera.roll_deg = 90;
    render(&p, &rolled);
    for (int y = 0; y < 80; y++)
        for (int x = 0; x < 80; x++) {
            double a = level.z[y * 80 + x], b = rolled.z[(79 - x) * 80 + y];
            assert_int_equal(isnan(a), isnan(b));
            if (!isnan(a)) check_near(b / a, 1, 1e-6);
        }
}

static bool cancel(void *user, double done)
{
    (void)done;
    return ++*(int *)user > 3;
}

static void test_cancelled(void **state)
{
    (void)state;
    int calls = 0;
    reference_params p = params_of((reference_camera){0, 0, 2e7, 0, -90, 0, 60}, 2);
    p.progress = (reference_progress){cancel, &calls};
    reference_planes none = {0};
    assert_int_equal(reference_render(&p, &none), ERR_CANCELLED);
    assert_int_equal(calls, 4);
}

static int lines;

static void count_line(void *user, enum log_level level, const char *line)
{
    (void)user;
    (void)line;
    lines += level == LOG_ERROR;
}

static void test_refused(void **state)
{
    (void)state;
    const reference_params good = params_of((reference_camera){0, 0, 2e7, 0, -90, 0, 60}, 1);
    reference_params bad[8];
    for (int i = 0; i < 8; i++) bad[i] = good;
    bad[0].camera.lat_deg = NAN;
    bad[1].camera.alt_m = -5e6;
    bad[2].camera.fov_deg = 180;
    bad[3].width = 0;
    bad[4].height = 20000;
    bad[5].zoom = 25;
    bad[6].has_sun = true;
    bad[7].zoom = 12; // too many tiles seen from space
    reference_planes none = {0};
    log_set_sink(count_line, NULL);
    for (int i = 0; i < 8; i++) {
        lines = 0;
        assert_int_equal(reference_render(&bad[i], &none), ERR_ARGUMENT);
        assert_int_equal(lines, 1);
    }
    log_set_sink(NULL, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_same_with_any_threads),
        cmocka_unit_test(test_where_pixels_look),
        cmocka_unit_test(test_roll),
        cmocka_unit_test(test_cancelled),
        cmocka_unit_test(test_refused),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
