// Geometry clipmaps wrapped onto the planet: no hole and no T-junction over flights, the terrain at
// its place, one picture whatever path led there, no jump from frame to frame, and what cannot be
// is refused. An argument multiplies the number of flights.
//
// What makes each fail is said in tests/ACCURACY-geometries.md.
#include "render/gaps.h"

static const double RAD = M_PI / 180;

static int times = 1;
static struct gaps_frame seen;

static double ground(const perigee_camera *c)
{
    return analytic_height(c->lat_deg * RAD, c->lon_deg * RAD);
}

static void check_gaps(const char *what, int frame, const perigee_camera *c)
{
    struct gaps_counts n = gaps_find(c, &seen, 0);
    if (n.background + n.cracks + n.unidentified)
        fail_msg("%s %d: lat %.9g lon %.9g alt %.9g heading %g pitch %g: %d background pixels, %d "
                 "cracks, %d without an identifier",
                 what, frame, c->lat_deg, c->lon_deg, c->alt_m, c->heading_deg, c->pitch_deg,
                 n.background, n.cracks, n.unidentified);
}

// A flight: a place, a bearing, a climb; steps of a tenth of the height above ground.
struct flight {
    perigee_camera c;
    double above, climb, east, north;
};

static struct flight random_flight(struct check_random *r, double most_lat)
{
    struct flight f = {.above = pow(10, check_random_range(r, 0.7, 5.8)),
                       .climb = check_random_range(r, -0.2, 0.2)};
    double bearing = check_random_range(r, 0, 2 * M_PI);
    f.east = sin(bearing);
    f.north = cos(bearing);
    f.c = (perigee_camera){.lat_deg = check_random_range(r, -most_lat, most_lat),
                           .lon_deg = check_random_range(r, -180, 180),
                           .heading_deg = check_random_range(r, 0, 360),
                           .pitch_deg = check_random_range(r, -90, 0),
                           .fov_deg = check_random_range(r, 46, 100)};
    return f;
}

static void fly_on(struct flight *f)
{
    double step = 0.1 * f->above / 6.371e6 / RAD;
    f->c.lat_deg += step * f->north;
    f->c.lon_deg += step * f->east / cos(f->c.lat_deg * RAD);
    f->c.heading_deg += 7;
    f->above *= 1 + f->climb;
    f->c.alt_m = ground(&f->c) + f->above;
}

static int level_borders(void)
{
    return gaps_met(&seen, GAPS_LEVEL) > 0;
}

// With what happens to be there of a new place. Near the ground late data may lie above the camera.
static int check_late(perigee_view *view, const char *what, int frame, const struct flight *f)
{
    scene_bind(GAPS_WIDTH, GAPS_HEIGHT);
    assert_int_equal(perigee_view_set_camera(view, &f->c), 0);
    for (int i = 0; i < 3; i++) {
        assert_int_equal(perigee_view_render(view, GAPS_WIDTH, GAPS_HEIGHT), 0);
        gaps_read(view, &seen);
        if (f->above > 200) check_gaps(what, frame, &f->c);
    }
    return seen.late;
}

static int fly_everywhere(const char *what, const perigee_view_params *params, int flights,
                          uint64_t seed)
{
    enum { FRAMES = 6 };
    perigee_planet *planet = scene_planet();
    perigee_view_params with = *params;
    with.mode = PERIGEE_MODE_PLANAR;
    with.identify = true;
    perigee_view *view = scene_view(planet, &with);
    struct check_random r = {seed};
    int met = 0, antimeridian = 0, late = 0;
    for (int i = 0; i < flights; i++) {
        struct flight f = random_flight(&r, 60);
        if (i % 4 == 0) f.c.lon_deg = 179.9999;
        for (int k = 0; k < FRAMES; k++) {
            fly_on(&f);
            if (k == 0) late += check_late(view, what, i * FRAMES, &f);
            scene_render(view, &f.c, GAPS_WIDTH, GAPS_HEIGHT);
            gaps_read(view, &seen);
            check_gaps(what, i * FRAMES + k, &f.c);
            met += level_borders();
            antimeridian += gaps_met(&seen, GAPS_ANTIMERIDIAN) > 0;
        }
    }
    print_message("%s: %d flights of %d frames, %d begun late, no hole; in the middle %d x level "
                  "border, %d x antimeridian\n",
                  what, flights, FRAMES, late, met, antimeridian);
    assert_true(late > 0);
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
    return met;
}

static void test_watertight(void **state)
{
    (void)state;
    const perigee_view_params small = {.planar_n = 63}, half = {.planar_n = 127, .texels = 512},
                              all = {.planar_n = 31, .no_cull = true};
    int met = fly_everywhere("n = 255", &(perigee_view_params){0}, 5 * times, 17);
    met += fly_everywhere("n = 63", &small, 2 * times, 18);
    met += fly_everywhere("n = 127 of 512", &half, 2 * times, 19);
    met += fly_everywhere("n = 31, no culling", &all, 2 * times, 20);
    assert_true(met > 12);
}

static void test_watertight_2004(void **state)
{
    (void)state;
    const perigee_view_params whole = {.planar_form = PERIGEE_PLANAR_2004},
                              bound = {.planar_form = PERIGEE_PLANAR_2004,
                                       .planar_n = 63,
                                       .planar_triangles = 10000};
    // Every region but the coarsest as small as can be: the finer level's border is two steps from
    // the coarser one's.
    const perigee_view_params least = {.planar_form = PERIGEE_PLANAR_2004,
                                       .planar_triangles = 1000};
    int met = fly_everywhere("2004, n = 255", &whole, 3 * times, 21);
    met += fly_everywhere("2004, n = 63, 10,000 triangles", &bound, 2 * times, 22);
    met += fly_everywhere("2004, n = 255, 1,000 triangles", &least, 4 * times, 23);
    assert_true(met > 6);
}

// From a hundredth of a degree, with the squares about what is looked at, to 179.
static void test_fields_of_view(void **state)
{
    (void)state;
    static const double fovs[] = {0.01, 0.3, 5, 21, 44, 130, 179};
    perigee_planet *planet = scene_planet();
    struct check_random r = {9};
    int ground_px = 0;
    for (int form = 0; form < 2; form++) {
        perigee_view_params params = {.mode = PERIGEE_MODE_PLANAR,
                                      .identify = true,
                                      .planar_form =
                                          form ? PERIGEE_PLANAR_2004 : PERIGEE_PLANAR_GPU};
        perigee_view *view = scene_view(planet, &params);
        for (int i = 0; i < 14; i++) {
            struct flight f = random_flight(&r, 60);
            f.c.fov_deg = fovs[i % 7];
            f.above =
                fmax(f.above, 50); // beyond the near plane, 0.1 m along the axis, at 179 degrees
            f.c.alt_m = ground(&f.c) + f.above;
            scene_render(view, &f.c, GAPS_WIDTH, GAPS_HEIGHT);
            gaps_read(view, &seen);
            check_gaps("field of view", i, &f.c);
            ground_px += gaps_find(&f.c, &seen, 0).inside;
        }
        perigee_view_destroy(&view);
    }
    assert_true(ground_px > 14 * GAPS_PIXELS);
    perigee_planet_close(&planet);
}

// Footprints and rectangles are the same triangles: the same depths, to the last bit.
static void test_forms_agree(void **state)
{
    (void)state;
    static struct gaps_frame other;
    perigee_planet *planet = scene_planet();
    perigee_view_params params = {.mode = PERIGEE_MODE_PLANAR, .identify = true};
    perigee_view *a = scene_view(planet, &params);
    params.planar_form = PERIGEE_PLANAR_2004;
    perigee_view *b = scene_view(planet, &params);
    struct check_random r = {3};
    for (int i = 0; i < 8; i++) {
        struct flight f = random_flight(&r, 80);
        f.c.alt_m = ground(&f.c) + f.above;
        scene_render(a, &f.c, GAPS_WIDTH, GAPS_HEIGHT);
        gaps_read(a, &seen);
        scene_render(b, &f.c, GAPS_WIDTH, GAPS_HEIGHT);
        gaps_read(b, &other);
        assert_memory_equal(seen.z, other.z, sizeof seen.z);
        perigee_stats sa, sb;
        perigee_view_get_stats(a, &sa);
        perigee_view_get_stats(b, &sb);
        assert_int_equal(sa.triangles_total, sb.triangles_total);
        assert_true(sb.triangles_drawn < sa.triangles_drawn); // rectangles fit the frustum closer
    }
    perigee_view_destroy(&a);
    perigee_view_destroy(&b);
    perigee_planet_close(&planet);
}

// Regions shrink until the bound is kept, and the ground stays whole.
static void test_throttling(void **state)
{
    (void)state;
    static const uint32_t bounds[] = {0, 100000, 50000, 25000};
    uint64_t drawn[4];
    perigee_planet *planet = scene_planet();
    perigee_camera c = {
        .lat_deg = 40, .lon_deg = 20, .heading_deg = 70, .pitch_deg = -15, .fov_deg = 70};
    c.alt_m = ground(&c) + 3000;
    for (int i = 0; i < 4; i++) {
        perigee_view_params params = {.mode = PERIGEE_MODE_PLANAR,
                                      .identify = true,
                                      .planar_form = PERIGEE_PLANAR_2004,
                                      .planar_triangles = bounds[i]};
        perigee_view *view = scene_view(planet, &params);
        scene_render(view, &c, GAPS_WIDTH, GAPS_HEIGHT);
        gaps_read(view, &seen);
        check_gaps("throttled", i, &c);
        perigee_stats stats;
        perigee_view_get_stats(view, &stats);
        drawn[i] = stats.triangles_drawn;
        perigee_view_destroy(&view);
    }
    print_message(
        "triangles, zero-area ones included: %llu without a bound, %llu, %llu, %llu within "
        "100,000, 50,000, 25,000\n",
        (unsigned long long)drawn[0], (unsigned long long)drawn[1], (unsigned long long)drawn[2],
        (unsigned long long)drawn[3]);
    enum { BORDERS = 22 * 508 };
    assert_true(drawn[0] > 150000);
    for (int i = 1; i < 4; i++) {
        assert_true(drawn[i] <= bounds[i] + BORDERS);
        assert_true(drawn[i] >= bounds[i] / 2);
    }
    perigee_planet_close(&planet);
}

static int finest_drawn(perigee_view *view, const perigee_camera *c)
{
    perigee_stats stats;
    scene_render(view, c, 64, 48);
    perigee_view_get_stats(view, &stats);
    return (int)stats.last_level;
}

// A level of n vertices g metres apart is active below 0.4 n g over the ground (2004, 3), which is
// when its side is 2.5 times the height (2005, 2.3.1). 15 km up to 3 %; near the ground up to a
// tenth sooner, as finer detail may rise above the samples that are looked at, but not later.
static void test_active_levels(void **state)
{
    (void)state;
    static const struct {
        int n, form, circle; // steps of level 0 round the equator
    } kinds[] = {{63, PERIGEE_PLANAR_2004, 64}, {255, PERIGEE_PLANAR_GPU, 256}};
    perigee_planet *planet = scene_planet();
    for (int i = 0; i < 2; i++) {
        perigee_view_params params = {.mode = PERIGEE_MODE_PLANAR,
                                      .planar_n = kinds[i].n,
                                      .planar_form = (enum perigee_planar_form)kinds[i].form};
        perigee_view *view = scene_view(planet, &params);
        for (int level = 10; level <= 19; level += 3) {
            double g = 2 * M_PI * 6378137 / kinds[i].circle / (1 << level),
                   h = 0.4 * kinds[i].n * g, ground_m;
            perigee_camera c = {.lat_deg = 17, .lon_deg = 40, .pitch_deg = -40, .fov_deg = 60};
            assert_int_equal(perigee_planet_height(planet, c.lat_deg, c.lon_deg, &ground_m), 0);
            c.alt_m = ground_m + (level == 10 ? 1.03 : 1.1) * h;
            assert_int_equal(finest_drawn(view, &c), level - 1);
            c.alt_m = ground_m + 0.97 * h;
            assert_int_equal(finest_drawn(view, &c), level);
        }
        perigee_view_destroy(&view);
    }
    perigee_planet_close(&planet);
}

// Even where wrapping fails nothing is open.
static void test_poles_have_no_hole(void **state)
{
    (void)state;
    static const double places[][3] = {{90, 0, 1e4},    {-90, 40, 2e6},     {89.99, 170, 500},
                                       {85, -60, 3e5},  {-84, 179.99, 1e3}, {70, 20, 5e6},
                                       {-88, 100, 1e5}, {0, 0, 3e7},        {45, 180, 2e7}};
    perigee_planet *planet = scene_planet();
    perigee_view_params params = {.mode = PERIGEE_MODE_PLANAR, .identify = true};
    perigee_view *view = scene_view(planet, &params);
    int told = 0, step = times > 1 ? 1 : 2;
    for (int i = 0; i < 9; i++) {
        for (int k = i % 2; k < 4; k += step) {
            perigee_camera c = {.lat_deg = places[i][0],
                                .lon_deg = places[i][1],
                                .heading_deg = 90 * k,
                                .pitch_deg = k % 2 ? -90 : -40,
                                .fov_deg = 70};
            c.alt_m = places[i][2] + ground(&c);
            scene_render(view, &c, GAPS_WIDTH, GAPS_HEIGHT);
            gaps_read(view, &seen);
            check_gaps("pole", 4 * i + k, &c);
            perigee_stats stats;
            perigee_view_get_stats(view, &stats);
            told += stats.map_edge;
            assert_true(stats.map_edge || fabs(c.lat_deg) < 84.5);
        }
    }
    print_message("%d frames with a pole in sight, no hole\n", told);
    assert_true(told >= 14);
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
}

int main(int argc, char **argv)
{
    if (argc > 1) times = atoi(argv[1]);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_watertight),         cmocka_unit_test(test_watertight_2004),
        cmocka_unit_test(test_fields_of_view),     cmocka_unit_test(test_forms_agree),
        cmocka_unit_test(test_throttling),         cmocka_unit_test(test_active_levels),
        cmocka_unit_test(test_poles_have_no_hole),
    };
    int rc = scene_open();
    return rc ? rc : scene_close(cmocka_run_group_tests(tests, NULL, NULL));
}
