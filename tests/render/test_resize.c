// Sizes of modes: every one of them is a mesh that can be made, size 1 is the default's, and a
// larger one has no fewer vertices. Fails when broken: steps that are no multiple of 64, a grid
// beyond its vertices, squares as wide as their windows.
#include "check.h"

#include "render/geometry.h"
#include "render/params.h"

// Grows with the vertices that the parameters ask for, of whatever mode.
static double vertices(const perigee_view_params *p)
{
    double per_area = p->ring_spacing_px * p->ring_spacing_px;
    return (double)p->azimuth_steps * p->rings_per_level / per_area + p->planar_triangles +
           (double)p->grid_rows * p->grid_columns;
}

static void test_sizes(void **state)
{
    (void)state;
    int resized = 0;
    for (int mode = 0; perigee_mode_name((enum perigee_mode)mode); mode++) {
        double last = 0;
        resized += geometry_mode_find((enum perigee_mode)mode)->resize != NULL;
        for (double size = 1.0 / 64; size <= 16; size *= 1.04) {
            perigee_view_params p = {.mode = (enum perigee_mode)mode, .levels = 20};
            if (!perigee_view_params_resize(&p, size, 300000)) break;
            assert_int_equal(params_complete(&p), OK);
            assert_int_equal(p.levels, 20);
            assert_true(vertices(&p) >= last);
            last = vertices(&p);
        }
    }
    assert_true(resized >= 3);
}

static void test_default(void **state)
{
    (void)state;
    for (int mode = 0; perigee_mode_name((enum perigee_mode)mode); mode++) {
        perigee_view_params p = {.mode = (enum perigee_mode)mode}, usual = p;
        if (!perigee_view_params_resize(&p, 1, 0)) continue;
        assert_int_equal(params_complete(&p), OK);
        assert_int_equal(params_complete(&usual), OK);
        assert_int_equal(p.azimuth_steps, usual.azimuth_steps);
        assert_int_equal(p.rings_per_level, usual.rings_per_level);
        check_near(p.ring_spacing_px, usual.ring_spacing_px, 0);
        assert_int_equal(p.texels, usual.texels);
        assert_int_equal(p.planar_n, usual.planar_n);
        assert_int_equal(p.planar_triangles, 0);
        assert_int_equal(p.grid_rows, usual.grid_rows);
        assert_int_equal(p.grid_columns, usual.grid_columns);
    }
}

static void test_refused(void **state)
{
    (void)state;
    perigee_view_params p = {.mode = PERIGEE_MODE_GRID}, none = {.mode = (enum perigee_mode)99};
    static const double sizes[] = {0, -1, NAN};
    for (int i = 0; i < 3; i++) assert_false(perigee_view_params_resize(&p, sizes[i], 0));
    assert_int_equal(p.grid_rows, 0);
    assert_false(perigee_view_params_resize(&none, 1, 0));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sizes),
        cmocka_unit_test(test_default),
        cmocka_unit_test(test_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
