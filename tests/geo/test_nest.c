// Nested squares: they nest for every viewer, blend as they should, and a vertex's terms are those
// of its place, by long double and by rotation of its unit vector.
#include "check.h"

#include "geo/nest.h"

static const int SIZES[] = {31, 63, 127, 255, 511, 1023};

static void random_place(struct check_random *r, double *lat, double *lon)
{
    *lat = check_random_range(r, -M_PI / 2, M_PI / 2);
    *lon = check_random_range(r, -2 * M_PI, 2 * M_PI);
    if (check_random_u64(r) % 8 == 0) *lon = M_PI;
    if (check_random_u64(r) % 8 == 0) *lat = copysign(M_PI / 2, *lat);
}

static void check_nested(const nest_square *coarse, const nest_square *fine)
{
    int m = (coarse->n + 1) / 4;
    assert_true(fine->row % 2 == 0 && fine->column % 2 == 0);
    int64_t down = fine->row / 2 - coarse->row, right = fine->column / 2 - coarse->column;
    assert_true(down == m - 1 || down == m);
    assert_true(right == m - 1 || right == m);
    // Two steps of the coarser level around the finer, so that there is room for a transition.
    assert_true(down + 2 * m - 1 <= coarse->n - 1 - 2);
    // The finer level's border lies where the coarser one does not blend.
    for (int i = 0; i < 2; i++) {
        double row = (double)(down + (i ? 2 * m - 1 : 0)), middle = (double)(right + m);
        assert_true(nest_alpha(coarse, row, middle) == 0);
        assert_true(nest_alpha(fine, i ? fine->n - 1 : 0, fine->n / 2) > 1 - 1e-12);
        assert_true(nest_alpha(fine, fine->n / 2, i ? fine->n - 1 : 0) > 1 - 1e-12);
    }
}

static void test_squares_nest(void **state)
{
    (void)state;
    struct check_random r = {4};
    for (int i = 0; i < 20000; i++) {
        double lat, lon;
        random_place(&r, &lat, &lon);
        int n = SIZES[i % 6], level = i / 6 % 22;
        nest_square coarse = nest_square_at(n, level, lat, lon),
                    fine = nest_square_at(n, level + 1, lat, lon);
        assert_true(fabs(coarse.view_row - n / 2) <= 1 && fabs(coarse.view_column - n / 2) <= 1);
        check_near(nest_latitude(&coarse, coarse.view_row), lat, 1e-15);
        check_near(coarse.step, 2 * fine.step, 0);
        check_nested(&coarse, &fine);
    }
}

// By the viewer's place: it does not jump when the square does.
static void test_alpha_follows_the_viewer(void **state)
{
    (void)state;
    double worst = 0;
    nest_square before = nest_square_at(255, 9, 0.7, 1);
    int64_t row = before.row + 5, column = before.column + 120; // one vertex, in the transition
    int moved = 0;
    for (int i = 1; i < 4000; i++) {
        nest_square now = nest_square_at(255, 9, 0.7 + i * before.step * 1e-2, 1);
        double a = nest_alpha(&before, (double)(row - before.row),
                              (double)(column - before.column)),
               b = nest_alpha(&now, (double)(row - now.row), (double)(column - now.column));
        worst = fmax(worst, fabs(a - b));
        moved += now.row != before.row;
        before = now;
    }
    print_message("largest change of alpha in a hundredth of a step: %.2e; the square moved %d "
                  "times\n",
                  worst, moved);
    assert_true(moved >= 15);
    assert_true(worst <= 1.01e-2 / nest_transition_width(255));
    assert_true(worst > 0);
}

// n~, e~, v~ in long double, from the definition: components of the unit vector of the reduced
// latitude along north, east and up of the focus.
static void ring_of_place(double a_over_b, double lat, double lon, double lat0, double lon0,
                          long double out[3])
{
    long double q = 1 / (long double)a_over_b;
    long double b = atan2l(q * sinl(lat), cosl(lat)), b0 = atan2l(q * sinl(lat0), cosl(lat0)),
                dl = (long double)lon - lon0;
    out[0] = sinl(b) * cosl(b0) - cosl(b) * sinl(b0) * cosl(dl);
    out[1] = cosl(b) * sinl(dl);
    out[2] = 1 - (sinl(b) * sinl(b0) + cosl(b) * cosl(b0) * cosl(dl));
}

static void test_terms_are_the_place(void **state)
{
    (void)state;
    struct check_random r = {8};
    double worst = 0;
    for (int i = 0; i < 40000; i++) {
        double lat, lon;
        random_place(&r, &lat, &lon);
        lon = remainder(lon, 2 * M_PI);
        struct geo_focus f = geo_focus_make(GEO_WGS84, lat, lon, (dvec3){7e6, 0, 0}, 0);
        int level = i % 22, row = (int)check_random_range(&r, 0, 255),
            column = (int)check_random_range(&r, 0, 257);
        nest_square s = nest_square_at(255, level, lat, lon);
        nest_row a = nest_row_at(&s, &f, row);
        nest_column b = nest_column_at(&s, &f, column);
        double at = nest_latitude(&s, row), around = (column - s.view_column) * s.step;
        float fall = a.w * b.d,
              got[3] = {a.s + (float)f.sb * fall, a.w * b.t, a.c + (float)f.cb * fall};
        long double want[3];
        ring_of_place(f.r, at, lon + around, lat, lon, want);
        double scale = 256 * s.step; // of the square
        for (int k = 0; k < 3; k++) worst = fmax(worst, fabs((double)(got[k] - want[k])) / scale);
        check_near(a.dlat, at - lat, 3e-7 * scale);
        check_near(b.dlon, around, 3e-7 * scale);
    }
    print_message("ring coordinates: off by at most %.1e of a square's side\n", worst);
    assert_true(worst <= 2.5e-7);
}

// Bit for bit, so that a border is one line.
static void test_levels_share_vertices(void **state)
{
    (void)state;
    struct check_random r = {15};
    for (int i = 0; i < 5000; i++) {
        double lat, lon;
        random_place(&r, &lat, &lon);
        struct geo_focus f = geo_focus_make(GEO_WGS84, lat, lon, (dvec3){7e6, 0, 0}, 0);
        int level = i % 21, k = 2 * (int)check_random_range(&r, 0, 127);
        nest_square coarse = nest_square_at(255, level, lat, lon),
                    fine = nest_square_at(255, level + 1, lat, lon);
        nest_row row = nest_row_at(&fine, &f, k),
                 row_above = nest_row_at(&coarse, &f, (int)((fine.row + k) / 2 - coarse.row));
        nest_column column = nest_column_at(&fine, &f, k),
                    column_above =
                        nest_column_at(&coarse, &f, (int)((fine.column + k) / 2 - coarse.column));
        assert_memory_equal(&row, &row_above, 3 * sizeof(float));
        assert_memory_equal(&column, &column_above, 2 * sizeof(float));
    }
    // The whole circle closes.
    struct geo_focus f = geo_focus_make(GEO_WGS84, 0.5, 2, (dvec3){7e6, 0, 0}, 0);
    nest_square s = nest_square_at(255, 0, 0.5, 2);
    nest_column first = nest_column_at(&s, &f, 0), last = nest_column_at(&s, &f, 256);
    assert_memory_equal(&first, &last, 2 * sizeof(float));
}

// A pole's row is one point.
static void test_poles_are_points(void **state)
{
    (void)state;
    for (int south = 0; south < 2; south++) {
        double lat = south ? -1.5 : 1.5;
        struct geo_focus f = geo_focus_make(GEO_WGS84, lat, 1, (dvec3){0, 0, 7e6}, 0);
        nest_square s = nest_square_at(255, 2, lat, 1);
        nest_row beyond = nest_row_at(&s, &f, south ? 254 : 0);
        assert_true(beyond.w == 0);
        long double want[3];
        ring_of_place(f.r, copysign(M_PI / 2, lat), 0, lat, 1, want);
        check_near(beyond.s, (double)want[0], 1e-8);
        check_near(beyond.c, (double)want[2], 1e-8);
    }
}

// Brute force: every place seen within the angle lies in the square, and no coarser level would
// do without being the answer.
static void test_coarsest_level_holds_what_is_seen(void **state)
{
    (void)state;
    struct check_random r = {23};
    int levels[3] = {0};
    for (int i = 0; i < 3000; i++) {
        double lat = check_random_range(&r, -1.4, 1.4), lon = check_random_range(&r, -3, 3);
        double angle = pow(10, check_random_range(&r, -7, 0.2));
        struct geo_focus f = geo_focus_make(GEO_WGS84, lat, lon, (dvec3){7e6, 0, 0}, 0);
        int level = nest_coarsest_level(255, &f, angle, 22);
        levels[level == 0 ? 0 : level == 21 ? 2 : 1]++;
        assert_int_equal(nest_holds_pole(&f, angle), fabs(f.reduced) + angle >= M_PI / 2);
        if (!level) continue;
        double half = nest_half_side(255, level), reach = 0;
        for (int k = 0; k < 64; k++) {
            double az = k * M_PI / 32;
            double n = sin(angle) * cos(az), e = sin(angle) * sin(az), u = cos(angle);
            double x = f.cb * u - f.sb * n, z = f.sb * u + f.cb * n;
            reach = fmax(reach, fabs(atan2(e, x)));
            reach = fmax(reach, fabs(atan2(f.r * z, hypot(x, e)) - lat));
        }
        assert_true(reach <= half);
        if (level < 21) assert_true(reach > 0.9 * nest_half_side(255, level + 1));
    }
    assert_true(levels[0] > 100 && levels[1] > 1000 && levels[2] > 1);
}

static void test_finest_level(void **state)
{
    (void)state;
    double share, radius = 6378137;
    for (int level = 3; level < 20; level++) {
        double side = radius * 255 * 2 * M_PI / 256 / (1 << level), at = side / 2.5;
        assert_int_equal(nest_finest_level(255, radius, at * 1.001, 22, &share), level - 1);
        check_near(share, 1, 0);
        assert_int_equal(nest_finest_level(255, radius, at * 0.999, 22, &share), level);
        assert_true(share < 0.01);
        assert_int_equal(nest_finest_level(255, radius, at * 0.75, 22, &share), level);
        check_near(share, 2 * log2(1 / 0.75), 1e-9);
    }
    assert_int_equal(nest_finest_level(255, radius, 0, 22, &share), 21);
    assert_int_equal(nest_finest_level(255, radius, 1e12, 22, &share), 0);
}

static void test_sizes(void **state)
{
    (void)state;
    int valid = 0;
    for (int n = -5; n < 5000; n++) valid += nest_size_valid(n);
    assert_int_equal(valid, 6);
    for (int i = 0; i < 6; i++) assert_true(nest_size_valid(SIZES[i]));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_squares_nest),
        cmocka_unit_test(test_alpha_follows_the_viewer),
        cmocka_unit_test(test_terms_are_the_place),
        cmocka_unit_test(test_levels_share_vertices),
        cmocka_unit_test(test_poles_are_points),
        cmocka_unit_test(test_coarsest_level_holds_what_is_seen),
        cmocka_unit_test(test_finest_level),
        cmocka_unit_test(test_sizes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
