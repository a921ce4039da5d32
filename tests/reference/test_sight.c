// What a camera sees: only the tiles that its picture can meet are read, and no ray misses any of
// them; zooms chosen by distance hold the error they state.
#include "check.h"

#include "base/log.h"
#include "planet/planet_fixture.h"
#include "reference/geographic.h"
#include "reference/reference.h"

#define RAD (M_PI / 180)

static fixture files;
static opened plain, rough; // the same planet without and with synthesis
static struct pool *pool;

static int set_up(void **state)
{
    (void)state;
    fixture_init(&files, "reference-sight");
    fixture_write(&files, 2, 0.3, fixture_rough_height, NULL);
    plain = fixture_open(&files, 0, false);
    rough = fixture_open(&files, 0, true);
    pool = pool_create(2, 4);
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    pool_destroy(&pool);
    fixture_close(&plain);
    fixture_close(&rough);
    fixture_deinit(&files);
    return 0;
}

static const reference_progress silent;

static field_sight all_round(dvec3 eye)
{
    return (field_sight){.eye = eye};
}

// A pyramid of rays about `middle`, which is level with two of its sides.
static field_sight pyramid_of(dvec3 eye, dvec3 middle, double half_angle)
{
    dvec3 up = fabs(middle.z) < 0.9 ? dvec3_make(0, 0, 1) : dvec3_make(1, 0, 0);
    dvec3 right = dvec3_normalize(dvec3_cross(middle, up)), top = dvec3_cross(right, middle);
    field_sight s = {.eye = eye, .sides = 4};
    double sn = sin(half_angle), cs = cos(half_angle);
    s.side[0] = dvec3_mad(dvec3_scale(middle, sn), right, cs);
    s.side[1] = dvec3_mad(dvec3_scale(middle, sn), right, -cs);
    s.side[2] = dvec3_mad(dvec3_scale(middle, sn), top, cs);
    s.side[3] = dvec3_mad(dvec3_scale(middle, sn), top, -cs);
    return s;
}

// Every second ray runs along a side.
static dvec3 random_ray(struct check_random *r, const field_sight *s, dvec3 middle, double reach)
{
    for (int side = (int)check_random_range(r, 0, 8);;) {
        dvec3 d = middle;
        d.x += check_random_range(r, -reach, reach);
        d.y += check_random_range(r, -reach, reach);
        d.z += check_random_range(r, -reach, reach);
        if (side < 4) d = dvec3_mad(d, s->side[side], -dvec3_dot(d, s->side[side]));
        d = dvec3_normalize(d);
        bool inside = true;
        for (int i = 0; i < 4; i++) inside &= dvec3_dot(d, s->side[i]) >= -1e-15;
        if (inside) return d;
    }
}

static void place(double lat, double lon, double height, dvec3 *eye)
{
    double xyz[3];
    geo_ellipsoid e = pyramid_meta(plain.pyramid)->ellipsoid;
    reference_ecef(e.a, e.b, lat, lon, height, xyz);
    *eye = dvec3_make(xyz[0], xyz[1], xyz[2]);
}

static struct field *make_field(field_sight sight, int zoom)
{
    struct field *f;
    const field_params params = {.pyramid = plain.pyramid, .zoom = zoom, .sight = sight};
    assert_int_equal(field_create(&params, pool, &silent, &f), OK);
    return f;
}

static const struct {
    double lat, lon, alt, pitch, heading;
} eyes[] = {{10, 179.9, 60000, -20, 80},   {89.9, 20, 40000, -10, 200}, {-90, 0, 30000, -5, 0},
            {45, -100, 2e6, -60, 300},     {-63, 10, 15000, 3, 170},    {30, 60, 1e9, -90, 0},
            {82, -179.99, 25000, -15, 265}};

static dvec3 look(double lat, double lon, double heading, double pitch)
{
    double sl = sin(lat * RAD), cl = cos(lat * RAD), so = sin(lon * RAD), co = cos(lon * RAD);
    dvec3 east = {-so, co, 0}, north = {-sl * co, -sl * so, cl}, up = {cl * co, cl * so, sl};
    dvec3 ahead = dvec3_mad(dvec3_scale(north, cos(heading * RAD)), east, sin(heading * RAD));
    return dvec3_mad(dvec3_scale(ahead, cos(pitch * RAD)), up, sin(pitch * RAD));
}

// Any ray of the picture meets the same ground, whether only the tiles in sight were read or all.
static void test_no_tile_is_missed(void **state)
{
    (void)state;
    struct check_random r = {21};
    int hits = 0, misses = 0;
    for (size_t i = 0; i < sizeof eyes / sizeof eyes[0]; i++) {
        dvec3 eye, middle = look(eyes[i].lat, eyes[i].lon, eyes[i].heading, eyes[i].pitch);
        place(eyes[i].lat, eyes[i].lon, eyes[i].alt, &eye);
        double half = eyes[i].alt > 1e8 ? 0.004 : 0.25;
        int zoom = eyes[i].alt > 1e5 ? 5 : 7;
        field_sight sight = pyramid_of(eye, middle, half);
        struct field *all = make_field(all_round(eye), zoom), *some = make_field(sight, zoom);
        struct field_reader a, b;
        field_reader_init(&a, all, plain.pyramid);
        field_reader_init(&b, some, plain.pyramid);
        for (int j = 0; j < 1500; j++) {
            dvec3 dir = random_ray(&r, &sight, middle, 2 * half);
            ray_hit want, got;
            bool hit = ray_cast(&a, eye, dir, 1e-3, &want);
            assert_int_equal(ray_cast(&b, eye, dir, 1e-3, &got), hit);
            hits += hit;
            misses += !hit;
            if (hit) check_near(got.t, want.t, RAY_TOLERANCE * 1e-3 * want.t + 1e-6);
        }
        print_message("%g %g %g m: %zu of %zu tiles\n", eyes[i].lat, eyes[i].lon, eyes[i].alt,
                      field_tiles(some), field_tiles(all));
        assert_true(field_tiles(some) <= field_tiles(all));
        if (i != 5) assert_true(2 * field_tiles(some) < field_tiles(all));
        field_reader_deinit(&a);
        field_reader_deinit(&b);
        field_destroy(&all);
        field_destroy(&some);
    }
    assert_true(hits > 4000 && misses > 500);
}

enum { WIDTH = 96, HEIGHT = 72, PIXELS = WIDTH * HEIGHT };

// At every pixel the ground of the zoom chosen there is as near as stated to that of many zooms
// more, in pixels of the picture's middle. Ground nearer than a quarter of the clearance is counted
// at that distance.
static void check_auto(const opened *planet, const reference_camera *c, double error_px,
                       bool bicubic)
{
    static float z[PIXELS], height[PIXELS], level[PIXELS];
    static double lat[PIXELS], lon[PIXELS];
    sight_ground ground;
    reference_params p = {.pyramid = planet->pyramid,
                          .camera = *c,
                          .width = WIDTH,
                          .height = HEIGHT,
                          .zoom = SIGHT_AUTO,
                          .error_px = error_px,
                          .bicubic = bicubic,
                          .ground = &ground};
    reference_planes planes = {
        .z_m = z, .height_m = height, .level = level, .lat_deg = lat, .lon_deg = lon};
    assert_int_equal(reference_render(&p, &planes), OK);
    double pixel = 2 * tan(c->fov_deg * RAD / 2) / HEIGHT, worst = 0, sum = 0;
    int compared = 0, finest = 0, coarsest = 24;
    for (int i = 0; i < PIXELS; i++) {
        if (isnan(z[i])) continue;
        double limit, e;
        int zoom = (int)level[i] + 6 < GRID_MAX_ZOOM ? (int)level[i] + 6 : GRID_MAX_ZOOM;
        assert_int_equal(
            pyramid_height_at(planet->pyramid, zoom, lat[i] * RAD, lon[i] * RAD, &limit), OK);
        e = fabs(limit - height[i]) / (pixel * z[i]);
        worst = fmax(worst, e);
        sum += e * e;
        compared++;
        finest = level[i] > finest ? (int)level[i] : finest;
        coarsest = level[i] < coarsest ? (int)level[i] : coarsest;
    }
    print_message("%s %g %g %g m, %g px: zooms %d to %d (%d to %d stated), stated %.4f, rms %.4f, "
                  "worst %.4f px\n",
                  bicubic ? "bicubic" : "bilinear", c->lat_deg, c->lon_deg, c->alt_m, error_px,
                  coarsest, finest, ground.zoom_min, ground.zoom_max, ground.error_px,
                  sqrt(sum / compared), worst);
    assert_true(compared > PIXELS / 5);
    assert_true(ground.zoom_min <= coarsest && ground.zoom_max >= finest);
    assert_true(ground.error_px <= error_px);
    assert_true(worst <= ground.error_px);
}

static void test_auto_holds_its_error(void **state)
{
    (void)state;
    double ground;
    assert_int_equal(pyramid_height_at(rough.pyramid, 24, 40 * RAD, 20 * RAD, &ground), OK);
    const reference_camera cameras[] = {{40, 20, 1e7, 0, -90, 0, 40},
                                        {40, 20, 3e5, 30, -30, 0, 60},
                                        {40, 20, ground + 3e3, 130, -20, 0, 60},
                                        {89.99, 20, 4e4, 130, -20, 0, 60}};
    for (int i = 0; i < 8; i++) check_auto(&plain, &cameras[i / 2], 0.02, i % 2);
    for (int i = 0; i < 4; i++) check_auto(&rough, &cameras[i], 0.2, false);
    check_auto(&rough, &cameras[1], 0.2, true);
}

// Given zooms are taken as they are.
static void test_given_zooms(void **state)
{
    (void)state;
    static const int zooms[] = {SIGHT_STORED, 0, 4}, want[] = {2, 0, 4};
    static float level[PIXELS];
    for (int i = 0; i < 3; i++) {
        sight_ground ground;
        reference_params p = {.pyramid = rough.pyramid,
                              .camera = {10, 20, 1e6, 0, -90, 0, 30},
                              .width = WIDTH,
                              .height = HEIGHT,
                              .zoom = zooms[i],
                              .ground = &ground};
        reference_planes planes = {.level = level};
        assert_int_equal(reference_render(&p, &planes), OK);
        assert_int_equal(ground.zoom_min, want[i]);
        assert_int_equal(ground.zoom_max, want[i]);
        check_near(ground.error_px, 0, 0);
        for (int k = 0; k < PIXELS; k++) check_near(level[k], want[i], 0);
    }
}

static bool stop_at_once(void *user, double done)
{
    ++*(int *)user;
    return done >= 0;
}

// A scan of many tiles ends when it is asked to.
static void test_scan_is_cancelled(void **state)
{
    (void)state;
    int calls = 0;
    reference_params p = {.pyramid = rough.pyramid,
                          .camera = {10, 20, 1e5, 0, -20, 0, 60},
                          .width = WIDTH,
                          .height = HEIGHT,
                          .zoom = 9,
                          .progress = {stop_at_once, &calls}};
    reference_planes none = {0};
    assert_int_equal(reference_render(&p, &none), ERR_CANCELLED);
    assert_int_equal(calls, 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_no_tile_is_missed),
        cmocka_unit_test(test_auto_holds_its_error),
        cmocka_unit_test(test_given_zooms),
        cmocka_unit_test(test_scan_is_cancelled),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
