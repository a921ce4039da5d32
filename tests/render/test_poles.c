// Crossing a pole shows nothing special: no hole, no jump, whichever transform and whichever way
// the map coordinates come. Judged by the reference: geometric error and colour.
//   render_poles            a third of the scenes
//   render_poles all        all of them
//   render_poles DIR EARTH  writes DIR/seam.ppm and DIR/no-seam.ppm of the planet file EARTH
#include "render/temporal.h"

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

static bool all_scenes;

static const double ALTITUDES[3] = {9000, 60000, 400000}, PITCHES[3] = {-25, -50, -80};

static temporal_change judge(const temporal_scene *s, const perigee_camera *c)
{
    static temporal_picture seen, truth;
    temporal_see(s, c, &seen);
    temporal_see_reference(s, c, -1, &truth);
    return temporal_compare(s, c, &truth, &seen, NULL, NULL);
}

struct worst {
    temporal_change change;
    int scenes;
};

static void gather(struct worst *w, const char *name, const temporal_change *c)
{
    if (c->p999_px > w->change.p999_px || c->p999 > w->change.p999 || c->worst > w->change.worst)
        print_message("%s: %.4f %.4f %.4f px, colour %.2f %.2f %.2f, %d pixels\n", name, c->rms_px,
                      c->p999_px, c->worst_px, c->rms, c->p999, c->worst, c->compared);
    w->change.rms_px = fmax(w->change.rms_px, c->rms_px);
    w->change.p999_px = fmax(w->change.p999_px, c->p999_px);
    w->change.worst_px = fmax(w->change.worst_px, c->worst_px);
    w->change.rms = fmax(w->change.rms, c->rms);
    w->change.p999 = fmax(w->change.p999, c->p999);
    w->change.worst = fmax(w->change.worst, c->worst);
    w->scenes++;
    assert_true(c->compared > TEMPORAL_PIXELS / 20);
}

static void tell(const char *name, const struct worst *w)
{
    print_message("%s, %d scenes, worst of each: %.4f %.4f %.4f px, colour %.2f %.2f %.2f / 255\n",
                  name, w->scenes, w->change.rms_px, w->change.p999_px, w->change.worst_px,
                  w->change.rms, w->change.p999, w->change.worst);
    assert_true(w->change.worst_px <= 0.06);
}

// The light's difference from the reference's where no pole is near: the measure for those at the
// poles. (Renderer and reference take slope and convexity over lengths of their own.)
static double ordinary_rms(const temporal_scene *s, double altitude, double pitch)
{
    double worst = 0;
    for (int k = 0; k < 8; k++) {
        perigee_camera c = {.lat_deg = 14.0 * (k - 4) + 8,
                            .lon_deg = 130 * k + 10,
                            .alt_m = altitude,
                            .heading_deg = 100 * k + 30,
                            .pitch_deg = pitch,
                            .fov_deg = 60};
        worst = fmax(worst, judge(s, &c).rms);
    }
    return worst;
}

// Straight over both poles on eight bearings at three altitudes: before, exactly on and after it.
static void cross_by_reference(const char *name, bool vertex)
{
    // No ring is left out: chords, up to 0.1 px here, would hide what is looked for.
    perigee_view_params params = {.texcoord_vertex = vertex, .ring_spacing_px = -1};
    temporal_scene s = temporal_open(temporal_pebble(), false, &params);
    struct worst w = {0};
    double ordinary[3];
    for (int i = 0; i < 3; i++) ordinary[i] = ordinary_rms(&s, ALTITUDES[i], PITCHES[i]);
    print_message("far from the poles colour rms %.2f %.2f %.2f / 255\n", ordinary[0], ordinary[1],
                  ordinary[2]);
    for (int k = 0; k < 2 * 8 * 3 * 3; k++) {
        int side = k % 3, altitude = k / 3 % 3, bearing = k / 9 % 8, pole = k / 72;
        if (!all_scenes && (side + altitude + bearing + pole) % 3) continue;
        if (!all_scenes && vertex && bearing % 2) continue;
        char scene[80];
        perigee_camera c = {
            .alt_m = ALTITUDES[altitude], .pitch_deg = PITCHES[altitude], .fov_deg = 60};
        temporal_cross_pole(&c, pole ? -1 : 1, 45 * bearing + 10, 0.3 * (side - 1));
        snprintf(scene, sizeof scene, "%s, bearing %d, %g m, %+.1f degrees",
                 pole ? "south" : "north", 45 * bearing + 10, c.alt_m, 0.3 * (side - 1));
        temporal_change change = judge(&s, &c);
        gather(&w, scene, &change);
        assert_true(change.rms <= 1.5 * ordinary[altitude]);
    }
    tell(name, &w);
    temporal_close(&s);
}

static void test_crossings(void **state)
{
    (void)state;
    cross_by_reference("fragment", false);
}

static void test_crossings_by_vertex(void **state)
{
    (void)state;
    cross_by_reference("vertex", true);
}

// To the pole, stop on it, turn there in place, and leave on another meridian.
static void test_stop_and_turn(void **state)
{
    (void)state;
    perigee_view_params params = {.ring_spacing_px = -1};
    temporal_scene s = temporal_open(temporal_pebble(), false, &params);
    struct worst w = {0};
    for (int i = 0; i < (all_scenes ? 24 : 8); i++) {
        double turn = 360.0 * i / (all_scenes ? 24 : 8);
        perigee_camera c = {.lat_deg = i % 2 ? -90 : 90,
                            .lon_deg = 70,
                            .alt_m = 12000,
                            .heading_deg = turn,
                            .pitch_deg = -30,
                            .fov_deg = 60};
        char scene[80];
        snprintf(scene, sizeof scene, "at %g, heading %g", c.lat_deg, turn);
        temporal_change change = judge(&s, &c);
        gather(&w, scene, &change);
    }
    tell("turning on the pole", &w);
    assert_true(w.change.rms <= 1.5 * ordinary_rms(&s, 12000, -30));
    temporal_close(&s);
}

// What the doubled seam cures: interpolated coordinates without it go once round the planet inside
// one triangle.
static void test_seam(void **state)
{
    (void)state;
    static temporal_picture exact, with, without;
    temporal_picture *pictures[3] = {&exact, &with, &without};
    perigee_camera c = {.alt_m = 9000, .pitch_deg = -25, .fov_deg = 60};
    temporal_cross_pole(&c, 1, 10, -2);
    for (int i = 0; i < 3; i++) {
        perigee_view_params params = {.texcoord_vertex = i > 0, .seam_uncorrected = i == 2};
        temporal_scene s = temporal_open(temporal_pebble(), false, &params);
        temporal_see(&s, &c, pictures[i]);
        if (i == 2) {
            temporal_change a = temporal_compare(&s, &c, &exact, &with, NULL, NULL),
                            b = temporal_compare(&s, &c, &exact, &without, NULL, NULL);
            print_message("against coordinates by pixel: with the seam doubled %.2f %.2f %.2f, "
                          "without %.2f %.2f %.2f / 255\n",
                          a.rms, a.p999, a.worst, b.rms, b.p999, b.worst);
            assert_true(a.p999 <= 2);
            assert_true(b.worst >= 5);
        }
        temporal_close(&s);
    }
}

static void write_ppm(const char *folder, const char *name, const uint8_t *rgb, int width,
                      int height)
{
    char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    fprintf(f, "P6 %d %d 255\n", width, height);
    assert_int_equal(fwrite(rgb, 3, (size_t)width * (size_t)height, f),
                     (size_t)width * (size_t)height);
    fclose(f);
}

static void write_pictures(const char *folder, const char *earth)
{
    enum { WIDTH = 400, HEIGHT = 300 };
    static uint8_t rgb[3 * WIDTH * HEIGHT];
    perigee_camera c = {.alt_m = 1.2e6, .pitch_deg = -55, .fov_deg = 60};
    temporal_cross_pole(&c, 1, 40, -6);
    for (int i = 0; i < 2; i++) {
        perigee_view_params params = {.texcoord_vertex = true, .seam_uncorrected = i};
        temporal_scene s = temporal_open(earth, true, &params);
        assert_int_equal(perigee_view_set_camera(s.view, &c), 0);
        scene_bind(WIDTH, HEIGHT);
        assert_int_equal(perigee_view_wait(s.view, WIDTH, HEIGHT, 60), 0);
        assert_int_equal(perigee_view_render_image(s.view, WIDTH, HEIGHT, 2, rgb), 0);
        write_ppm(folder, i ? "no-seam.ppm" : "seam.ppm", rgb, WIDTH, HEIGHT);
        temporal_close(&s);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_no_holes),
        cmocka_unit_test(test_longitude_at_the_pole_is_arbitrary),
        cmocka_unit_test(test_crossings),
        cmocka_unit_test(test_crossings_by_vertex),
        cmocka_unit_test(test_stop_and_turn),
        cmocka_unit_test(test_seam),
    };
    int rc = scene_open();
    if (rc) return rc;
    all_scenes = argc == 2 && !strcmp(argv[1], "all");
    if (argc == 3) {
        write_pictures(argv[1], argv[2]);
        return scene_close(0);
    }
    return scene_close(cmocka_run_group_tests(tests, NULL, NULL));
}
