// The camera over a plane: a point that is dragged, zoomed at or orbited stays under the cursor,
// and moving goes along the map by the metre. Fails when broken: the ellipsoid's frame for the
// plane's, a drag the wrong way, a zoom about the map's origin.
#include "check.h"

#include "app/control_pose.h"

enum { WIDTH = 1280, HEIGHT = 960 };

static void test_plane(void **state)
{
    (void)state;
    geo_ellipsoid e = geo_plane_of(GEO_WGS84);
    struct pose_screen screen = {WIDTH, HEIGHT};
    struct check_random r = {7};
    for (int i = 0; i < 200; i++) {
        geo_camera c = {.position = {check_random_range(&r, -1, 1), check_random_range(&r, -3, 3),
                                     pow(10, check_random_range(&r, 2, 6))},
                        .heading = check_random_range(&r, -3, 3),
                        .pitch = check_random_range(&r, -1.5, -0.5),
                        .fov_y = 1};
        double x = check_random_range(&r, 0, WIDTH), y = check_random_range(&r, 0, HEIGHT), gx, gy;
        dvec3 dir = pose_ray(e, &c, screen, x, y), eye = geo_ecef_from_geodetic(e, c.position);
        dvec3 point = dvec3_mad(eye, dir, eye.x / -dir.x);
        if (dir.x > -0.1) continue;
        struct pose_grab grab = pose_grab_make(e, &c, point);
        geo_camera before = c;
        double tx = WIDTH / 2, ty = HEIGHT / 2;
        pose_drag(e, &c, &grab, pose_eye_ray(&c, screen, tx, ty));
        assert_true(pose_project(e, &c, screen, point, &gx, &gy));
        check_near(hypot(gx - tx, gy - ty), 0, 1e-5);
        check_near(c.position.height, before.position.height, 1e-6);
        check_near(c.heading, before.heading, 0);
        pose_zoom(e, &c, point, pose_eye_ray(&c, screen, tx, ty), 0.5);
        assert_true(pose_project(e, &c, screen, point, &gx, &gy));
        check_near(hypot(gx - tx, gy - ty), 0, 1e-4);
        check_near(c.position.height, 0.5 * before.position.height, 1e-6);
        pose_orbit(e, &c, point, pose_eye_ray(&c, screen, tx, ty), 0.3, 0);
        assert_true(pose_project(e, &c, screen, point, &gx, &gy));
        check_near(hypot(gx - tx, gy - ty), 0, 1e-3);
        geo_camera moved = c;
        pose_move(e, &moved, 0, 100);
        check_near((moved.position.lat - c.position.lat) * e.a, 100 * cos(c.heading), 1e-5);
        check_near((moved.position.lon - c.position.lon) * e.a, 100 * sin(c.heading), 1e-5);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_plane)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
