// The search for a size against measures known in closed form. Fails when broken: the sign of
// the exponent not heeded, limits left.
#include "check.h"

#include "app/size_search.h"

struct curve {
    double scale, power, step; // value = scale * size^power; sizes are rounded to 1 / step
    double bump;               // and values wave by this share
    double none_from;          // sizes from here on have no value
    int calls, fails_at;
    double low, high; // sizes asked for
};

static status value_of(void *user, double size, double *value)
{
    struct curve *c = user;
    c->low = fmin(c->low, size);
    c->high = fmax(c->high, size);
    if (++c->calls == c->fails_at) return ERR_MEMORY;
    double rounded = c->step > 0 ? fmax(1, round(size * c->step)) / c->step : size;
    *value = c->scale * pow(rounded, c->power) * (1 + c->bump * sin(40 * size));
    if (size >= c->none_from) *value = NAN;
    return OK;
}

static struct curve curve_of(double scale, double power)
{
    return (struct curve){
        .scale = scale, .power = power, .none_from = INFINITY, .low = INFINITY, .high = 0};
}

static size_search_result search(struct curve *c, double goal, double tolerance)
{
    size_search_params p = {.low = 1.0 / 32,
                            .high = 4,
                            .goal = goal,
                            .tolerance = tolerance,
                            .exponent = c->power < 0 ? -1.5 : 2,
                            .tries = 10,
                            .measure = value_of,
                            .user = c};
    size_search_result r;
    assert_int_equal(size_search(&p, &r), OK);
    assert_int_equal(r.tries, c->calls);
    assert_true(c->low >= p.low * (1 - 1e-12) && c->high <= p.high * (1 + 1e-12));
    return r;
}

// The measure's own exponent may be another than the one expected.
static void test_powers(void **state)
{
    (void)state;
    static const double powers[] = {2, 1.2, 3, -0.7, -1.5, -3};
    for (size_t i = 0; i < sizeof powers / sizeof *powers; i++)
        for (double size = 0.04; size < 4; size *= 1.7) {
            struct curve c = curve_of(1e4, powers[i]);
            size_search_result r = search(&c, 1e4 * pow(size, powers[i]), 0.01);
            assert_true(r.met);
            check_near(log(r.size / size), 0, 0.011 / fabs(powers[i]));
        }
}

// Steps as wide as half the tolerance, and waves: still found.
static void test_rough(void **state)
{
    (void)state;
    for (double size = 0.1; size < 3; size *= 1.3) {
        struct curve stepped = curve_of(300, 2), waving = curve_of(2, -1.5);
        stepped.step = 200;
        waving.bump = 0.1;
        assert_true(search(&stepped, 300 * size * size, 0.1).met);
        size_search_result r = search(&waving, 2 * pow(size, -1.5), 0.1);
        if (!r.met) fail_msg("size %g: %g instead of %g", size, r.value, 2 * pow(size, -1.5));
    }
}

// Beyond the sizes there are: the nearest of them, and it says so.
static void test_out_of_reach(void **state)
{
    (void)state;
    struct curve c = curve_of(100, 2);
    size_search_result r = search(&c, 100 * 25, 0.1);
    assert_false(r.met);
    check_near(r.size, 4, 1e-9);
    c = curve_of(100, 2);
    r = search(&c, 1e-3, 0.1);
    assert_false(r.met);
    check_near(r.size, 1.0 / 32, 1e-9);
}

// One size only, no value anywhere, a measure that fails.
static void test_no_way(void **state)
{
    (void)state;
    struct curve c = curve_of(100, 2);
    c.none_from = 1.01;
    size_search_result r = search(&c, 400, 0.1);
    assert_false(r.met);
    check_near(r.size, 1, 0);
    check_near(r.value, 100, 0);
    c = curve_of(100, 2);
    c.none_from = 0;
    assert_true(isnan(search(&c, 400, 0.1).value));
    c = curve_of(100, 2);
    c.fails_at = 2;
    size_search_params p = {.low = 0.1,
                            .high = 4,
                            .goal = 400,
                            .tolerance = 0.1,
                            .exponent = 2,
                            .tries = 10,
                            .measure = value_of,
                            .user = &c};
    assert_int_equal(size_search(&p, &r), ERR_MEMORY);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_powers),
        cmocka_unit_test(test_rough),
        cmocka_unit_test(test_out_of_reach),
        cmocka_unit_test(test_no_way),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
