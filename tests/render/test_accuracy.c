// The rendered depth of the analytic planet against tracing it in double precision, from space, air
// and ground, at the equator, 60 N and both poles. Error in pixels: what separates rendered point
// and surface, seen from the camera.
#include "render/scene.h"
#include "gpu/gpu_fixture.h"

enum { PIXELS = 1500 };

struct result {
    double rms, p999, worst;
    int compared, silhouette;
};

static int compare_double(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// Error of a pixel in pixels: the rendered point's height above or below the true surface,
// foreshortened not at all, over the size of a pixel there. NaN when it does not count.
static double pixel_error(const perigee_camera *c, const double o[3], const double d[3], double z)
{
    double p[3], lat, lon, height;
    for (int i = 0; i < 3; i++) p[i] = o[i] + z * d[i];
    scene_geodetic(p, &lat, &lon, &height);
    double pixel = 2 * z * tan(c->fov_deg * M_PI / 360) / SCENE_HEIGHT;
    return fabs(height - analytic_height(lat, lon)) / pixel;
}

static struct result compare(const perigee_camera *c, const float *z, struct check_random *r)
{
    static double errors[PIXELS];
    struct result s = {0};
    double sum = 0;
    for (int i = 0; i < PIXELS; i++) {
        int x = (int)check_random_range(r, 0, SCENE_WIDTH),
            y = (int)check_random_range(r, 0, SCENE_HEIGHT);
        double o[3], d[3], rendered = z[y * SCENE_WIDTH + x];
        scene_ray(c, SCENE_WIDTH, SCENE_HEIGHT, x + 0.5, y + 0.5, o, d);
        double truth = scene_trace(o, d);
        if (isnan(truth) != isnan(rendered)) s.silhouette++;
        if (isnan(truth) || isnan(rendered)) continue;
        double e = pixel_error(c, o, d, rendered);
        errors[s.compared++] = e;
        sum += e * e;
    }
    if (!s.compared) return s;
    qsort(errors, (size_t)s.compared, sizeof *errors, compare_double);
    s.rms = sqrt(sum / s.compared);
    s.p999 = errors[(int)(0.999 * (s.compared - 1))];
    s.worst = errors[s.compared - 1];
    return s;
}

static const struct {
    const char *name;
    double above, pitch;
} HEIGHTS[] = {{"space", 1.2e7, -90}, {"air", 20000, -25}, {"ground", 100, -8}};

struct bound {
    double rms, p999; // px
    int silhouette;   // points
};

static const struct bound RINGS = {0.5, 2, PIXELS / 200};

static void check_depth(perigee_view *view, const char *name, const perigee_camera *c,
                        struct check_random *r, struct bound most)
{
    static float z[SCENE_WIDTH * SCENE_HEIGHT];
    scene_render(view, c, SCENE_WIDTH, SCENE_HEIGHT);
    perigee_planes planes = {.z_m = z};
    assert_int_equal(perigee_view_read_planes(view, &planes), 0);
    struct result s = compare(c, z, r);
    print_message("%-6s %8.3f %8.3f fov %g: rms %.4f  99.9 %% %.4f  worst %.4f px, %d points, %d "
                  "on the silhouette\n",
                  name, c->lat_deg, c->lon_deg, c->fov_deg, s.rms, s.p999, s.worst, s.compared,
                  s.silhouette);
    assert_true(s.compared > PIXELS / 6);
    assert_true(s.rms <= most.rms);
    assert_true(s.p999 <= most.p999);
    assert_true(s.silhouette <= most.silhouette);
}

// Looks from a place at one of the heights.
static perigee_camera camera_over(double lat_deg, double lon_deg, int h, double fov_deg)
{
    perigee_camera c = {.lat_deg = lat_deg,
                        .lon_deg = lon_deg,
                        .heading_deg = 40,
                        .pitch_deg = HEIGHTS[h].pitch,
                        .fov_deg = fov_deg};
    double ground = analytic_height(lat_deg * M_PI / 180, lon_deg * M_PI / 180);
    c.alt_m = HEIGHTS[h].above + (h ? ground : 0);
    return c;
}

static void test_depth_is_the_terrain(void **state)
{
    (void)state;
    const double places[][2] = {{0, 0},       {0.3, 179.99}, {60, 25},    {90, 0},
                                {89.97, 130}, {-90, 0},      {-89.2, -77}};
    perigee_planet *planet = scene_planet();
    perigee_view *view = scene_view(planet, NULL);
    struct check_random r = {99};
    for (int h = 0; h < 3; h++) {
        for (int i = 0; i < 7; i++) {
            perigee_camera c = camera_over(places[i][0], places[i][1], h, 60);
            check_depth(view, HEIGHTS[h].name, &c, &r, RINGS);
        }
    }
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
}

// The persistent grid, also through the narrowest and the widest lens, at a pole and on the
// antimeridian. Bounds are about twice what was measured; through the narrowest lens the rings
// measure as much, as a pixel is half a millimetre of ground, and through the widest the points on
// the silhouette are as many.
static void test_grid_is_the_terrain(void **state)
{
    (void)state;
    static const struct {
        double lat, lon, fov;
        int height;
        struct bound most;
    } views[] = {
        {90, 0, 60, 0, {0.015, 0.25, 7}},      {0.3, 179.99, 100, 1, {0.0015, 0.02, 7}},
        {-90, 0, 60, 1, {0.006, 0.12, 7}},     {89.97, 130, 60, 2, {0.012, 0.025, 7}},
        {60, 25, 0.01, 0, {0.25, 0.4, 7}},     {-10, -180, 0.01, 2, {1.8, 2.7, 7}},
        {0.3, 45, 0.01, 1, {0.2, 0.5, 7}},     {60, 25, 179, 1, {0.006, 0.15, 25}},
        {-30, -179.9, 60, 2, {0.02, 0.05, 7}}, {45, 12, 1, 1, {0.02, 0.05, 7}},
    };
    perigee_planet *planet = scene_planet();
    perigee_view_params params = {.mode = PERIGEE_MODE_GRID};
    perigee_view *view = scene_view(planet, &params);
    struct check_random r = {98};
    for (size_t i = 0; i < sizeof views / sizeof *views; i++) {
        perigee_camera c = camera_over(views[i].lat, views[i].lon, views[i].height, views[i].fov);
        check_depth(view, HEIGHTS[views[i].height].name, &c, &r, views[i].most);
    }
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
}

// Every selectable way to the map draws the terrain. The smooth planet forgives map errors (its
// slopes are below 0.01), so this guards against blunders; bounds are two to three times what was
// measured. No ring is left out: chords would hide what is looked for.
static void test_every_variant(void **state)
{
    (void)state;
    static float z[SCENE_WIDTH * SCENE_HEIGHT];
    const struct {
        const char *name;
        perigee_view_params params;
        double rms;
    } variants[] = {
        {"stable", {0}, 0.0002},
        {"exact", {.transform = PERIGEE_TRANSFORM_EXACT}, 0.0015},
        {"approx", {.transform = PERIGEE_TRANSFORM_APPROX}, 0.001},
        {"blend", {.transform = PERIGEE_TRANSFORM_BLEND}, 0.0005},
        {"vertex", {.texcoord_vertex = true}, 0.0002},
        {"hardware", {.filter = PERIGEE_FILTER_HARDWARE}, 0.0002},
        {"grid", {.mode = PERIGEE_MODE_GRID}, 0.0015},
    };
    perigee_planet *planet = scene_planet();
    struct check_random r = {5};
    for (size_t i = 0; i < sizeof variants / sizeof *variants; i++) {
        perigee_view_params params = variants[i].params;
        params.ring_spacing_px = -1;
        perigee_view *view = scene_view(planet, &params);
        perigee_camera c = {
            .lat_deg = 45, .lon_deg = 12, .heading_deg = 100, .pitch_deg = -20, .fov_deg = 60};
        c.alt_m = 10000 + analytic_height(c.lat_deg * M_PI / 180, c.lon_deg * M_PI / 180);
        scene_render(view, &c, SCENE_WIDTH, SCENE_HEIGHT);
        perigee_planes planes = {.z_m = z};
        assert_int_equal(perigee_view_read_planes(view, &planes), 0);
        struct result s = compare(&c, z, &r);
        print_message("%-8s: rms %.5f  99.9 %% %.5f  worst %.5f px\n", variants[i].name, s.rms,
                      s.p999, s.worst);
        assert_true(s.compared > PIXELS / 6);
        assert_true(s.rms <= variants[i].rms + gpu_fixture_snap_px());
        perigee_view_destroy(&view);
    }
    perigee_planet_close(&planet);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_depth_is_the_terrain),
                                       cmocka_unit_test(test_grid_is_the_terrain),
                                       cmocka_unit_test(test_every_variant)};
    int rc = scene_open();
    return rc ? rc : scene_close(cmocka_run_group_tests(tests, NULL, NULL));
}
