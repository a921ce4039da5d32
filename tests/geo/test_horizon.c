// The horizon bound by brute force: from a point beyond it, at any terrain height, the line to the
// camera dives below the lowest terrain.
#include "check.h"

#include "geo/horizon.h"

static double height_at(geo_ellipsoid e, dvec3 a, dvec3 b, double t)
{
    dvec3 p = dvec3_add(dvec3_scale(a, 1 - t), dvec3_scale(b, t));
    return geo_geodetic_from_ecef(e, p).height;
}

// Lowest height on the segment a b: coarse scan, then ternary search around the lowest sample.
static double lowest_height(geo_ellipsoid e, dvec3 a, dvec3 b)
{
    enum { STEPS = 60 };
    int best = 0;
    double lowest = INFINITY;
    for (int i = 0; i <= STEPS; i++) {
        double h = height_at(e, a, b, (double)i / STEPS);
        if (h < lowest) {
            lowest = h;
            best = i;
        }
    }
    double low = fmax(best - 1, 0) / STEPS, high = fmin(best + 1, STEPS) / STEPS;
    for (int i = 0; i < 50; i++) {
        double l = low + (high - low) / 3, r = high - (high - low) / 3;
        if (height_at(e, a, b, l) < height_at(e, a, b, r)) high = r;
        else low = l;
    }
    return fmin(lowest, height_at(e, a, b, low));
}

// The terrain point at height h over the unit vector at an angle and azimuth from the direction of
// D^-1 camera.
static dvec3 point_over(geo_ellipsoid e, dvec3 camera, double angle, double azimuth, double h)
{
    dvec3 up = dvec3_normalize((dvec3){camera.x / e.a, camera.y / e.a, camera.z / e.b});
    dvec3 other = fabs(up.z) < 0.9 ? (dvec3){0, 0, 1} : (dvec3){1, 0, 0};
    dvec3 east = dvec3_normalize(dvec3_cross(other, up));
    dvec3 north = dvec3_cross(up, east);
    dvec3 u = dvec3_scale(up, cos(angle));
    u = dvec3_mad(u, east, sin(angle) * sin(azimuth));
    u = dvec3_mad(u, north, sin(angle) * cos(azimuth));
    dvec3 normal = dvec3_normalize((dvec3){u.x / e.a, u.y / e.a, u.z / e.b});
    return dvec3_mad((dvec3){u.x * e.a, u.y * e.a, u.z * e.b}, normal, h);
}

struct scene {
    geo_ellipsoid e;
    double floor_height, summit;
};

static const struct scene scenes[] = {
    {{.a = 6378137.0, .b = 6356752.314245179}, -418, 8848},
    {{.a = 6378137.0, .b = 6356752.314245179}, 0, 0},
    {{.a = 1737400.0, .b = 1737400.0}, -9000, 10800},
    {{.a = 3396190.0, .b = 3376200.0}, -8200, 21900},
    {{.a = 1000000.0, .b = 900000.0}, -5000, 20000},
};

static const double altitudes[] = {2, 100, 5000, 4e5, 2e7};
static const double lats[] = {0, 0.7, -1.2, M_PI / 2};

static void nothing_beyond_shows(void **state)
{
    (void)state;
    struct check_random random = {11};
    int tried = 0;
    for (size_t s = 0; s < sizeof scenes / sizeof *scenes; s++) {
        const struct scene *sc = &scenes[s];
        for (int k = 0; k < 20; k++) {
            geodetic at = {lats[k % 4], 0.3, altitudes[k / 4]};
            dvec3 camera = geo_ecef_from_geodetic(sc->e, at);
            double bound = geo_horizon_angle(sc->e, camera, sc->floor_height, sc->summit);
            assert_true(bound > 0 && bound <= M_PI);
            for (int i = 0; i < 60; i++) {
                double beyond = exp(check_random_range(&random, log(1e-9), log(0.5)));
                double h =
                    i % 2 ? sc->summit : check_random_range(&random, sc->floor_height, sc->summit);
                if (bound + beyond > M_PI) continue;
                dvec3 p = point_over(sc->e, camera, bound + beyond,
                                     check_random_range(&random, -M_PI, M_PI), h);
                assert_true(lowest_height(sc->e, camera, p) < sc->floor_height + 1e-6);
                tried++;
            }
        }
    }
    assert_true(tried > 4000);
}

// On a sphere the bound is the truth: just before it a summit still shows over the lowest terrain.
static void sphere_is_tight(void **state)
{
    (void)state;
    const struct scene *sc = &scenes[2];
    for (size_t k = 0; k < sizeof altitudes / sizeof *altitudes; k++) {
        dvec3 camera = geo_ecef_from_geodetic(sc->e, (geodetic){0.4, 1, altitudes[k]});
        double bound = geo_horizon_angle(sc->e, camera, sc->floor_height, sc->summit);
        dvec3 p = point_over(sc->e, camera, bound - 1e-6, 1, sc->summit);
        assert_true(lowest_height(sc->e, camera, p) > sc->floor_height);
        double r = sc->e.a, low = r + sc->floor_height;
        double want = acos(low / (r + altitudes[k])) + acos(low / (r + sc->summit));
        check_near(bound, want, 1e-12);
    }
}

// On the Earth it is at most this loose: the axes differ by 1/298, of the summit's share and of the
// camera's.
static void earth_is_near(void **state)
{
    (void)state;
    const struct scene *sc = &scenes[0];
    dvec3 camera = geo_ecef_from_geodetic(sc->e, (geodetic){0.8, 0, 2000});
    double bound = geo_horizon_angle(sc->e, camera, sc->floor_height, sc->summit);
    double want =
        acos((6.367e6 - 418) / (6.367e6 + 2000)) + acos((6.367e6 - 418) / (6.367e6 + 8848));
    check_near(bound, want, 0.005 * want);
}

static void inside(void **state)
{
    (void)state;
    geo_ellipsoid e = GEO_WGS84;
    dvec3 low = geo_ecef_from_geodetic(e, (geodetic){0, 0, -500});
    check_near(geo_horizon_angle(e, low, -418, 8848), M_PI, 0);
    check_near(geo_horizon_angle(e, (dvec3){0, 0, 0}, -418, 8848), M_PI, 0);
    check_near(geo_horizon_angle(e, (dvec3){NAN, 0, 0}, -418, 8848), M_PI, 0);
    dvec3 high = geo_ecef_from_geodetic(e, (geodetic){0, 0, -300});
    assert_true(geo_horizon_angle(e, high, -418, 8848) < 0.1);
}

static void pixel_size(void **state)
{
    (void)state;
    check_near(geo_pixel_size(1000, M_PI / 2, 1000), 2, 1e-12);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_beyond_shows), cmocka_unit_test(sphere_is_tight),
        cmocka_unit_test(earth_is_near),        cmocka_unit_test(inside),
        cmocka_unit_test(pixel_size),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
