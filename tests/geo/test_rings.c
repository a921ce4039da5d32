#include "check.h"

#include "base/vec.h"
#include "geo/rings.h"

static const ring_params shapes[] = {{512, 20, 22}, {1024, 40, 22}, {48, 3, 5}, {20, 7, 4}};
enum { SHAPES = sizeof shapes / sizeof *shapes };

static void counts(void **state)
{
    (void)state;
    assert_int_equal(ring_columns(&shapes[0]), 514);
    assert_int_equal(ring_count(&shapes[0]), 441);
}

static void angles_halve(void **state)
{
    (void)state;
    for (int s = 0; s < SHAPES; s++) {
        const ring_params *p = &shapes[s];
        for (int level = 0; level <= p->levels; level++) {
            double angle = ring_angle(p, level * p->rings_per_level);
            check_near(angle, ldexp(M_PI, -level), 0);
            check_near(ring_level_of_angle(angle), level, 1e-15);
        }
        for (int r = 1; r < ring_count(p); r++) {
            assert_true(ring_angle(p, r) < ring_angle(p, r - 1));
            check_near(ring_level_of_angle(ring_angle(p, r)) * p->rings_per_level, r, 1e-11);
        }
    }
    assert_true(isinf(ring_level_of_angle(0)));
}

// Columns 0 .. n/2 go north, east, south; n/2 + 1 .. n + 1 south, west, north.
static void directions(void **state)
{
    (void)state;
    for (int s = 0; s < SHAPES; s++) {
        const ring_params *p = &shapes[s];
        int n = p->azimuth_steps;
        for (int c = 0; c < ring_columns(p); c++) {
            double d[2], mirror[2];
            int k = c > n / 2 ? c - 1 : c;
            ring_direction(p, c, d);
            check_near(d[0], cos(2 * M_PI * k / n), 1e-15);
            check_near(d[1], sin(2 * M_PI * k / n), 1e-15);
            ring_direction(p, n + 1 - c, mirror);
            check_near(mirror[0], d[0], 0);
            check_near(mirror[1], -d[1], 0);
            if (k % n == 0 || k == n / 2) assert_true(d[1] == 0 && !signbit(d[1]));
            if (4 * k == n || 4 * k == 3 * n) assert_true(d[0] == 0 && !signbit(d[0]));
        }
    }
}

static void seam(void **state)
{
    (void)state;
    for (int s = 0; s < SHAPES; s++) {
        const ring_params *p = &shapes[s];
        int n = p->azimuth_steps;
        for (int r = 0; r < ring_count(p); r++) {
            float v[3];
            for (int c = 0; c < ring_columns(p); c++) {
                ring_vertex(p, r, c, v);
                assert_true(c <= n / 2 ? v[1] > 0 : v[1] < 0);
                int on_line = c == 0 || c == n / 2 || c == n / 2 + 1 || c == n + 1;
                assert_true((fabsf(v[1]) == RING_SEAM) == (on_line || r == 0));
            }
        }
    }
}

// Against long double, each attribute to half an ulp and a little.
static void vertices(void **state)
{
    (void)state;
    const ring_params *p = &shapes[1];
    for (int r = 0; r < ring_count(p); r += 7) {
        long double t = acosl(-1.0L) * exp2l(-(long double)r / p->rings_per_level);
        for (int c = 1; c < ring_columns(p); c += 13) {
            int k = c > p->azimuth_steps / 2 ? c - 1 : c;
            long double az = 2 * acosl(-1.0L) * k / p->azimuth_steps;
            long double radius = r ? sinl(t) : 0, half = sinl(t / 2);
            float v[3];
            ring_vertex(p, r, c, v);
            check_near(v[0], (double)(radius * cosl(az)), 6.1e-8 * fabs(v[0]) + 1e-18);
            check_near(v[1], (double)(radius * sinl(az)), 6.1e-8 * fabs(v[1]) + 1e-18);
            check_near(v[2], (double)(2 * half * half), 6.1e-8 * fabs(v[2]));
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(counts), cmocka_unit_test(angles_halve), cmocka_unit_test(directions),
        cmocka_unit_test(seam),   cmocka_unit_test(vertices),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
