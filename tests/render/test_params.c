// What a view is made with: an error asked for chooses the cheapest setting that keeps it, what is
// given besides stays, and what cannot be is refused. (That the settings keep their errors:
// reference_views.)
#include "check.h"

#include "base/log.h"
#include "render/params.h"

static char last[512];
static int lines;

static void keep_line(void *user, enum log_level level, const char *line)
{
    (void)user;
    lines += level == LOG_ERROR;
    snprintf(last, sizeof last, "%s", line);
}

static perigee_view_params complete(perigee_view_params p)
{
    assert_int_equal(params_complete(&p), OK);
    return p;
}

static void expect_equal(const perigee_view_params *a, const perigee_view_params *b)
{
    assert_int_equal(a->azimuth_steps, b->azimuth_steps);
    assert_int_equal(a->rings_per_level, b->rings_per_level);
    assert_int_equal(a->texels, b->texels);
    check_near(a->ring_spacing_px, b->ring_spacing_px, 0);
    assert_int_equal(a->filter, b->filter);
}

// Each error gets what the next larger choice does, never more; the named qualities are among them.
static void test_error_chooses_the_cheapest(void **state)
{
    (void)state;
    static const double errors[] = {0.9, 1.4, 2, 2.7}; // stated in bench/RESULTS-error.md
    perigee_view_params dearer = complete((perigee_view_params){.quality = PERIGEE_QUALITY_HIGH});
    for (size_t i = 0; i < sizeof errors / sizeof *errors; i++) {
        double next = i < 3 ? errors[i + 1] : 100;
        perigee_view_params at = complete((perigee_view_params){.error_px = errors[i]}),
                            below_next = complete((perigee_view_params){.error_px = 0.999 * next});
        expect_equal(&at, &below_next);
        int64_t vertices = (int64_t)at.azimuth_steps * at.rings_per_level;
        if (i > 0) {
            assert_true(vertices < (int64_t)dearer.azimuth_steps * dearer.rings_per_level);
            assert_true(at.texels <= dearer.texels && at.ring_spacing_px > dearer.ring_spacing_px);
        }
        dearer = at;
    }
    static const enum perigee_quality named[] = {PERIGEE_QUALITY_HIGH, PERIGEE_QUALITY_DEFAULT,
                                                 PERIGEE_QUALITY_LOW};
    static const double their[] = {0.9, 2, 2.7};
    for (int i = 0; i < 3; i++) {
        perigee_view_params by_name = complete((perigee_view_params){.quality = named[i]}),
                            by_error = complete((perigee_view_params){.error_px = their[i]});
        expect_equal(&by_name, &by_error);
    }
}

// An error goes before a quality, and what is given goes before both.
static void test_given_values_stay(void **state)
{
    (void)state;
    perigee_view_params p = complete((perigee_view_params){.error_px = 0.9,
                                                           .quality = PERIGEE_QUALITY_LOW,
                                                           .azimuth_steps = 128,
                                                           .ring_spacing_px = -1}),
                        high = complete((perigee_view_params){.error_px = 0.9});
    assert_int_equal(p.azimuth_steps, 128);
    check_near(p.ring_spacing_px, -1, 0);
    assert_int_equal(p.rings_per_level, high.rings_per_level);
    assert_int_equal(p.texels, high.texels);
}

static void test_refused(void **state)
{
    (void)state;
    static const struct {
        perigee_view_params params;
        const char *words;
    } bad[] = {
        {{.error_px = 0.89}, "below 0.89 pixels; the finest keeps 0.9"},
        {{.error_px = -1}, "error of -1"},
        {{.error_px = NAN}, "error of nan"},
        {{.quality = (enum perigee_quality)9}, "quality: 9"},
        {{.azimuth_steps = 100}, "azimuth steps"},
        {{.rings_per_level = 7}, "rings a level"},
        {{.texels = 300}, "height samples"},
        {{.levels = 99}, "levels"},
        {{.first_level = 5, .last_level = 3}, "first level: 5"},
        {{.threads = -1}, "threads"},
        {{.mode = (enum perigee_mode)77}, "mode: 77"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        perigee_view_params p = bad[i].params;
        lines = 0;
        assert_int_equal(params_complete(&p), ERR_ARGUMENT);
        if (lines != 1 || !strstr(last, bad[i].words)) fail_msg("%s: %s", bad[i].words, last);
    }
}

int main(void)
{
    log_set_sink(keep_line, NULL);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_error_chooses_the_cheapest),
        cmocka_unit_test(test_given_values_stay),
        cmocka_unit_test(test_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
