// The shared functions against the plain formulas in long double: in double for their truth, in
// float for their bounds. Every value of the truth is made from ring number, column and colatitude,
// not from the rounded attributes, so the bounds hold with their rounding.
#include "check.h"

#include "geo/ring_truth.h"
#include "geo/shared.h"
#include "geo/test_shared_cases.h"

struct truth {
    struct ring_truth ring;
    exact p[3]; // from the camera, tangent frame, m
};

static struct truth_focus focus_of(const struct shared_case *c)
{
    return (struct truth_focus){c->ellipsoid, c->colatitude, c->hemisphere};
}

static struct truth truth_of(const struct shared_case *c)
{
    struct truth_focus f = focus_of(c);
    struct truth t = {.ring = ring_truth_ideal(&f, &shared_case_rings, c->ring, c->column)};
    exact focus[3], camera[3], p[3];
    ring_truth_focus(&f, focus);
    ring_truth_point(c->ellipsoid, t.ring.u, c->h, p);
    ring_truth_point(c->ellipsoid, focus, c->href, camera);
    for (int i = 0; i < 3; i++) p[i] -= camera[i];
    ring_truth_tangent(&f, p, t.p);
    return t;
}

static exact lon_texel(const struct shared_case *c)
{
    struct truth_focus f = focus_of(c);
    return ring_truth_lon_texel(&f, c->level);
}

static void arc_tangent(void **state)
{
    (void)state;
    double worst_float = 0, worst_double = 0;
    struct check_random random = {3};
    for (int i = 0; i < 2000000; i++) {
        float y = (float)check_random_range(&random, -1, 1);
        float x = (float)check_random_range(&random, -1, 1);
        if (i % 4 == 1) y = ldexpf(y, -(int)(check_random_u64(&random) % 60));
        if (i % 4 == 2) x = ldexpf(x, -(int)(check_random_u64(&random) % 60));
        if (i % 4 == 3) y = x * (1 + 1e-3f * y);
        double want = atan2(y, x);
        if (want == 0) continue;
        worst_float = fmax(worst_float, fabs(atan_ratio_f(y, x) / want - 1));
        worst_double = fmax(worst_double, fabs(atan_ratio_d(y, x) / want - 1));
    }
    print_message("atan_ratio: relative error %.3g in float, %.3g in double\n", worst_float,
                  worst_double);
    assert_true(worst_float <= 1.6e-7);
    assert_true(worst_double <= 1.7e-8);
}

static void arc_tangent_edges(void **state)
{
    (void)state;
    check_near(atan_ratio_f(0, 0), 0, 0);
    check_near(atan_ratio_f(-0.0f, 0), 0, 0);
    check_near(atan_ratio_f(0, 1), 0, 0);
    check_near(atan_ratio_f(1e-30f, -0.5f), M_PI, 1e-7);
    check_near(atan_ratio_f(-1e-30f, -0.5f), -M_PI, 1e-7);
    check_near(atan_ratio_d(1e-30, -0.5), M_PI, 1e-15);
    check_near(atan_ratio_d(-1e-30, -0.5), -M_PI, 1e-15);
    check_near(atan_ratio_f(1e-30f, 0), M_PI / 2, 1e-7);
    check_near(atan_ratio_f(0, -1), M_PI, 1e-7);
    check_near(atan_ratio_f(1e-30f, 0.5f) / 2e-30, 1, 1e-7);
}

// In double only the polynomial's 1.7e-8 is left.
static void stable_is_true(void **state)
{
    (void)state;
    for (int i = 0; i < SHARED_CASES; i += 3) {
        struct shared_case c = shared_case_at(i);
        struct truth t = truth_of(&c);
        struct geo_focus f = geo_focus_make(
            c.ellipsoid,
            geo_geodetic_from_reduced(c.ellipsoid, c.hemisphere * (M_PI / 2 - c.colatitude)), 0,
            (dvec3){0, 0, 0}, 0);
        int half = shared_case_rings.azimuth_steps / 2;
        double d[2], angle = ring_angle(&shared_case_rings, c.ring), dlon, dlat;
        ring_direction(&shared_case_rings, c.column, d);
        double e = sin(angle) * d[1], v = 2 * sin(angle / 2) * sin(angle / 2);
        if (e == 0) e = c.column > half ? -1e-30 : 1e-30;
        map_transform_stable_d(sin(angle) * d[0], e, v, f.cb, f.sb, f.r, &dlon, &dlat);
        check_near(dlat, (double)t.ring.dlat,
                   2e-8 * fabs((double)t.ring.dlat) + 1e-15 * angle + 3e-19);
        if (!ring_truth_has_longitude(&t.ring, c.level)) continue;
        check_near(dlon, (double)t.ring.dlon,
                   2e-8 * fabs((double)t.ring.dlon) + 1e-15 / (double)t.ring.rho);
    }
}

// Texels of error by colatitude: the table of the contract.
static void stable_bounds(void **state)
{
    (void)state;
    exact lon[SHARED_COLATITUDES] = {0}, lat[SHARED_COLATITUDES] = {0},
          arc[SHARED_COLATITUDES] = {0};
    for (int i = 0; i < SHARED_CASES; i++) {
        struct shared_case c = shared_case_at(i);
        struct truth t = truth_of(&c);
        int k = i / (SHARED_CASES / SHARED_COLATITUDES);
        float dlon, dlat;
        map_transform_stable_f(c.n, c.e, c.v, c.cb, c.sb, c.r, &dlon, &dlat);
        exact error = fabsl(dlon - t.ring.dlon);
        lat[k] = fmaxl(lat[k], fabsl(dlat - t.ring.dlat) / ring_truth_lat_texel(c.level));
        if (!ring_truth_has_longitude(&t.ring, c.level)) continue;
        lon[k] = fmaxl(lon[k], error / lon_texel(&c));
        arc[k] = fmaxl(arc[k], error * t.ring.rho / ring_truth_lat_texel(c.level));
    }
    for (int k = 0; k < SHARED_COLATITUDES; k++) {
        struct shared_case c = shared_case_at(k * (SHARED_CASES / SHARED_COLATITUDES));
        print_message("colatitude %-9.3g: lon %.2g, lon on the ground %.2g, lat %.2g texel\n",
                      c.colatitude, (double)lon[k], (double)arc[k], (double)lat[k]);
        assert_true(lon[k] <= 1e-3L);
        assert_true(arc[k] <= 1e-3L);
        assert_true(lat[k] <= 1e-3L);
    }
}

// The paper's exact path is exact, but for rounding.
static void exact_is_true(void **state)
{
    (void)state;
    for (int i = 0; i < SHARED_CASES; i += 7) {
        struct shared_case c = shared_case_at(i);
        if (c.level > 8 || c.colatitude < 0.01) continue;
        struct truth t = truth_of(&c);
        geo_ellipsoid el = c.ellipsoid;
        double b = c.hemisphere * (M_PI / 2 - c.colatitude), d[2], dlon, dlat;
        double angle = ring_angle(&shared_case_rings, c.ring);
        ring_direction(&shared_case_rings, c.column, d);
        double e = c.e == RING_SEAM || c.e == -RING_SEAM ? c.e : sin(angle) * d[1];
        map_transform_exact_d(sin(angle) * d[0], e, 2 * sin(angle / 2) * sin(angle / 2), cos(b),
                              sin(b), el.a / el.b, geo_geodetic_from_reduced(el, b), &dlon, &dlat);
        double rho = (double)t.ring.rho; // acos loses half the digits at a pole
        check_near(dlat, (double)t.ring.dlat, 2e-15 + fmin(1e-15 / fmax(rho, 1e-20), 1e-7));
        if (ring_truth_has_longitude(&t.ring, c.level))
            check_near(dlon, (double)t.ring.dlon, 2e-15 + 1e-15 / rho);
    }
}

// Eq. 11 against 1/sin: the design's own measurement of the fit (1.5e-4 at pi/4, 3.0e-4 at
// pi/16, 1.7e-4 at pi/48).
static void stretch_fits(void **state)
{
    (void)state;
    static const double table[][2] = {
        {M_PI / 2, 0}, {M_PI / 4, 1.5e-4}, {M_PI / 16, 3.0e-4}, {M_PI / 48, 1.7e-4}};
    geo_ellipsoid sphere = {.a = 1, .b = 1};
    for (int i = 0; i < 4; i++) {
        struct geo_focus f = geo_focus_make(sphere, M_PI / 2 - table[i][0], 0, (dvec3){0, 0, 0}, 0);
        check_near(fabs(f.stretch * sin(table[i][0]) - 1), table[i][1], 0.05e-4);
    }
    struct geo_focus pole = geo_focus_make(sphere, M_PI / 2, 0, (dvec3){0, 0, 0}, 0);
    assert_true(isfinite((float)pole.stretch));
}

static void paper_forms(void **state)
{
    (void)state;
    for (int i = 0; i < SHARED_CASES; i += 11) {
        struct shared_case c = shared_case_at(i);
        double lon_a, lat_a, lon_e, lat_e, lon, lat;
        map_transform_approx_d(c.n, c.e, c.v, c.stretch, c.dlat_db, &lon_a, &lat_a);
        check_near(lon_a, (double)c.e * c.stretch, 0);
        check_near(lat_a, (double)c.n * c.dlat_db, 0);
        map_transform_exact_d(c.n, c.e, c.v, c.cb, c.sb, c.r, c.lat, &lon_e, &lat_e);
        map_transform_blend_d(c.n, c.e, c.v, c.cb, c.sb, c.r, c.lat, c.stretch, c.dlat_db, c.w,
                              &lon, &lat);
        check_near(lon, lon_e + c.w * (lon_a - lon_e), 1e-15 * fabs(lon_a) + 1e-15);
        check_near(lat, lat_e + c.w * (lat_a - lat_e), 1e-15);
    }
}

// dlat_db by its definition, a difference quotient.
static void latitude_derivative(void **state)
{
    (void)state;
    geo_ellipsoid e = GEO_WGS84;
    for (int i = -89; i <= 89; i += 2) {
        double lat = i * M_PI / 180;
        struct geo_focus f = geo_focus_make(e, lat, 1, (dvec3){0, 0, 0}, 0);
        double h = 1e-5;
        double slope = (geo_geodetic_from_reduced(e, f.reduced + h) -
                        geo_geodetic_from_reduced(e, f.reduced - h)) /
                       (2 * h);
        check_near(f.dlat_db, slope, 1e-10);
    }
}

static double position_error(const struct shared_case *c, const struct truth *t, double *distance)
{
    float up, east, north;
    relative_position_f(c->place, c->n, c->e, c->v, c->h, &up, &east, &north);
    *distance = (double)hypotl(hypotl(t->p[0], t->p[1]), t->p[2]);
    return (double)hypotl(hypotl(up - t->p[0], east - t->p[1]), north - t->p[2]);
}

// Attributes and result are floats: half an ulp each is almost 1 mm at 10 km.
static void position_bounds(void **state)
{
    (void)state;
    double within_10_km = 0, relative = 0;
    for (int i = 0; i < SHARED_CASES; i++) {
        struct shared_case c = shared_case_at(i);
        struct truth t = truth_of(&c);
        double distance, error = position_error(&c, &t, &distance);
        relative = fmax(relative, error / distance);
        if (distance <= 1e4) within_10_km = fmax(within_10_km, error);
    }
    print_message("position: %.2g m within 10 km, %.2g of the distance anywhere\n", within_10_km,
                  relative);
    assert_true(within_10_km <= 1e-3);
    assert_true(relative <= 1.8e-7);
}

// A vector of the tangent frame.
static dvec3 in_ecef(const struct geo_focus *f, dvec3 v)
{
    v = dmat3_mul(dmat3_transpose(f->tangent_from_meridian), v);
    return dmat3_mul(dmat3_transpose(f->meridian_from_ecef), v);
}

// With a camera anywhere, not over the focus, in double: the whole chain from geo_focus_make.
static void position_from_anywhere(void **state)
{
    (void)state;
    struct check_random random = {17};
    geo_ellipsoid e = GEO_WGS84;
    for (int i = 0; i < 2000; i++) {
        struct shared_case c = shared_case_at((int)(check_random_u64(&random) % SHARED_CASES));
        struct truth t = truth_of(&c);
        double lat = geo_geodetic_from_reduced(e, c.hemisphere * (M_PI / 2 - c.colatitude));
        double lon = check_random_range(&random, -4, 4);
        geodetic at = {check_random_range(&random, -1.5, 1.5), lon + 0.2, 5000};
        dvec3 camera = geo_ecef_from_geodetic(e, at);
        struct geo_focus f = geo_focus_make(e, lat, lon, camera, c.href);
        double d[2], angle = ring_angle(&shared_case_rings, c.ring), half = sin(angle / 2);
        ring_direction(&shared_case_rings, c.column, d);
        dvec3 p;
        relative_position_d(geo_place_frame(&f), sin(angle) * d[0], sin(angle) * d[1],
                            2 * half * half, c.h, &p.x, &p.y, &p.z);
        dvec3 over = geo_ecef_from_geodetic(e, (geodetic){lat, lon, c.href});
        dvec3 got = dvec3_add(in_ecef(&f, p), camera);
        dvec3 want =
            dvec3_add(in_ecef(&f, (dvec3){(double)t.p[0], (double)t.p[1], (double)t.p[2]}), over);
        check_near(dvec3_length(dvec3_sub(got, want)), 0, 2e-8);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arc_tangent),     cmocka_unit_test(arc_tangent_edges),
        cmocka_unit_test(stable_is_true),  cmocka_unit_test(stable_bounds),
        cmocka_unit_test(exact_is_true),   cmocka_unit_test(stretch_fits),
        cmocka_unit_test(paper_forms),     cmocka_unit_test(latitude_derivative),
        cmocka_unit_test(position_bounds), cmocka_unit_test(position_from_anywhere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
