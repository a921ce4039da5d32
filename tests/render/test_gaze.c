// Where the rings' focus stands, on the analytic planet (relief below 10 km, slopes below 0.01).
#include "render/gaze.h"
#include "render/scene.h"

static struct planet_file *file;
static struct pyramid *pyramid;

static geo_camera camera(double height, double pitch_deg, double fov_deg)
{
    return (geo_camera){.position = {0.7, 3.1, height},
                        .heading = 0.5,
                        .pitch = pitch_deg * M_PI / 180,
                        .fov_y = fov_deg * M_PI / 180};
}

static double angle_from_nadir(const geo_camera *c, gaze g)
{
    dvec3 a = geo_normal(c->position.lat, c->position.lon), b = geo_normal(g.lat, g.lon);
    return 2 * asin(dvec3_length(dvec3_sub(a, b)) / 2);
}

static void test_wide_views_stand_over_the_nadir(void **state)
{
    (void)state;
    const double fov[] = {45, 60, 90, 170};
    for (int i = 0; i < 4; i++) {
        geo_camera c = camera(20000, -20, fov[i]);
        gaze g = gaze_find(pyramid, &c, 4 / 3.0);
        assert_true(g.lat == c.position.lat && g.lon == c.position.lon);
        check_near(g.distance, 20000 - analytic_height(0.7, 3.1), 500);
    }
}

static void test_sky_leaves_the_nadir(void **state)
{
    (void)state;
    geo_camera c = camera(20000, 40, 5);
    gaze g = gaze_find(pyramid, &c, 4 / 3.0);
    assert_true(g.lat == c.position.lat && g.lon == c.position.lon);
}

// The point of the ellipsoid in the middle of the picture, by quadratic equation.
static void test_narrow_views_stand_where_they_look(void **state)
{
    (void)state;
    const double heights[] = {15000, 4e5, 1e7};
    for (int i = 0; i < 3; i++) {
        geo_camera c = camera(heights[i], -70, 2);
        gaze g = gaze_find(pyramid, &c, 4 / 3.0);
        dvec3 eye = geo_ecef_from_geodetic(GEO_WGS84, c.position);
        dvec3 ahead = dvec3_scale(geo_eye_from_ecef(&c).row[2], -1);
        double t = geo_ray_ellipsoid(GEO_WGS84, 0, eye, ahead);
        geodetic hit = geo_geodetic_from_ecef(GEO_WGS84, dvec3_mad(eye, ahead, t));
        double off = 6.4e6 * hypot(g.lat - hit.lat, (g.lon - hit.lon) * cos(hit.lat));
        print_message("%.0f m: %.0f m from the middle, %.0f of %.0f m away\n", heights[i], off,
                      g.distance, t);
        assert_true(off < 3000 + 0.02 * t);
        check_near(g.distance / t, 1, 0.05 + 5e3 / t);
    }
}

// No jump as the field of view narrows from one regime to the other.
static void test_slides_with_the_field_of_view(void **state)
{
    (void)state;
    geo_camera c = camera(4e5, -40, 50);
    double before = 0, whole;
    for (double fov = 50; fov >= 15; fov -= 0.25) {
        c.fov_y = fov * M_PI / 180;
        double angle = angle_from_nadir(&c, gaze_find(pyramid, &c, 4 / 3.0));
        assert_true(angle >= before - 1e-3);
        assert_true(angle - before < 4e-3);
        before = whole = angle;
    }
    assert_true(whole > 0.06);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_wide_views_stand_over_the_nadir),
        cmocka_unit_test(test_sky_leaves_the_nadir),
        cmocka_unit_test(test_narrow_views_stand_where_they_look),
        cmocka_unit_test(test_slides_with_the_field_of_view),
    };
    int rc = scene_open();
    if (rc) return rc;
    perigee_planet *planet = scene_planet();
    pyramid_params tiles = {0};
    if (planet_file_open("analytic.planet", &file) || pyramid_create(file, &tiles, &pyramid))
        return scene_close(1);
    rc = cmocka_run_group_tests(tests, NULL, NULL);
    pyramid_destroy(&pyramid);
    planet_file_close(&file);
    perigee_planet_close(&planet);
    return scene_close(rc);
}
