// Ellipsoid and frames against GeographicLib::Geocentric, and against themselves where they must
// close.
#include "check.h"

#include "geo/ellipsoid.h"
#include "geo/geographic.h"

#define DEG (M_PI / 180)

static const geo_ellipsoid bodies[] = {
    {.a = 6378137.0, .b = 6356752.314245179}, // WGS84
    {.a = 1737400.0, .b = 1737400.0},         // the Moon's sphere
    {.a = 3396190.0, .b = 3376200.0},         // Mars
    {.a = 1000000.0, .b = 1050000.0},         // prolate
};
enum { BODIES = sizeof bodies / sizeof *bodies };

static const double lats[] = {-90, -89.999999, -60.25, -1e-9, 0, 1e-12, 33, 45, 72.5, 89.9999, 90};
static const double lons[] = {-180, -179.9999999, -90, 0, 1e-10, 12.34, 90, 179.5};
static const double heights[] = {-10000, -418, 0, 1e-3, 8848, 4e5, 2e7, 4e8};

#define FOR_ALL_POINTS                                                                             \
    for (size_t ib = 0; ib < BODIES; ib++)                                                         \
        for (size_t i = 0; i < sizeof lats / sizeof *lats; i++)                                    \
            for (size_t j = 0; j < sizeof lons / sizeof *lons; j++)                                \
                for (size_t k = 0; k < sizeof heights / sizeof *heights; k++)

// Largest difference seen: 1.9e-9 m + 1e-16 of the distance from the centre.
static void ecef_agrees(void **state)
{
    (void)state;
    FOR_ALL_POINTS
    {
        geo_ellipsoid e = bodies[ib];
        double want[3];
        geographic_forward(e.a, e.b, lats[i], lons[j], heights[k], want);
        dvec3 got = geo_ecef_from_geodetic(e, (geodetic){lats[i] * DEG, lons[j] * DEG, heights[k]});
        double tol = 4e-9 + 4e-16 * heights[k];
        check_near(got.x, want[0], tol);
        check_near(got.y, want[1], tol);
        check_near(got.z, want[2], tol);
    }
}

// As metres on the ground; the oracle's own error is some nanometres.
static void geodetic_agrees(void **state)
{
    (void)state;
    FOR_ALL_POINTS
    {
        geo_ellipsoid e = bodies[ib];
        double xyz[3], lat, lon, height;
        geographic_forward(e.a, e.b, lats[i], lons[j], heights[k], xyz);
        geographic_reverse(e.a, e.b, xyz, &lat, &lon, &height);
        geodetic got = geo_geodetic_from_ecef(e, (dvec3){xyz[0], xyz[1], xyz[2]});
        double ring = hypot(xyz[0], xyz[1]), tol = 1e-8 + 4e-16 * heights[k];
        check_near(got.lat, lat * DEG, tol / e.b);
        check_near(got.height, height, tol);
        check_near(remainder(got.lon - lon * DEG, 2 * M_PI) * ring, 0, tol);
        check_near(got.lon, 0, M_PI);
    }
}

// Deep points too, down to 200 km from the axis: nearer (43 km) the foot point is no longer unique.
static void geodetic_agrees_deep(void **state)
{
    (void)state;
    struct check_random random = {42};
    geo_ellipsoid e = bodies[0];
    for (int i = 0; i < 20000; i++) {
        double ring = exp(check_random_range(&random, log(2e5), log(1e9)));
        double z = check_random_range(&random, -1, 1) * exp(check_random_range(&random, 0, 20));
        double xyz[3] = {ring, 0, z}, lat, lon, height;
        geographic_reverse(e.a, e.b, xyz, &lat, &lon, &height);
        geodetic got = geo_geodetic_from_ecef(e, (dvec3){ring, 0, z});
        double distance = hypot(ring, z);
        check_near(got.lat, lat * DEG, 1e-12);
        check_near(got.height, height, 2e-8 + 1e-15 * distance);
    }
}

static void geodetic_edges(void **state)
{
    (void)state;
    geo_ellipsoid e = GEO_WGS84;
    assert_true(isnan(geo_geodetic_from_ecef(e, (dvec3){0, 0, 0}).lat));
    assert_true(isnan(geo_ecef_from_geodetic(e, (geodetic){1.6, 0, 0}).x));
    assert_true(isnan(geo_ecef_from_geodetic(e, (geodetic){NAN, 0, 0}).x));
    geodetic north = geo_geodetic_from_ecef(e, (dvec3){-0.0, -0.0, e.b + 7});
    check_near(north.lat, M_PI / 2, 0);
    check_near(north.lon, 0, 0);
    check_near(north.height, 7, 1e-9);
    geodetic south = geo_geodetic_from_ecef(e, (dvec3){0, 0, -e.b + 7});
    check_near(south.lat, -M_PI / 2, 0);
    check_near(south.height, -7, 1e-9);
}

static void round_trip(void **state)
{
    (void)state;
    struct check_random random = {7};
    for (int i = 0; i < 20000; i++) {
        geo_ellipsoid e = bodies[i % BODIES];
        geodetic p = {check_random_range(&random, -M_PI / 2, M_PI / 2),
                      check_random_range(&random, -M_PI, M_PI),
                      check_random_range(&random, -11000, 1e6)};
        dvec3 x = geo_ecef_from_geodetic(e, p);
        dvec3 y = geo_ecef_from_geodetic(e, geo_geodetic_from_ecef(e, x));
        check_near(dvec3_length(dvec3_sub(x, y)), 0, 6e-9);
    }
}

static void reduced_latitude(void **state)
{
    (void)state;
    geo_ellipsoid e = GEO_WGS84;
    for (int i = -90; i <= 90; i++) {
        double lat = i * DEG, b = geo_reduced_from_geodetic(e, lat);
        dvec3 p = geo_ecef_from_geodetic(e, (geodetic){lat, 0, 0});
        check_near(e.a * cos(b), p.x, 3e-9);
        check_near(e.b * sin(b), p.z, 3e-9);
        check_near(geo_geodetic_from_reduced(e, b), lat, 4e-16);
    }
    check_near(geo_reduced_from_geodetic(e, M_PI / 2), M_PI / 2, 0);
}

static void enu_is_a_rotation(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof lats / sizeof *lats; i++) {
        for (size_t j = 0; j < sizeof lons / sizeof *lons; j++) {
            double lat = lats[i] * DEG, lon = lons[j] * DEG;
            dmat3 enu = dmat3_transpose(geo_ecef_from_enu(lat, lon));
            dvec3 east = enu.row[0], north = enu.row[1], up = enu.row[2];
            dvec3 cross = dvec3_cross(east, north), normal = geo_normal(lat, lon);
            check_near(dvec3_length(dvec3_sub(cross, up)), 0, 4e-16);
            check_near(dvec3_length(dvec3_sub(normal, up)), 0, 0);
            check_near(east.z, 0, 0);
            check_near(dvec3_dot(east, (dvec3){-sin(lon), cos(lon), 0}), 1, 4e-16);
            assert_true(north.z >= 0);
        }
    }
}

static void wrap(void **state)
{
    (void)state;
    check_near(geo_wrap_lon(M_PI), -M_PI, 0);
    check_near(geo_wrap_lon(-M_PI), -M_PI, 0);
    check_near(geo_wrap_lon(3), 3, 0);
    check_near(geo_wrap_lon(7), 7 - 2 * M_PI, 1e-15);
    check_near(geo_wrap_lon(-1e6), remainder(-1e6, 2 * M_PI), 1e-9);
    double below = nextafter(M_PI, 0), above = nextafter(-M_PI, -4);
    assert_true(geo_wrap_lon(below) < M_PI && geo_wrap_lon(below) > 3);
    assert_true(geo_wrap_lon(above) < M_PI && geo_wrap_lon(above) >= -M_PI);
}

// A hit lies on the grown ellipsoid and nothing nearer does; a miss stays outside.
static void ray(void **state)
{
    (void)state;
    struct check_random random = {99};
    geo_ellipsoid e = GEO_WGS84;
    int hits = 0;
    for (int i = 0; i < 4000; i++) {
        double height = check_random_range(&random, -500, 9000);
        geodetic from = {check_random_range(&random, -1.5, 1.5), check_random_range(&random, -3, 3),
                         height + exp(check_random_range(&random, 0, 18))};
        dvec3 o = geo_ecef_from_geodetic(e, from);
        dvec3 d = dvec3_normalize((dvec3){check_random_range(&random, -1, 1),
                                          check_random_range(&random, -1, 1),
                                          check_random_range(&random, -1, 1)});
        double t = geo_ray_ellipsoid(e, height, o, d);
        double far = isnan(t) ? 4 * dvec3_length(o) : t;
        geo_ellipsoid grown = {.a = e.a + height, .b = e.b + height};
        for (int k = 1; k < 40; k++) {
            dvec3 p = dvec3_mad(o, d, far * k / 40);
            assert_true(hypot(hypot(p.x, p.y) / grown.a, p.z / grown.b) > 1);
        }
        if (isnan(t)) continue;
        hits++;
        dvec3 p = dvec3_mad(o, d, t);
        check_near(hypot(hypot(p.x, p.y) / grown.a, p.z / grown.b), 1, 1e-14);
    }
    assert_true(hits > 500 && hits < 3500);
}

static void ray_edges(void **state)
{
    (void)state;
    geo_ellipsoid e = GEO_WGS84;
    dvec3 down = {-1, 0, 0}, up = {1, 0, 0};
    check_near(geo_ray_ellipsoid(e, 0, (dvec3){e.a + 5, 0, 0}, down), 5, 1e-8);
    check_near(geo_ray_ellipsoid(e, 0, (dvec3){1e12, 0, 0}, down), 1e12 - e.a, 1e-3);
    assert_true(isnan(geo_ray_ellipsoid(e, 0, (dvec3){e.a + 5, 0, 0}, up)));
    check_near(geo_ray_ellipsoid(e, 0, (dvec3){0, 0, 0}, up), e.a, 1e-8);
    check_near(geo_ray_ellipsoid(e, 100, (dvec3){e.a, 0, 0}, up), 100, 1e-8);
    assert_true(isnan(geo_ray_ellipsoid(e, -7e6, (dvec3){e.a, 0, 0}, down)));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ecef_agrees),
        cmocka_unit_test(geodetic_agrees),
        cmocka_unit_test(geodetic_agrees_deep),
        cmocka_unit_test(geodetic_edges),
        cmocka_unit_test(round_trip),
        cmocka_unit_test(reduced_latitude),
        cmocka_unit_test(enu_is_a_rotation),
        cmocka_unit_test(wrap),
        cmocka_unit_test(ray),
        cmocka_unit_test(ray_edges),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
