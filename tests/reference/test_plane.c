// Rays over a map as a plane: against closed forms over level ground, a slope and a roof, and
// against the oracle over waves, a cone and noise; the map's edges; an eye beside the map.
//
// Fails when broken: longitudes off by 1e-7; a map half as wide (holes); the second derivative's
// bound of 0 or a plane's heights found by the ellipsoid's (terrain); a ray from beside the map not
// asked whether it enters below the ground; a tile's ball without its longitude, or looked for in
// the wrong turn (frames).
#include "check.h"

#include "ground.h"
#include "oracle.h"
#include "reference/body.h"
#include "reference/reference.h"

// Samples of zoom 1 lie 6.1 km apart.
#define SCALE 1e6
#define STEP  (M_PI / 512)

enum { ROWS = 512 };

static geo_ellipsoid plane(void)
{
    return geo_plane_of((geo_ellipsoid){.a = SCALE, .b = SCALE});
}

static float level(int zoom, int64_t row, int64_t col)
{
    (void)zoom;
    (void)row;
    (void)col;
    return 128;
}

// Rises by 1024 m a row to the north: by a sixth.
static float slope(int zoom, int64_t row, int64_t col)
{
    (void)zoom;
    (void)col;
    return (float)(1024 * (ROWS - 1 - row));
}

// Falls to both sides from row 255 on; 2048 m a row.
static float roof(int zoom, int64_t row, int64_t col)
{
    (void)zoom;
    (void)col;
    return (float)(-2048 * llabs(row - 255));
}

// The first t at which the ray meets x = height + rise z within [south, north] of the map, NaN:
// none.
static double meets(dvec3 o, dvec3 d, double height, double rise, double south, double north)
{
    double t = (height + rise * o.z - o.x) / (d.x - rise * d.z), z = o.z + t * d.z,
           y = o.y + t * d.y;
    bool there = t >= 0 && d.x < rise * d.z && z >= south && z <= north && fabs(y) <= SCALE * M_PI;
    return there ? t : NAN;
}

struct shape {
    ground_sample *sample;
    // x = height + rise z to the north of `crease`, and another to the south.
    double crease, height[2], rise[2];
};

static double closed_form(const struct shape *s, dvec3 o, dvec3 d)
{
    double edge = SCALE * M_PI / 2;
    double north = meets(o, d, s->height[0], s->rise[0], s->crease, edge),
           south = meets(o, d, s->height[1], s->rise[1], -edge, s->crease);
    return isnan(north) ? south : isnan(south) ? north : fmin(north, south);
}

// A ray towards a place of the map, some beyond its edges.
static dvec3 towards(struct check_random *r, dvec3 eye)
{
    dvec3 at = {0, SCALE * check_random_range(r, -3.6, 3.6), SCALE * check_random_range(r, -2, 2)};
    return dvec3_normalize(dvec3_sub(at, eye));
}

static double ground_under(const struct shape *s, double z)
{
    int k = z < s->crease;
    return s->height[k] + s->rise[k] * z;
}

// Two samples from the edges and from a roof's ridge the samples' ground is the closed form's.
static bool at_a_bend(const struct shape *s, dvec3 p)
{
    double room = 2 * STEP * SCALE, edge = SCALE * M_PI / 2;
    return fabs(p.z) > edge - room || fabs(p.z - s->crease) < room ||
           fabs(p.y) > SCALE * M_PI - room;
}

static void check_shape(const char *name, const struct shape *shape)
{
    struct ground s;
    struct check_random r = {3};
    const double pixel = 1e-3;
    double worst = 0;
    int hits = 0, misses = 0;
    ground_open(&s, plane(), 1, shape->sample);
    for (int i = 0; i < 40; i++) {
        dvec3 eye = {0, SCALE * check_random_range(&r, -3, 3),
                     SCALE * check_random_range(&r, -1.5, 1.5)};
        eye.x = ground_under(shape, eye.z) + pow(10, check_random_range(&r, 1, 7));
        ground_look_from(&s, (double[]){eye.x, eye.y, eye.z}, 1);
        for (int j = 0; j < 200; j++) {
            dvec3 dir = towards(&r, eye);
            double want = closed_form(shape, eye, dir);
            ray_hit hit;
            bool got = ray_cast(&s.reader, eye, dir, pixel, &hit);
            if (at_a_bend(shape, dvec3_mad(eye, dir, isnan(want) ? 0 : want)) ||
                (got && at_a_bend(shape, dvec3_mad(eye, dir, hit.t))))
                continue;
            if (got != !isnan(want))
                fail_msg("%s: eye %g %g %g, direction %g %g %g: got %g, want %g", name, eye.x,
                         eye.y, eye.z, dir.x, dir.y, dir.z, got ? hit.t : NAN, want);
            hits += got;
            misses += !got;
            if (!got) continue;
            worst = fmax(worst, fabs(hit.t - want) / (pixel * hit.t));
            check_near(hit.lat * (M_PI / 180) * SCALE, eye.z + hit.t * dir.z, 1e-5);
            check_near(hit.lon * (M_PI / 180) * SCALE, eye.y + hit.t * dir.y, 1e-5);
        }
    }
    print_message("%s: %d hits, %d misses, worst %.2e px along the ray\n", name, hits, misses,
                  worst);
    assert_true(hits > 3000 && misses > 1000);
    assert_true(worst <= RAY_TOLERANCE);
    ground_close(&s);
}

static void test_closed_forms(void **state)
{
    (void)state;
    double row = STEP * SCALE;
    const struct shape shapes[] = {
        {level, 0, {128, 128}, {0, 0}},
        // Row k lies at z = (255.5 - k) rows.
        {slope, 0, {1024 * 255.5, 1024 * 255.5}, {1024 / row, 1024 / row}},
        {roof, 0.5 * row, {2048 * 0.5, -2048 * 0.5}, {-2048 / row, 2048 / row}}};
    check_shape("level", &shapes[0]);
    check_shape("slope", &shapes[1]);
    check_shape("roof", &shapes[2]);
}

static float waves(int zoom, int64_t row, int64_t col)
{
    double lat, lon;
    ground_place(zoom, row, col, &lat, &lon);
    return (float)(3000 * sin(9 * lat) * cos(6 * lon));
}

static float cone(int zoom, int64_t row, int64_t col)
{
    double lat, lon;
    ground_place(zoom, row, col, &lat, &lon);
    return (float)fmax(0, 20000 - 0.2 * SCALE * hypot(lat - 0.3, lon + 1));
}

static float noise(int zoom, int64_t row, int64_t col)
{
    struct check_random r = {(uint64_t)(row * 7919 + col * 104729 + zoom + 1)};
    check_random_u64(&r);
    check_random_u64(&r);
    return (float)check_random_range(&r, -1000, 1000);
}

// Low eyes and high ones, level rays and steep ones, on the map and at its edges.
static void check_terrain(const char *name, bool bicubic, ground_sample *sample, double steep,
                          double top)
{
    struct ground s;
    struct check_random r = {5};
    oracle o = {SCALE, SCALE, 1, sample, steep, top, bicubic, true};
    double worst = 0;
    int hits = 0, misses = 0, unsure = 0, eyes = 16;
    const double pixel = 1e-3;
    ground_open(&s, plane(), 1, sample);
    s.bicubic = bicubic;
    for (int i = 0; i < eyes; i++) {
        double edge = i % 3 ? 1 : 0.999;
        dvec3 eye = {top + pow(10, check_random_range(&r, 1, i % 2 ? 4 : 6.5)),
                     SCALE *
                         (i % 3 ? check_random_range(&r, -3, 3) : (i % 2 ? 1 : -1) * M_PI * edge),
                     SCALE * check_random_range(&r, -1, 1)};
        ground_look_from(&s, (double[]){eye.x, eye.y, eye.z}, 1);
        for (int j = 0; j < 20; j++) {
            double turn = check_random_range(&r, 0, 2 * M_PI),
                   dip =
                       j % 2 ? check_random_range(&r, -0.01, 0.1) : check_random_range(&r, 0, 1.5);
            dvec3 dir = {-sin(dip), cos(dip) * cos(turn), cos(dip) * sin(turn)};
            long double least, want = oracle_trace(&o, (double[]){eye.x, eye.y, eye.z},
                                                   (double[]){dir.x, dir.y, dir.z}, &least);
            ray_hit hit;
            bool got = ray_cast(&s.reader, eye, dir, pixel, &hit);
            // The oracle's rows beyond a pole go on on the other side of the map.
            if (got && fabs(hit.lat) > 89) continue;
            bool same = got == !isnan(want) &&
                        (!got || fabs((double)(hit.t - want)) <= RAY_TOLERANCE * pixel * hit.t);
            if (!same && least < 1e-5L) {
                unsure++;
                continue;
            }
            if (!same)
                fail_msg("%s: eye %d ray %d: got %.9g, want %.9Lg, least %Lg", name, i, j,
                         got ? hit.t : NAN, want, least);
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

static void test_terrain(void **state)
{
    (void)state;
    check_terrain("waves", false, waves, 0.06, 3000);
    check_terrain("waves, bicubic", true, waves, 0.08, 3100);
    check_terrain("cone", false, cone, 0.3, 20000);
    check_terrain("noise", false, noise, 1.5, 1000);
    check_terrain("noise, bicubic", true, noise, 2.9, 1562.5);
}

// From beside the map its ground is seen from above over the edge; nothing from below.
static void test_eye_beside_the_map(void **state)
{
    (void)state;
    struct ground s;
    ground_open(&s, plane(), 1, level);
    dvec3 above = {50128, SCALE * (M_PI + 0.1), 0}, beneath = {28, SCALE * (M_PI + 0.1), 0};
    const dvec3 dirs[] = {{-0.6, -1, 0}, {-0.1, -1, 0}, {0, -1, 0}, {0.0001, -1, 0}};
    ray_hit hit;
    ground_look_from(&s, (double[]){above.x, above.y, above.z}, 1);
    dvec3 near = dvec3_normalize(dirs[0]), far = dvec3_normalize(dirs[1]);
    assert_false(ray_cast(&s.reader, above, near, 1e-3, &hit)); // passes under the edge
    assert_true(ray_cast(&s.reader, above, far, 1e-3, &hit));
    check_near(hit.t, 50000 / -far.x, 1e-4);
    assert_false(ray_cast(&s.reader, above, dirs[2], 1e-3, &hit));
    ground_look_from(&s, (double[]){beneath.x, beneath.y, beneath.z}, 1);
    for (int i = 2; i < 4; i++)
        assert_false(ray_cast(&s.reader, beneath, dvec3_normalize(dirs[i]), 1e-3, &hit));
    ground_close(&s);
}

// Whole pictures, which read only the tiles in sight: every pixel as the oracle has it.
static void check_frame(struct ground *s, const oracle *o, const reference_camera *c)
{
    enum { W = 48, H = 36 };
    static float z[W * H];
    const reference_planes planes = {.z_m = z};
    reference_params p = {.pyramid = s->planet.pyramid,
                          .camera = *c,
                          .width = W,
                          .height = H,
                          .zoom = o->zoom,
                          .threads = 1};
    assert_int_equal(reference_render(&p, &planes), OK);
    const double rad = M_PI / 180, t = tan(c->fov_deg * rad / 2), turn = c->heading_deg * rad,
                 dip = -c->pitch_deg * rad;
    const double eye[3] = {c->alt_m, SCALE * c->lon_deg * rad, SCALE * c->lat_deg * rad};
    int ground = 0;
    for (int k = 0; k < W * H; k++) {
        double x = (2 * (k % W + 0.5) / W - 1) * t * W / H, y = (1 - 2 * (k / W + 0.5) / H) * t;
        double level_ahead = cos(dip) + y * sin(dip);
        double dir[3] = {y * cos(dip) - sin(dip), x * cos(turn) + level_ahead * sin(turn),
                         level_ahead * cos(turn) - x * sin(turn)};
        double length = sqrt(dir[0] * dir[0] + dir[1] * dir[1] + dir[2] * dir[2]);
        for (int i = 0; i < 3; i++) dir[i] /= length;
        long double least, want = oracle_trace(o, eye, dir, &least) / length;
        if (least < 1e-5L) continue;
        if (isnan(want) != isnan(z[k]) || fabs((double)z[k] - (double)want) > 1e-6 * (double)want)
            fail_msg("lat %g lon %g, pixel %d %d: got %.9g, want %.9Lg", c->lat_deg, c->lon_deg,
                     k % W, k / W, (double)z[k], want);
        ground += !isnan(z[k]);
    }
    assert_true(ground > W * H / 4);
}

static void test_frames(void **state)
{
    (void)state;
    static const reference_camera calm[] = {{20, 10, 2e6, 0, -90, 0, 60},
                                            {-30, 179, 6e4, 250, -20, 0, 70},
                                            {80, 30, 2e4, 90, -20, 0, 50},
                                            {-70, -100, 1e5, 200, -30, 0, 60}};
    // Along the map's east end and its west end.
    static const reference_camera rough[] = {{40, 179.99, 3e3, 359.5, -20, 0, 30},
                                             {-20, -179.99, 3e3, 180, -15, 0, 60}};
    struct ground s;
    const oracle o = {SCALE, SCALE, 3, waves, 0.06, 3000, false, true};
    ground_open(&s, plane(), 3, waves);
    for (int i = 0; i < 4; i++) check_frame(&s, &o, &calm[i]);
    ground_close(&s);
    const oracle n = {SCALE, SCALE, 3, noise, 2, 1000, false, true};
    ground_open(&s, plane(), 3, noise);
    for (int i = 0; i < 2; i++) check_frame(&s, &n, &rough[i]);
    ground_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_closed_forms),
        cmocka_unit_test(test_terrain),
        cmocka_unit_test(test_eye_beside_the_map),
        cmocka_unit_test(test_frames),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
