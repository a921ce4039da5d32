// Flicker of pictures whose errors and colours are known numbers. Fails when broken: errors by
// their size instead of their sign, the truth's colours not taken off, silhouettes counted.
#include "check.h"

#include "reference/flicker.h"

enum { WIDTH = 8, HEIGHT = 5, PIXELS = WIDTH * HEIGHT };

// A plane of one value.
static void fill(float *plane, double value)
{
    for (int i = 0; i < PIXELS; i++) plane[i] = (float)value;
}

// Linear light of an sRGB code in 0..255, of those used here above its straight piece.
static double light(double code)
{
    return pow((code / 255 + 0.055) / 1.055, 2.4);
}

static float error[2][PIXELS], seen[2][3][PIXELS], truth[2][3][PIXELS];
static unsigned char kind[2][PIXELS];

static flicker_moment moment(int i)
{
    return (flicker_moment){error[i],   kind[i],     seen[i][0],  seen[i][1],
                            seen[i][2], truth[i][0], truth[i][1], truth[i][2]};
}

static flicker_result measure(void)
{
    flicker_moment before = moment(0), after = moment(1);
    flicker_result r;
    assert_int_equal(flicker_measure(&before, &after, WIDTH, HEIGHT, &r), OK);
    return r;
}

static int set_up(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        fill(error[i], 0.75);
        for (int k = 0; k < 3; k++) {
            fill(seen[i][k], light(100));
            fill(truth[i][k], light(110));
        }
        for (int p = 0; p < PIXELS; p++) kind[i][p] = COMPARE_GROUND;
    }
    return 0;
}

// An error that stays is no flicker, and neither is what the truth does as well.
static void test_nothing(void **state)
{
    (void)state;
    flicker_result r = measure();
    assert_int_equal(r.moved_px.count, PIXELS);
    check_near(r.moved_px.max, 0, 0);
    check_near(r.color.max, 0, 0);
    fill(seen[1][1], light(130));
    fill(truth[1][1], light(140));
    check_near(measure().color.max, 0, 1e-3);
}

static void test_change(void **state)
{
    (void)state;
    fill(error[0], -0.3);
    fill(error[1], 0.3);
    error[1][19] = 1.7F;
    fill(seen[1][2], light(104));
    fill(truth[1][2], light(104));
    flicker_result r = measure();
    check_near(r.moved_px.median, 0.6, 1e-6);
    check_near(r.moved_px.max, 2, 1e-6);
    assert_int_equal(r.moved_px.x + WIDTH * r.moved_px.y, 19);
    check_near(r.moved_px.rms, sqrt((0.36 * (PIXELS - 1) + 4) / PIXELS), 1e-6);
    check_near(r.color.median, 10, 1e-3); // by 4 up, the truth's by 6 down
}

// Only what is plain ground at both moments.
static void test_left_out(void **state)
{
    (void)state;
    error[1][3] = 9;
    kind[0][3] = COMPARE_SILHOUETTE;
    error[1][4] = 9;
    kind[1][4] = COMPARE_MISSING;
    error[0][5] = NAN;
    flicker_result r = measure();
    assert_int_equal(r.moved_px.count, PIXELS - 3);
    assert_int_equal(r.color.count, PIXELS - 3);
    check_near(r.moved_px.max, 0, 0);
}

// Without a truth the change is the picture's own; without colours none is measured.
static void test_unknown(void **state)
{
    (void)state;
    fill(seen[1][0], light(103));
    flicker_moment before = moment(0), after = moment(1);
    flicker_result r;
    before.true_r = before.true_g = before.true_b = NULL;
    after.true_r = after.true_g = after.true_b = NULL;
    before.geometric_px = NULL;
    assert_int_equal(flicker_measure(&before, &after, WIDTH, HEIGHT, &r), OK);
    check_near(r.color.median, 3, 1e-3);
    check_near(r.moved_px.median, 0.75, 1e-6);
    after.g = NULL;
    assert_int_equal(flicker_measure(&before, &after, WIDTH, HEIGHT, &r), OK);
    assert_int_equal(r.color.count, 0);
    assert_true(isnan(r.color.rms));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(test_nothing, set_up),
        cmocka_unit_test_setup(test_change, set_up),
        cmocka_unit_test_setup(test_left_out, set_up),
        cmocka_unit_test_setup(test_unknown, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
