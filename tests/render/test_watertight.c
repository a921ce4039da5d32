// Never a hole: over random views, every pixel whose ray meets the ellipsoid lowered beneath the
// deepest terrain shows the planet, with all data there and with what happens to be there.
#include "render/scene.h"

enum { VIEWS = 100, WIDTH = 200, HEIGHT = 150 };

static bool must_show(const double o[3], const double d[3])
{
    double a = 6378137.0 - ANALYTIC_HEIGHT_MAX - 1, b = 6356752.314245179 - ANALYTIC_HEIGHT_MAX - 1;
    double x[3] = {o[0] / a, o[1] / a, o[2] / b}, v[3] = {d[0] / a, d[1] / a, d[2] / b};
    double vv = v[0] * v[0] + v[1] * v[1] + v[2] * v[2],
           xv = x[0] * v[0] + x[1] * v[1] + x[2] * v[2];
    double xx = x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
    return xv < 0 && xv * xv - vv * (xx - 1) > 0;
}

static int holes(const perigee_camera *c, const float *z, int *inside)
{
    int count = 0;
    for (int y = 0; y < HEIGHT; y++) {
        for (int x = 0; x < WIDTH; x++) {
            double o[3], d[3];
            scene_ray(c, WIDTH, HEIGHT, x + 0.5, y + 0.5, o, d);
            if (!must_show(o, d)) continue;
            (*inside)++;
            count += isnan(z[y * WIDTH + x]);
        }
    }
    return count;
}

// A third of the views aim at places where something meets: poles, antimeridian, the equator.
static perigee_camera random_camera(struct check_random *r, int i, double *above)
{
    static const double odd[][2] = {{90, 0},  {-90, 12},  {89.99999, 170},
                                    {0, 180}, {45, -180}, {-89.7, 90}};
    perigee_camera c = {.lat_deg = asin(check_random_range(r, -1, 1)) * 180 / M_PI,
                        .lon_deg = check_random_range(r, -180, 180),
                        .heading_deg = check_random_range(r, 0, 360),
                        .pitch_deg = check_random_range(r, -90, 5),
                        .fov_deg = pow(10, check_random_range(r, 0.5, 2))};
    if (i % 3 == 0) {
        c.lat_deg = odd[i / 3 % 6][0];
        c.lon_deg = odd[i / 3 % 6][1];
    }
    *above = pow(10, check_random_range(r, 0.5, 7.5));
    c.alt_m = *above + analytic_height(c.lat_deg * M_PI / 180, c.lon_deg * M_PI / 180);
    return c;
}

static void test_no_view_has_a_hole(void **state)
{
    (void)state;
    static float z[WIDTH * HEIGHT];
    perigee_planet *planet = scene_planet();
    perigee_view *view = scene_view(planet, NULL);
    perigee_planes planes = {.z_m = z};
    struct check_random r = {31};
    int inside = 0, late = 0;
    for (int i = 0; i < VIEWS; i++) {
        double above;
        perigee_camera c = random_camera(&r, i, &above);
        // First with whatever is there of the new place, then complete.
        scene_bind(WIDTH, HEIGHT);
        assert_int_equal(perigee_view_set_camera(view, &c), 0);
        for (int complete = 0; complete < 2; complete++) {
            if (complete) scene_render(view, &c, WIDTH, HEIGHT);
            else assert_int_equal(perigee_view_render(view, WIDTH, HEIGHT), 0);
            perigee_stats s;
            perigee_view_get_stats(view, &s);
            late += s.needs_redraw;
            assert_int_equal(perigee_view_read_planes(view, &planes), 0);
            int found = complete || above > 200 ? holes(&c, z, &inside) : 0;
            if (found)
                fail_msg(
                    "view %d (%s): lat %.9g lon %.9g alt %.9g heading %g pitch %g fov %g: %d holes",
                    i, complete ? "complete" : "late", c.lat_deg, c.lon_deg, c.alt_m, c.heading_deg,
                    c.pitch_deg, c.fov_deg, found);
        }
    }
    print_message("%d views twice, %d of them late, %d pixels inside the limb, no hole\n", VIEWS,
                  late, inside);
    assert_true(late > VIEWS / 2);
    assert_true(inside > VIEWS * WIDTH * HEIGHT / 4);
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_no_view_has_a_hole)};
    int rc = scene_open();
    return rc ? rc : scene_close(cmocka_run_group_tests(tests, NULL, NULL));
}
