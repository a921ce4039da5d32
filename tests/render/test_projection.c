// The projection's numbers against plain vector arithmetic in ECEF.
#include "check.h"

#include "render/projection.h"

static void test_unproject_meets_the_clip_matrix(void **state)
{
    (void)state;
    struct check_random r = {7};
    double worst = 0;
    for (int i = 0; i < 2000; i++) {
        geo_camera c = {.position = {check_random_range(&r, -1.57, 1.57),
                                     check_random_range(&r, -3, 3),
                                     pow(10, check_random_range(&r, 0, 8))},
                        .heading = check_random_range(&r, 0, 6),
                        .pitch = check_random_range(&r, -1.5, 1.5),
                        .roll = check_random_range(&r, -1, 1),
                        .fov_y = check_random_range(&r, 0.1, 2.5)};
        double jx = check_random_range(&r, -0.5, 0.5), jy = check_random_range(&r, -0.5, 0.5);
        projection p = projection_make(GEO_WGS84, &c, c.position.lat, c.position.lon, 640, 480);
        p.jitter_x = jx, p.jitter_y = jy;
        struct view_block b = {0};
        projection_fill_block(&p, dvec3_make(1, 0, 0), true, &b);
        double x = check_random_range(&r, 0, 640), y = check_random_range(&r, 0, 480),
               z = pow(10, check_random_range(&r, 0, 7));
        dvec3 m = projection_unproject(&p, x, y, z);
        m = dmat3_mul(p.focus.tangent_from_meridian, m);
        const float *f = b.clip_from_tangent;
        double clip[4];
        for (int k = 0; k < 4; k++)
            clip[k] = f[k] * m.x + f[4 + k] * m.y + f[8 + k] * m.z + f[12 + k];
        check_near((clip[0] / clip[3] + 1) * 320, x, 2e-3);
        check_near((1 - clip[1] / clip[3]) * 240, y, 2e-3);
        check_near(clip[2] / clip[3] * z, PROJECTION_NEAR_M, 1e-6);
        worst = fmax(worst, fabs((clip[0] / clip[3] + 1) * 320 - x));
    }
    print_message("worst %g px\n", worst); // measured 2e-4 at 2.5 rad of field of view
}

static void test_looking_straight_down_sees_the_nadir(void **state)
{
    (void)state;
    geo_camera c = {.position = {0.7, -2.1, 5000}, .pitch = -M_PI / 2, .fov_y = 1};
    projection p = projection_make(GEO_WGS84, &c, c.position.lat, c.position.lon, 100, 100);
    dvec3 m = projection_unproject(&p, 50, 50, 5000);
    dvec3 ecef =
        dvec3_add(p.camera_ecef, dmat3_mul(dmat3_transpose(p.focus.meridian_from_ecef), m));
    geodetic g = geo_geodetic_from_ecef(GEO_WGS84, ecef);
    check_near(g.lat, 0.7, 1e-12);
    check_near(g.lon, -2.1, 1e-12);
    check_near(g.height, 0, 1e-6);
}

static void test_level_range(void **state)
{
    (void)state;
    geo_camera c = {.position = {0.79, 0.19, 2}, .fov_y = 1};
    projection p = projection_make(GEO_WGS84, &c, c.position.lat, c.position.lon, 1280, 960);
    cell_view v = projection_cell_view(&p, -430, 4800);
    int ground = projection_first_level(&v);
    assert_in_range(ground, 4,
                    6); // a 4.8 km summit shows from 250 km: level 6 reaches 313 km, 5 twice that
    assert_int_equal(projection_last_level(&p, 2, 256, 22), 21);
    // The widest view: samples stay as small beside the height as they are at 120 degrees, where a
    // pixel at the centre is 1/277 of it. By that of 179 degrees they were a quarter.
    c.fov_y = 179 * M_PI / 180;
    c.position.height = 100;
    p = projection_make(GEO_WGS84, &c, c.position.lat, c.position.lon, 1280, 960);
    double rows = 256 * ldexp(1, projection_last_level(&p, 100, 256, 22));
    assert_true(2 * M_PI / rows * 6378137 <= 100 / 277.0);
    c.fov_y = 1;
    c.position.height = 2e7;
    p = projection_make(GEO_WGS84, &c, c.position.lat, c.position.lon, 1280, 960);
    v = projection_cell_view(&p, -430, 4800);
    assert_in_range(projection_first_level(&v), 0, 1);
    assert_in_range(projection_last_level(&p, 2e7, 256, 22), 2, 6);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_unproject_meets_the_clip_matrix),
        cmocka_unit_test(test_looking_straight_down_sees_the_nadir),
        cmocka_unit_test(test_level_range),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
