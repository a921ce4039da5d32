// Single rays: against closed forms on spheres and ellipsoids, and against the oracle on terrain
// made of single samples: waves, a cone on the pole, a lone spike, noise; from 10 m to 10^9 m.
#include "check.h"

#include "ground.h"
#include "oracle.h"
#include "reference/ray.h"

_Static_assert(RAY_TOLERANCE <= 1e-4 && RAY_FLOOR_M <= 1e-6, "far below what is measured");

static const geo_ellipsoid sphere = {.a = 1e6, .b = 1e6},
                           wgs84 = {.a = 6378137.0, .b = 6356752.314245179},
                           lentil = {.a = 1e6, .b = 8e5};

static dvec3 random_direction(struct check_random *r)
{
    double z = check_random_range(r, -1, 1), lon = check_random_range(r, -M_PI, M_PI),
           c = sqrt(1 - z * z);
    return dvec3_make(c * cos(lon), c * sin(lon), z);
}

// A unit direction from `eye` towards a point that lies `miss` from the centre at closest approach.
static dvec3 aim(struct check_random *r, dvec3 eye, double miss)
{
    dvec3 down = dvec3_scale(eye, -1 / dvec3_length(eye));
    dvec3 side = dvec3_normalize(dvec3_cross(down, random_direction(r)));
    double s = miss / dvec3_length(eye);
    return dvec3_mad(dvec3_scale(down, sqrt(1 - s * s)), side, s);
}

static float level_100(int zoom, int64_t row, int64_t col)
{
    (void)zoom;
    (void)row;
    (void)col;
    return 100;
}

static float level_0(int zoom, int64_t row, int64_t col)
{
    (void)zoom;
    (void)row;
    (void)col;
    return 0;
}

// t of the first meeting with the ellipsoid, in long double; NaN: none.
static long double closed_form(long double a, long double b, dvec3 o, dvec3 d)
{
    long double ox = o.x / a, oy = o.y / a, oz = o.z / b, dx = d.x / a, dy = d.y / a, dz = d.z / b;
    long double dd = dx * dx + dy * dy + dz * dz, t = -(ox * dx + oy * dy + oz * dz) / dd;
    long double qx = ox + t * dx, qy = oy + t * dy, qz = oz + t * dz;
    long double half = 1 - (qx * qx + qy * qy + qz * qz);
    return half < 0 || t < 0 ? (long double)NAN : t - sqrtl(half / dd);
}

// Heights of the eye from 10 m to 10^9 m, rays through the disc and within 1 mm to 1 km of its
// edge. Error: metres along the ray, less the thousandth of its tolerance within which a root is
// left, times the sine at which it meets the ground.
static void check_level(geo_ellipsoid e, float h, ground_sample *sample)
{
    struct ground s;
    struct check_random r = {11};
    const double pixel = 1e-3;
    double worst = 0;
    int hits = 0, misses = 0;
    ground_open(&s, e, 1, sample);
    for (int i = 0; i < 40; i++) {
        double above = pow(10, check_random_range(&r, 1, 9)), ground = e.a + h;
        dvec3 eye = dvec3_scale(random_direction(&r), ground + above);
        ground_look_from(&s, (double[]){eye.x, eye.y, eye.z}, 1);
        for (int j = 0; j < 200; j++) {
            bool edge = j % 2;
            double off = pow(10, check_random_range(&r, -3, 3)) * (j % 4 == 1 ? 1 : -1);
            double miss = edge ? ground + off : ground * sqrt(check_random_range(&r, 0, 1));
            if (miss >= dvec3_length(eye)) continue;
            dvec3 dir = aim(&r, eye, miss);
            long double want = closed_form((long double)e.a + h, (long double)e.b + h, eye, dir);
            ray_hit hit;
            bool got = ray_cast(&s.reader, eye, dir, pixel, &hit);
            assert_int_equal(got, !isnan(want));
            hits += got;
            misses += !got;
            if (!got) continue;
            dvec3 at = dvec3_mad(eye, dir, hit.t);
            dvec3 n = dvec3_normalize(
                dvec3_make(at.x / (e.a * e.a), at.y / (e.a * e.a), at.z / (e.b * e.b)));
            double error =
                fmax(0, fabs((double)(hit.t - want)) - 1e-3 * RAY_TOLERANCE * pixel * hit.t);
            worst = fmax(worst, error * fabs(dvec3_dot(n, dir)));
        }
    }
    print_message("a %.0f b %.0f h %g: %d hits, %d misses, worst %.2e m\n", e.a, e.b, (double)h,
                  hits, misses, worst);
    assert_true(hits > 1000 && misses > 500);
    assert_true(worst <= 2e-6);
    ground_close(&s);
}

static void test_closed_forms(void **state)
{
    (void)state;
    check_level(sphere, 100, level_100);
    check_level(wgs84, 0, level_0);
    check_level(lentil, 0, level_0);
}

// Samples on the sphere of radius 10^6 at zoom 1 lie 6.1 km apart.
static float waves(int zoom, int64_t row, int64_t col)
{
    double lat, lon;
    ground_place(zoom, row, col, &lat, &lon);
    return (float)(3000 * sin(9 * lat) * cos(6 * lon) * cos(lat));
}

static float cone(int zoom, int64_t row, int64_t col)
{
    double lat, lon;
    ground_place(zoom, row, col, &lat, &lon);
    return (float)fmax(0, 20000 - 0.2 * 1e6 * (M_PI / 2 - lat));
}

static float noise(int zoom, int64_t row, int64_t col)
{
    struct check_random r = {(uint64_t)(row * 7919 + col * 104729 + zoom + 1)};
    check_random_u64(&r);
    check_random_u64(&r);
    double lat, lon;
    ground_place(zoom, row, col, &lat, &lon);
    return (float)(check_random_range(&r, -1000, 1000) * cos(lat));
}

// Where one sample stands out: somewhere; at both ends of the map; far north and south, where a
// level ray comes nearer to the pole between its ends by more than a sample, at the edge of a block
// of samples; beside a pole, from where rays cross the antimeridian far from the sample. With
// towers far away in the same tiles rays are looked at over a long way.
static const struct {
    int64_t row, col;
    int from_km; // of the eye, with towers
} spikes[] = {{200, 255, 60}, {200, 0, 60},  {200, 1023, 60}, {63, 255, 60},
              {448, 255, 60}, {20, 255, 20}, {491, 255, 20}};
static int spike_now;
static bool towers;

static float spike(int zoom, int64_t row, int64_t col)
{
    if (zoom != 1) return 0;
    if (towers && col == 128 && (row == 150 || row == 361)) return 46000;
    return row == spikes[spike_now].row && col == spikes[spike_now].col ? 5000 : 0;
}

// Low eyes and high ones, many rays near the horizon; every hit and every miss as the oracle has
// it, unless the oracle itself came within 10 um of the ground. Error as above, without the sine
// (slopes and grazing make it worse, so the tolerance is the ray's own: 10^-4 of a pixel).
static void check_terrain(const char *name, bool bicubic, geo_ellipsoid e, ground_sample *sample,
                          double slope, double top, int eyes)
{
    struct ground s;
    struct check_random r = {5};
    oracle o = {e.a, e.b, 1, sample, slope, top, bicubic, false};
    double worst = 0;
    int hits = 0, misses = 0, unsure = 0;
    const double pixel = 1e-3;
    ground_open(&s, e, 1, sample);
    s.bicubic = bicubic;
    for (int i = 0; i < eyes; i++) {
        dvec3 up = i % 4 == 0 ? dvec3_make(1e-4 * i, 0, i % 8 ? 1 : -1) : random_direction(&r);
        up = dvec3_normalize(up);
        double above = pow(10, check_random_range(&r, 1, i % 2 ? 4 : 7));
        dvec3 near = dvec3_scale(up, 1 + (top + above) / e.b); // the ellipsoid as the unit sphere
        dvec3 eye = {near.x * e.a, near.y * e.a, near.z * e.b};
        ground_look_from(&s, (double[]){eye.x, eye.y, eye.z}, 1);
        for (int j = 0; j < 20; j++) {
            dvec3 to = dvec3_normalize(dvec3_cross(up, random_direction(&r)));
            double dip = acos(1 / dvec3_length(near)) + check_random_range(&r, -0.01, 0.05);
            dvec3 dir = j % 3 ? dvec3_mad(dvec3_scale(to, cos(dip)), up, -sin(dip))
                              : aim(&r, near, check_random_range(&r, 0, 1));
            dir = dvec3_normalize(dvec3_make(dir.x * e.a, dir.y * e.a, dir.z * e.b));
            long double least, want = oracle_trace(&o, (double[]){eye.x, eye.y, eye.z},
                                                   (double[]){dir.x, dir.y, dir.z}, &least);
            ray_hit hit;
            bool got = ray_cast(&s.reader, eye, dir, pixel, &hit);
            bool same = got == !isnan(want) &&
                        (!got || fabs((double)(hit.t - want)) <= RAY_TOLERANCE * pixel * hit.t);
            if (!same && least < 1e-5L) {
                unsure++;
                continue;
            }
            if (!same)
                print_error("%s: eye %d ray %d: got %.9g, want %.9Lg, least %Lg\n", name, i, j,
                            got ? hit.t : NAN, want, least);
            assert_true(same);
            hits += got;
            misses += !got;
            if (got) worst = fmax(worst, fabs((double)(hit.t - want)) / (pixel * hit.t));
        }
    }
    print_message("%s: %d hits, %d misses, %d too close to tell, worst %.2e px along the ray\n",
                  name, hits, misses, unsure, worst);
    assert_true(hits > 4 * eyes && misses > eyes / 2);
    assert_true(unsure <= eyes / 10);
    ground_close(&s);
}

static void test_waves(void **state)
{
    (void)state;
    check_terrain("waves", false, sphere, waves, 0.06, 3000, 32);
    check_terrain("waves on a lentil", false, lentil, waves, 0.1, 3000, 16);
    check_terrain("waves, bicubic", true, sphere, waves, 0.08, 3100, 16);
    check_terrain("waves on a lentil, bicubic", true, lentil, waves, 0.13, 3100, 16);
}

static void test_cone_on_the_pole(void **state)
{
    (void)state;
    check_terrain("cone", false, sphere, cone, 0.3, 20000, 32);
    check_terrain("cone, bicubic", true, sphere, cone, 0.57, 25625, 16);
}

static void test_noise(void **state)
{
    (void)state;
    check_terrain("noise", false, sphere, noise, 1.5, 1000, 16);
    check_terrain("noise, bicubic", true, sphere, noise, 2.9, 1562.5, 16);
}

// Level rays past the one sample that stands out, from every side, a little below its top and a
// little above it; two of them along the meridian, where patches meet, which takes no longer (with
// towers it did not end).
static void check_spike(void)
{
    struct ground s;
    double lat, lon, pixel = towers ? 1e-6 : 1e-3;
    ground_open(&s, sphere, 1, spike);
    ground_place(1, spikes[spike_now].row, spikes[spike_now].col, &lat, &lon);
    dvec3 up = {cos(lat) * cos(lon), cos(lat) * sin(lon), sin(lat)};
    dvec3 east = {-sin(lon), cos(lon), 0}, north = dvec3_cross(up, east);
    for (int i = 0; i < 64; i++) {
        double turn = 2 * M_PI * i / 64;
        double distance =
            1000.0 * (towers ? spikes[spike_now].from_km + 2 * (i * 29 % 64) : 20 + 13 * i);
        dvec3 dir = dvec3_mad(dvec3_scale(north, cos(turn)), east, sin(turn));
        for (int above = 0; above < 2; above++) {
            dvec3 top = dvec3_scale(up, sphere.a + 5000 + (above ? 1e-3 : -1e-3));
            dvec3 eye = dvec3_mad(top, dir, -distance);
            ground_look_from(&s, (double[]){eye.x, eye.y, eye.z}, 1);
            ray_hit hit;
            bool got = ray_cast(&s.reader, eye, dir, pixel, &hit);
            assert_int_equal(got, !above);
            if (got) check_near(hit.t, distance, 0.01);
        }
    }
    ground_close(&s);
}

static void test_no_peak_is_missed(void **state)
{
    (void)state;
    for (int i = 0; i < 2 * (int)(sizeof spikes / sizeof spikes[0]); i++) {
        spike_now = i / 2;
        towers = i % 2;
        check_spike();
    }
}

// A bicubic surface rises above its samples: in the middle of a cell of this pattern by the most it
// can, 9/16 of 1000 m (patch.h). Level rays over it, a little below and a little above.
static float crests(int zoom, int64_t row, int64_t col)
{
    (void)zoom;
    bool inner = (row % 4 == 1 || row % 4 == 2) == (col % 4 == 1 || col % 4 == 2);
    return inner ? 1000 : -1000;
}

enum { CREST_ROW = 201, CREST_COL = 253 };

static void test_no_crest_is_missed(void **state)
{
    (void)state;
    struct ground s;
    double lat[2], lon[2];
    ground_open(&s, sphere, 1, crests);
    s.bicubic = true;
    ground_place(1, CREST_ROW, CREST_COL, &lat[0], &lon[0]);
    ground_place(1, CREST_ROW + 1, CREST_COL + 1, &lat[1], &lon[1]);
    double phi = 0.5 * (lat[0] + lat[1]), lambda = 0.5 * (lon[0] + lon[1]);
    dvec3 up = {cos(phi) * cos(lambda), cos(phi) * sin(lambda), sin(phi)};
    dvec3 east = {-sin(lambda), cos(lambda), 0}, north = dvec3_cross(up, east);
    for (int i = 0; i < 64; i++) {
        double turn = 2 * M_PI * i / 64, distance = 1000.0 * (20 + 13 * i);
        dvec3 dir = dvec3_mad(dvec3_scale(north, cos(turn)), east, sin(turn));
        for (int above = 0; above < 2; above++) {
            dvec3 top = dvec3_scale(up, sphere.a + 1562.5 + (above ? 1e-3 : -1e-3));
            dvec3 eye = dvec3_mad(top, dir, -distance);
            ground_look_from(&s, (double[]){eye.x, eye.y, eye.z}, 1);
            ray_hit hit;
            bool got = ray_cast(&s.reader, eye, dir, 1e-3, &hit);
            assert_int_equal(got, !above);
            if (got) check_near(hit.t, distance, 20);
        }
    }
    ground_close(&s);
}

static void test_inside(void **state)
{
    (void)state;
    struct ground s;
    ground_open(&s, sphere, 1, level_100);
    struct check_random r = {3};
    for (int i = 0; i < 20; i++) {
        dvec3 up = random_direction(&r), dir = random_direction(&r);
        dvec3 eye = dvec3_scale(up, sphere.a + (i % 2 ? 99.999 : -5000));
        ground_look_from(&s, (double[]){eye.x, eye.y, eye.z}, 1);
        ray_hit hit;
        assert_true(ray_cast(&s.reader, eye, dir, 1e-3, &hit));
        check_near(hit.t, 0, 0);
        check_near(hit.height, 100, 1e-9);
    }
    ground_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_closed_forms),
        cmocka_unit_test(test_waves),
        cmocka_unit_test(test_cone_on_the_pole),
        cmocka_unit_test(test_noise),
        cmocka_unit_test(test_no_peak_is_missed),
        cmocka_unit_test(test_no_crest_is_missed),
        cmocka_unit_test(test_inside),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
