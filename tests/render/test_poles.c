// Crossing a pole shows nothing special: no hole, no jump, whichever transform and whichever way
// the map coordinates come.
#include "render/scene.h"

// Sky pixels below the horizon's lowest possible line: there must be none.
static int holes(const float *z, int width, int height)
{
    int count = 0;
    for (int x = 0; x < width; x++) {
        bool ground = false;
        for (int y = 0; y < height; y++) {
            if (!isnan(z[y * width + x])) ground = true;
            else if (ground) count++; // sky beneath ground
        }
    }
    return count;
}

static void cross(perigee_view *view, double sign, double bearing)
{
    static float z[SCENE_WIDTH * SCENE_HEIGHT];
    for (int i = -3; i <= 3; i++) {
        // Straight over the pole: before it on one meridian, after it on the opposite one, heading
        // carried along.
        double colat = fabs(i * 0.02);
        perigee_camera c = {.lat_deg = sign * (90 - colat),
                            .lon_deg = i <= 0 ? bearing : bearing + 180,
                            .alt_m = 12000,
                            .pitch_deg = -15,
                            .fov_deg = 60};
        c.heading_deg = (i <= 0) == (sign > 0) ? 0 : 180;
        scene_render(view, &c, SCENE_WIDTH, SCENE_HEIGHT);
        perigee_planes planes = {.z_m = z};
        assert_int_equal(perigee_view_read_planes(view, &planes), 0);
        assert_int_equal(holes(z, SCENE_WIDTH, SCENE_HEIGHT), 0);
    }
}

static void test_no_holes(void **state)
{
    (void)state;
    perigee_planet *planet = scene_planet();
    for (int texcoord = 0; texcoord < 2; texcoord++) {
        perigee_view_params params = {.texcoord_vertex = texcoord};
        perigee_view *view = scene_view(planet, &params);
        for (int b = 0; b < 4; b++) {
            cross(view, 1, b * 90 + 10);
            cross(view, -1, b * 90 + 10);
        }
        perigee_view_destroy(&view);
    }
    perigee_planet_close(&planet);
}

// At the exact pole the camera's longitude is only a way to count the heading: (90, lon, heading)
// and (90, lon + d, heading + d) are the same camera and must give the same picture (up to one step
// of the dither and rounding).
static void test_longitude_at_the_pole_is_arbitrary(void **state)
{
    (void)state;
    enum { BYTES = SCENE_WIDTH * SCENE_HEIGHT * 3 };
    static uint8_t a[BYTES], b[BYTES];
    perigee_planet *planet = scene_planet();
    perigee_view *view = scene_view(planet, NULL);
    for (int k = 1; k < 6; k++) {
        double d = 61.0 * k;
        perigee_camera c = {.lat_deg = 90,
                            .lon_deg = 0,
                            .alt_m = 15000,
                            .heading_deg = 20,
                            .pitch_deg = -25,
                            .fov_deg = 60};
        for (int i = 0; i < 2; i++) {
            assert_int_equal(perigee_view_set_camera(view, &c), 0);
            assert_int_equal(perigee_view_wait(view, SCENE_WIDTH, SCENE_HEIGHT, 60), 0);
            assert_int_equal(
                perigee_view_render_image(view, SCENE_WIDTH, SCENE_HEIGHT, 2, i ? b : a), 0);
            c.lon_deg += d;
            c.heading_deg += d;
        }
        int worst = 0, far = 0;
        for (int i = 0; i < BYTES; i++) {
            int e = abs(a[i] - b[i]);
            if (e > worst) worst = e;
            far += e > 3;
        }
        print_message("turned by %g degrees: worst difference %d, %d bytes over 3\n", d, worst,
                      far);
        assert_true(far <= BYTES / 1000);
    }
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_no_holes),
        cmocka_unit_test(test_longitude_at_the_pole_is_arbitrary),
    };
    int rc = scene_open();
    return rc ? rc : scene_close(cmocka_run_group_tests(tests, NULL, NULL));
}
