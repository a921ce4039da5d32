// The map of longitude and latitude as a plane, in every mode: no hole, no crack and nothing off
// the map over flights across it and along its edges; every point on its pixel's ray and at the
// height of the terrain. An argument multiplies the number of flights.
//
// Fails when broken: what lies beyond the map not discarded (watertight, accuracy); latitudes of
// the heights stretched by 2 % about the focus (accuracy). Not seen: by 0.02 %; cells nearer than
// they are to the horizon's test.
#include "render/gaps.h"

static const double RAD = M_PI / 180, A = 6378137.0;

static int times = 1;
static struct gaps_frame seen;

enum { MODES = 4 };

// The planar mode in both its forms.
static const struct {
    const char *name;
    perigee_view_params params;
} modes[MODES] = {
    {"spherical", {.mode = PERIGEE_MODE_SPHERICAL}},
    {"planar", {.mode = PERIGEE_MODE_PLANAR}},
    {"planar, 2004", {.mode = PERIGEE_MODE_PLANAR, .planar_form = PERIGEE_PLANAR_2004}},
    {"grid", {.mode = PERIGEE_MODE_GRID}},
};

static perigee_view *view_of(perigee_planet *planet, int mode)
{
    perigee_view_params params = modes[mode].params;
    params.identify = true;
    return scene_view(planet, &params);
}

static double ground(const perigee_camera *c)
{
    return analytic_height(c->lat_deg * RAD, c->lon_deg * RAD);
}

static int check_gaps(const char *what, int frame, const perigee_camera *c)
{
    struct gaps_counts n = gaps_find(c, &seen, 0);
    if (n.background + n.cracks + n.beyond + n.unidentified)
        fail_msg("%s %d: lat %.9g lon %.9g alt %.9g heading %g pitch %g: %d background pixels, %d "
                 "cracks, %d off the map, %d without an identifier",
                 what, frame, c->lat_deg, c->lon_deg, c->alt_m, c->heading_deg, c->pitch_deg,
                 n.background, n.cracks, n.beyond, n.unidentified);
    return n.inside;
}

// Every other flight begins at an edge of the map or, now and then, at a corner.
static perigee_camera random_camera(struct check_random *r, int i, double *above)
{
    perigee_camera c = {.lat_deg = check_random_range(r, -89, 89),
                        .lon_deg = check_random_range(r, -179, 179),
                        .heading_deg = check_random_range(r, 0, 360),
                        .pitch_deg = check_random_range(r, -90, 0),
                        .fov_deg = check_random_range(r, 46, 100)};
    if (i % 2) c.lon_deg = i % 4 == 1 ? 179.99 : -179.99;
    if (i % 6 == 1) c.lat_deg = 89.9;
    if (i % 6 == 4) c.lat_deg = -89.99;
    *above = pow(10, check_random_range(r, 0.7, 7));
    c.alt_m = ground(&c) + *above;
    return c;
}

static bool fly_on(perigee_camera *c, double *above)
{
    double step = 0.1 * *above / A / RAD, turn = c->heading_deg * RAD;
    c->lat_deg += step * cos(turn);
    c->lon_deg += step * sin(turn);
    c->heading_deg += 11;
    *above *= 0.9;
    c->alt_m = ground(c) + *above;
    return fabs(c->lat_deg) < 90 && fabs(c->lon_deg) < 180;
}

static void test_watertight(void **state)
{
    (void)state;
    enum { FRAMES = 4 };
    perigee_planet *planet = scene_planet();
    for (int mode = 0; mode < MODES; mode++) {
        perigee_view *view = view_of(planet, mode);
        struct check_random r = {17};
        int frames = 0, edges = 0, inside = 0, met = 0;
        for (int i = 0; i < 6 * times; i++) {
            double above;
            perigee_camera c = random_camera(&r, i, &above);
            for (int k = 0; k < FRAMES; k++) {
                scene_render(view, &c, GAPS_WIDTH, GAPS_HEIGHT);
                gaps_read(view, &seen);
                int here = check_gaps(modes[mode].name, FRAMES * i + k, &c);
                inside += here;
                edges += here > 100 && here < GAPS_PIXELS - 100;
                met += gaps_met(&seen, GAPS_LEVEL) > 0;
                frames++;
                if (!fly_on(&c, &above)) break;
            }
        }
        print_message("%s: %d frames, no hole, %d with an edge of the map or its horizon, %d with "
                      "a level border in the middle\n",
                      modes[mode].name, frames, edges, met);
        assert_true(edges >= 6 && inside > 6 * GAPS_PIXELS);
        assert_true(met > 2 || mode == MODES - 1);
        perigee_view_destroy(&view);
    }
    perigee_planet_close(&planet);
}

static const perigee_camera views[] = {
    {.lat_deg = 20, .lon_deg = 10, .alt_m = 2e7, .pitch_deg = -90, .fov_deg = 60},
    {.lat_deg = 45,
     .lon_deg = 10,
     .alt_m = 2e5,
     .heading_deg = 200,
     .pitch_deg = -20,
     .fov_deg = 60},
    {.lat_deg = -33,
     .lon_deg = 151,
     .alt_m = 2e4,
     .heading_deg = 80,
     .pitch_deg = -8,
     .fov_deg = 70},
    {.lat_deg = 80,
     .lon_deg = -60,
     .alt_m = 6e3,
     .heading_deg = 300,
     .pitch_deg = 0,
     .fov_deg = 60},
    {.lat_deg = 70,
     .lon_deg = 179.9,
     .alt_m = 3e4,
     .heading_deg = -60,
     .pitch_deg = -30,
     .fov_deg = 60},
    {.lat_deg = 10, .lon_deg = 30, .alt_m = 1e5, .heading_deg = 33, .pitch_deg = -12, .fov_deg = 4},
};

enum { VIEWS = sizeof views / sizeof *views };

struct errors {
    double off_ray_px, height_px; // greatest; of 99.9 %
    int ground;
};

static int ascending(const void *a, const void *b)
{
    double p = *(const double *)a, q = *(const double *)b;
    return (p > q) - (p < q);
}

static struct errors errors_of(const perigee_camera *c, const perigee_planes *planes, int width,
                               int height)
{
    struct errors e = {0};
    double *heights = malloc((size_t)(width * height) * sizeof *heights);
    double pixel = 2 * tan(c->fov_deg * RAD / 2) / height;
    assert_non_null(heights);
    for (int k = 0; k < width * height; k++) {
        double o[3], d[3], z = planes->z_m[k];
        if (isnan(z)) continue;
        scene_ray(c, width, height, k % width + 0.5, k / width + 0.5, o, d);
        double lat = planes->lat_deg[k] * RAD, lon = planes->lon_deg[k] * RAD;
        double at[3] = {planes->height_m[k], A * lon, A * lat};
        double off = 0;
        for (int i = 0; i < 3; i++) off += pow(at[i] - o[i] - z * d[i], 2);
        e.off_ray_px = fmax(e.off_ray_px, sqrt(off) / (pixel * z));
        heights[e.ground++] = fabs(at[0] - analytic_height(lat, lon)) / (pixel * z);
    }
    if (e.ground) {
        qsort(heights, (size_t)e.ground, sizeof *heights, ascending);
        e.height_px = heights[(int)(0.999 * (e.ground - 1))];
    }
    free(heights);
    return e;
}

static void test_accuracy(void **state)
{
    (void)state;
    enum { W = SCENE_WIDTH, H = SCENE_HEIGHT };
    static float z[W * H], h[W * H];
    static double lat[W * H], lon[W * H];
    perigee_planes planes = {.z_m = z, .height_m = h, .lat_deg = lat, .lon_deg = lon};
    perigee_planet *planet = scene_planet();
    for (int mode = 0; mode < MODES; mode++) {
        perigee_view *view = view_of(planet, mode);
        double worst = 0, off = 0;
        for (int i = 0; i < VIEWS; i++) {
            scene_render(view, &views[i], W, H);
            assert_int_equal(perigee_view_read_planes(view, &planes), 0);
            struct errors e = errors_of(&views[i], &planes, W, H);
            assert_true(e.ground > W * H / 20);
            print_message("%s %d: %d ground, %.2g px off the ray, height %.3g px (99.9 %%)\n",
                          modes[mode].name, i, e.ground, e.off_ray_px, e.height_px);
            worst = fmax(worst, e.height_px);
            off = fmax(off, e.off_ray_px);
        }
        assert_true(off <= 1e-2);
        assert_true(worst <= 0.01);
        perigee_view_destroy(&view);
    }
    perigee_planet_close(&planet);
}

// On the map and under its ground, as over a globe.
static void test_camera_under_the_plane(void **state)
{
    (void)state;
    perigee_planet *planet = scene_planet();
    perigee_view *view = view_of(planet, 0);
    perigee_camera c = {.lat_deg = 10, .alt_m = -4e6, .pitch_deg = 20, .fov_deg = 60};
    assert_int_not_equal(perigee_view_set_camera(view, &c), 0);
    assert_non_null(strstr(perigee_last_error(), "impossible camera: altitude in metres -4e+06"));
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
}

int main(int argc, char **argv)
{
    if (argc > 1) times = atoi(argv[1]);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_watertight),
        cmocka_unit_test(test_accuracy),
        cmocka_unit_test(test_camera_under_the_plane),
    };
    scene_set_flat(true);
    int rc = scene_open();
    return rc ? rc : scene_close(cmocka_run_group_tests(tests, NULL, NULL));
}
