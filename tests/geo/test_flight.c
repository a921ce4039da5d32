#include "check.h"

#include "geo/flight.h"
#include "geo/geographic.h"

#define DEG (M_PI / 180)

static const geo_ellipsoid earth = {.a = 6378137.0, .b = 6356752.314245179};

static flight_key key(double time_s, double lat, double lon, double alt, double heading,
                      double pitch)
{
    return (flight_key){.time_s = time_s,
                        .camera = {.position = {lat * DEG, lon * DEG, alt},
                                   .heading = heading * DEG,
                                   .pitch = pitch * DEG,
                                   .fov_y = 60 * DEG}};
}

static double eye_difference(const geo_camera *a, const geo_camera *b)
{
    dmat3 m = geo_eye_from_ecef(a), n = geo_eye_from_ecef(b);
    double d = 0;
    for (int i = 0; i < 3; i++) d = fmax(d, dvec3_length(dvec3_sub(m.row[i], n.row[i])));
    return d;
}

static double place_difference(const geo_camera *a, const geo_camera *b)
{
    return dvec3_length(dvec3_sub(geo_ecef_from_geodetic(earth, a->position),
                                  geo_ecef_from_geodetic(earth, b->position)));
}

// Distance on the ground, m.
static double ground_distance(const geo_camera *a, const geo_camera *b)
{
    double unused;
    return geographic_distance(earth.a, earth.b, a->position.lat / DEG, a->position.lon / DEG,
                               b->position.lat / DEG, b->position.lon / DEG, &unused, &unused);
}

static flight_key tour[9];
enum { TOUR = sizeof tour / sizeof *tour };

static int make_tour(void **state)
{
    (void)state;
    tour[0] = key(0, 0, 0, 2e7, 0, -90);
    tour[1] = key(20, 45.6, 10.7, 3000, 30, -20);
    tour[2] = key(25, 45.6, 10.7, 3000, 330, -10); // turns on the spot
    tour[3] = key(40, 46, 12, 500, 100, 5);
    tour[4] = key(60, 85, 170, 50000, 20, -30);
    tour[5] = key(70, 90, -10, 50000, 200, -30); // at the pole
    tour[6] = key(72, 90, 50, 60000, 200, -40);  // still at the pole, named by another meridian
    tour[7] = key(90, -30, -175, 10000, 250, -10);
    tour[8] = key(100, -31, 178, 20, 90, 0);
    tour[4].camera.roll = 170 * DEG;
    tour[5].camera.roll = -170 * DEG;
    return 0;
}

static void passes_keys(void **state)
{
    (void)state;
    struct flight *f = flight_create(earth, tour, TOUR);
    check_near(flight_duration_s(f), 100, 0);
    for (int i = 0; i < TOUR; i++) {
        for (int side = -1; side <= 1; side++) {
            geo_camera c = flight_at(f, tour[i].time_s + side * 1e-10);
            check_near(place_difference(&c, &tour[i].camera), 0, side ? 0.01 : 1e-6);
            check_near(eye_difference(&c, &tour[i].camera), 0, side ? 1e-8 : 1e-9);
            check_near(c.fov_y, 60 * DEG, 1e-12);
        }
    }
    geo_camera before = flight_at(f, -5), after = flight_at(f, 500), lost = flight_at(f, NAN);
    check_near(place_difference(&before, &tour[0].camera), 0, 0);
    check_near(place_difference(&after, &tour[TOUR - 1].camera), 0, 0);
    check_near(place_difference(&lost, &tour[0].camera), 0, 0);
    flight_destroy(&f);
    assert_null(f);
    flight_destroy(&f);
}

// Halving the step halves the largest change: nowhere a jump, in place, altitude or orientation.
static void is_continuous(void **state)
{
    (void)state;
    struct flight *f = flight_create(earth, tour, TOUR);
    double eye_step[2] = {0}, place_step[2] = {0};
    for (int pass = 0; pass < 2; pass++) {
        int steps = 8000 << pass;
        geo_camera last = flight_at(f, 0);
        for (int i = 1; i <= steps; i++) {
            geo_camera c = flight_at(f, 100.0 * i / steps);
            eye_step[pass] = fmax(eye_step[pass], eye_difference(&c, &last));
            place_step[pass] =
                fmax(place_step[pass],
                     place_difference(&c, &last) / fmin(c.position.height, last.position.height));
            assert_true(fabs(c.position.lon) <= M_PI && fabs(c.position.lat) <= M_PI / 2);
            assert_true(c.heading >= 0 && c.heading <= 2 * M_PI);
            last = c;
        }
    }
    check_near(eye_step[1] / eye_step[0], 0.5, 0.05);
    check_near(place_step[1] / place_step[0], 0.5, 0.05);
    flight_destroy(&f);
}

// The rates have no jump at the keys either: difference quotients from both sides agree.
static void keys_are_smooth(void **state)
{
    (void)state;
    struct flight *f = flight_create(earth, tour, TOUR);
    const double h = 1e-5;
    for (int i = 1; i + 1 < TOUR; i++) {
        double t = tour[i].time_s;
        geo_camera a = flight_at(f, t - h), b = flight_at(f, t), c = flight_at(f, t + h);
        double before = log(b.position.height / a.position.height) / h;
        double after = log(c.position.height / b.position.height) / h;
        check_near(after, before, 1e-3);
        check_near((c.pitch - b.pitch) / h, (b.pitch - a.pitch) / h, 1e-3);
        double speed_before = ground_distance(&a, &b) / h,
               speed_after = ground_distance(&b, &c) / h;
        check_near(speed_after, speed_before, 1e-3 * (speed_before + speed_after) + 3);
    }
    flight_destroy(&f);
}

// Between keys: on the geodesic, ever onward, altitude and pitch within the keys' own.
static void stays_between(void **state)
{
    (void)state;
    struct flight *f = flight_create(earth, tour, TOUR);
    for (int i = 0; i + 1 < TOUR; i++) {
        const geo_camera *a = &tour[i].camera, *b = &tour[i + 1].camera;
        double whole = ground_distance(a, b), last = 0;
        for (int k = 1; k < 50; k++) {
            double t = tour[i].time_s + (tour[i + 1].time_s - tour[i].time_s) * k / 50;
            geo_camera c = flight_at(f, t);
            double from = ground_distance(a, &c), to = ground_distance(&c, b);
            check_near(from + to, whole, 1e-6);
            assert_true(from >= last - 1e-6);
            last = from;
            double low = fmin(a->position.height, b->position.height);
            double high = fmax(a->position.height, b->position.height);
            assert_true(c.position.height >= low * (1 - 1e-12));
            assert_true(c.position.height <= high * (1 + 1e-12));
            assert_true(c.pitch >= fmin(a->pitch, b->pitch) - 1e-12);
            assert_true(c.pitch <= fmax(a->pitch, b->pitch) + 1e-12);
        }
    }
    flight_destroy(&f);
}

// Straight over a pole the eye turns with the ground point and no faster: angle a second = ground
// speed / radius of curvature, which lies between b^2/a and a^2/b.
static void pole_crossing(void **state)
{
    (void)state;
    for (int south = 0; south < 2; south++) {
        double sign = south ? -1 : 1;
        flight_key keys[] = {key(0, sign * 80, 20, 5000, south ? 180 : 0, -25),
                             key(10, sign * 80, -160, 5000, south ? 0 : 180, -25)};
        struct flight *f = flight_create(earth, keys, 2);
        double speed = ground_distance(&keys[0].camera, &keys[1].camera) / 10;
        const int steps = 2001; // a step straddles the pole
        geo_camera last = flight_at(f, 0);
        double largest = 0, smallest = 1, top = 0;
        for (int i = 1; i <= steps; i++) {
            geo_camera c = flight_at(f, 10.0 * i / steps);
            double rate = eye_difference(&c, &last) * steps / 10;
            largest = fmax(largest, rate);
            smallest = fmin(smallest, rate);
            top = fmax(top, fabs(c.position.lat));
            last = c;
        }
        assert_true(top > 89.99 * DEG);
        assert_true(largest < speed * earth.a / (earth.b * earth.b) * 1.0001);
        assert_true(smallest > speed * earth.b / (earth.a * earth.a) * 0.9999);
        flight_destroy(&f);
    }
}

// At a slant past the pole: still only the geodesic's own rate.
static void pole_passage(void **state)
{
    (void)state;
    double azimuth1, azimuth2;
    geographic_distance(earth.a, earth.b, 88, 0, 88, 179.9, &azimuth1, &azimuth2);
    flight_key keys[] = {key(0, 88, 0, 5000, azimuth1, -25),
                         key(10, 88, 179.9, 5000, azimuth2, -25)};
    struct flight *f = flight_create(earth, keys, 2);
    double speed = ground_distance(&keys[0].camera, &keys[1].camera) / 10;
    geo_camera last = flight_at(f, 0);
    for (int i = 1; i <= 5000; i++) {
        geo_camera c = flight_at(f, 10.0 * i / 5000);
        assert_true(eye_difference(&c, &last) * 500 < 1.01 * speed / earth.b);
        last = c;
    }
    flight_destroy(&f);
}

static void antimeridian(void **state)
{
    (void)state;
    flight_key keys[] = {key(0, 10, 179, 5000, 90, 0), key(10, 10, -179, 5000, 90, 0)};
    struct flight *f = flight_create(earth, keys, 2);
    for (int i = 0; i <= 100; i++) {
        geo_camera c = flight_at(f, i * 0.1);
        assert_true(fabs(c.position.lon) >= 179 * DEG - 1e-12);
        check_near(c.position.lat, 10 * DEG, 0.01 * DEG);
    }
    flight_destroy(&f);
}

// 350 to 10 degrees is a turn of 20 through north, also where the same place has two names.
static void turn_on_the_spot(void **state)
{
    (void)state;
    flight_key keys[] = {key(0, 10, 180, 5000, 350, 0), key(10, 10, -180, 5000, 10, 0)};
    struct flight *f = flight_create(earth, keys, 2);
    for (int i = 0; i <= 20; i++) {
        geo_camera c = flight_at(f, i * 0.5);
        check_near(remainder(c.heading / DEG - (i - 10), 360), 0, 1e-9);
        check_near(place_difference(&c, &keys[0].camera), 0, 1e-8);
    }
    flight_destroy(&f);
    flight_key pole[] = {key(0, -90, 0, 5000, 0, 0), key(1, -90, 120, 5000, 240, 0)};
    f = flight_create(earth, pole, 2);
    geo_camera c = flight_at(f, 0.5);
    check_near(eye_difference(&c, &pole[0].camera), 0, 1e-9);
    check_near(eye_difference(&c, &pole[1].camera), 0, 1e-9);
    flight_destroy(&f);
}

// While the altitude falls by powers the ground moves by the same share of it a second; at one
// altitude, evenly.
static void even_on_the_screen(void **state)
{
    (void)state;
    flight_key keys[] = {key(0, 0, 0, 1e6, 0, -90), key(10, 10, 10, 1e3, 0, -90)};
    struct flight *f = flight_create(earth, keys, 2);
    double least = 1e99, most = 0;
    for (int i = 0; i < 100; i++) {
        geo_camera a = flight_at(f, i * 0.1), b = flight_at(f, (i + 1) * 0.1);
        double rate = ground_distance(&a, &b) / sqrt(a.position.height * b.position.height);
        least = fmin(least, rate);
        most = fmax(most, rate);
    }
    check_near(most / least, 1, 1e-3);
    flight_destroy(&f);
    flight_key level[] = {key(0, 0, 0, 100, 90, 0), key(10, 0, 0.0224577, 100, 90, 0)};
    f = flight_create(earth, level, 2);
    for (int i = 0; i < 100; i++) {
        geo_camera a = flight_at(f, i * 0.1), b = flight_at(f, (i + 1) * 0.1);
        check_near(ground_distance(&a, &b), 25, 1e-3);
    }
    flight_destroy(&f);
}

static void fov_defaults(void **state)
{
    (void)state;
    flight_key keys[] = {key(0, 0, 0, 100, 0, 0), key(1, 0, 1, 100, 0, 0), key(2, 0, 2, 100, 0, 0)};
    keys[0].camera.fov_y = keys[1].camera.fov_y = keys[2].camera.fov_y = 0;
    struct flight *f = flight_create(earth, keys, 3);
    check_near(flight_at(f, 0.5).fov_y, 0, 0);
    flight_destroy(&f);
    keys[1].camera.fov_y = 1;
    f = flight_create(earth, keys, 3);
    for (int i = 0; i <= 4; i++) check_near(flight_at(f, i * 0.5).fov_y, 1, 1e-15);
    flight_destroy(&f);
}

static void rejects(void **state)
{
    (void)state;
    flight_key good[] = {key(0, 0, 0, 100, 0, 0), key(1, 0, 1, 100, 0, 0)};
    struct flight *f = flight_create(earth, good, 1);
    assert_non_null(f);
    check_near(flight_duration_s(f), 0, 0);
    check_near(flight_at(f, 3).position.height, 100, 0);
    flight_destroy(&f);
    assert_null(flight_create(earth, good, 0));
    flight_key bad[2];
#define CHECK_BAD(change)                                                                          \
    memcpy(bad, good, sizeof bad);                                                                 \
    change;                                                                                        \
    assert_null(flight_create(earth, bad, 2))
    CHECK_BAD(bad[1].time_s = 0);
    CHECK_BAD(bad[1].time_s = -1);
    CHECK_BAD(bad[1].time_s = NAN);
    CHECK_BAD(bad[1].time_s = INFINITY);
    CHECK_BAD(bad[0].camera.position.height = 0);
    CHECK_BAD(bad[0].camera.position.height = INFINITY);
    CHECK_BAD(bad[0].camera.position.lat = 1.6);
    CHECK_BAD(bad[0].camera.position.lon = NAN);
    CHECK_BAD(bad[0].camera.heading = NAN);
    CHECK_BAD(bad[1].camera.pitch = INFINITY);
    CHECK_BAD(bad[1].camera.roll = NAN);
    CHECK_BAD(bad[1].camera.fov_y = 4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(passes_keys),
        cmocka_unit_test(is_continuous),
        cmocka_unit_test(keys_are_smooth),
        cmocka_unit_test(stays_between),
        cmocka_unit_test(pole_crossing),
        cmocka_unit_test(pole_passage),
        cmocka_unit_test(antimeridian),
        cmocka_unit_test(turn_on_the_spot),
        cmocka_unit_test(even_on_the_screen),
        cmocka_unit_test(fov_defaults),
        cmocka_unit_test(rejects),
    };
    return cmocka_run_group_tests(tests, make_tour, NULL);
}
