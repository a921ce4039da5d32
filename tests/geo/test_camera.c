#include "check.h"

#include "geo/camera.h"

#define DEG (M_PI / 180)

static geo_camera camera(double lat, double lon, double heading, double pitch, double roll)
{
    return (geo_camera){.position = {lat * DEG, lon * DEG, 1000},
                        .heading = heading * DEG,
                        .pitch = pitch * DEG,
                        .roll = roll * DEG,
                        .fov_y = 1};
}

static void check_vec(dvec3 got, double x, double y, double z)
{
    check_near(got.x, x, 1e-15);
    check_near(got.y, y, 1e-15);
    check_near(got.z, z, 1e-15);
}

// At lat 0, lon 0 east is +y, north +z, up +x. The third row points backwards.
static void conventions(void **state)
{
    (void)state;
    geo_camera north = camera(0, 0, 0, 0, 0);
    dmat3 m = geo_eye_from_ecef(&north);
    check_vec(m.row[0], 0, 1, 0);
    check_vec(m.row[1], 1, 0, 0);
    check_vec(m.row[2], 0, 0, -1);
    geo_camera east = camera(0, 0, 90, 0, 0);
    m = geo_eye_from_ecef(&east);
    check_vec(m.row[0], 0, 0, -1);
    check_vec(m.row[2], 0, -1, 0);
    geo_camera down = camera(0, 0, 0, -90, 0);
    m = geo_eye_from_ecef(&down);
    check_vec(m.row[0], 0, 1, 0);
    check_vec(m.row[1], 0, 0, 1);
    check_vec(m.row[2], 1, 0, 0);
    geo_camera rolled = camera(0, 0, 0, 0, 90); // clockwise: the right hand goes down
    m = geo_eye_from_ecef(&rolled);
    check_vec(m.row[0], -1, 0, 0);
    check_vec(m.row[1], 0, 1, 0);
    geo_camera pole = camera(90, 90, 0, 0, 0); // north at the pole continues the meridian of 90 E
    m = geo_eye_from_ecef(&pole);
    check_vec(m.row[2], 0, 1, 0);
    check_vec(m.row[1], 0, 0, 1);
}

static double difference(dmat3 a, dmat3 b)
{
    double d = 0;
    for (int i = 0; i < 3; i++) d = fmax(d, dvec3_length(dvec3_sub(a.row[i], b.row[i])));
    return d;
}

static void is_rotation(dmat3 m)
{
    check_near(dvec3_length(dvec3_sub(dvec3_cross(m.row[0], m.row[1]), m.row[2])), 0, 1e-15);
    check_near(dvec3_dot(m.row[0], m.row[1]), 0, 1e-15);
    check_near(dvec3_length(m.row[0]), 1, 1e-15);
}

static void round_trips(void **state)
{
    (void)state;
    static const double lats[] = {-90, -45, 0, 30, 89.999999, 90};
    struct check_random random = {5};
    for (int i = 0; i < 30000; i++) {
        geo_camera c =
            camera(lats[i % 6], check_random_range(&random, -180, 180),
                   check_random_range(&random, 0, 360), check_random_range(&random, -89.9, 89.9),
                   check_random_range(&random, -180, 180));
        dmat3 m = geo_eye_from_ecef(&c);
        is_rotation(m);
        geo_camera back = {.position = c.position};
        geo_camera_orient(&back, m);
        double tol = 1e-15 / cos(c.pitch);
        check_near(remainder(back.heading - c.heading, 2 * M_PI), 0, tol);
        check_near(remainder(back.roll - c.roll, 2 * M_PI), 0, tol);
        check_near(back.pitch, c.pitch, tol);
        assert_true(back.heading >= 0 && back.heading < 2 * M_PI);
    }
}

// Straight up and down the picture is kept, with no roll.
static void vertical(void **state)
{
    (void)state;
    struct check_random random = {6};
    for (int i = 0; i < 2000; i++) {
        geo_camera c = camera(i % 3 ? 40 : 90, 10, check_random_range(&random, 0, 360),
                              i % 2 ? 90 : -90, check_random_range(&random, -180, 180));
        geo_camera back = {.position = c.position};
        dmat3 m = geo_eye_from_ecef(&c);
        geo_camera_orient(&back, m);
        check_near(back.roll, 0, 0);
        check_near(back.pitch, c.pitch, 1e-9);
        check_near(difference(geo_eye_from_ecef(&back), m), 0, 2e-9);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(conventions),
        cmocka_unit_test(round_trips),
        cmocka_unit_test(vertical),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
