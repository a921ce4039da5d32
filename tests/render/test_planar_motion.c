// Geometry clipmaps in motion: nothing jumps where a square moves on or the finest level changes,
// frames are the same whatever path led there, and the terrain is at its place. Bounds are two to
// three times what was measured (tests/ACCURACY-geometries.md).
#include "render/temporal.h"

#include "geo/nest.h"
#include "gpu/gpu_fixture.h"

static const double RAD = M_PI / 180;

static const perigee_view_params PLANAR = {
    .mode = PERIGEE_MODE_PLANAR, .texels = 256, .planar_n = 255};

static void show(const char *name, const temporal_change *c)
{
    print_message("%-34s: %.4f %.4f %.4f px, colour %.3f / 255, %d pixels\n", name, c->rms_px,
                  c->p999_px, c->worst_px, c->rms, c->compared);
}

// The latitude at which a level's square moves by two rows, nearest to one given.
static double latitude_of_move(int level, double lat)
{
    nest_square s = nest_square_at(255, level, lat, 0);
    return M_PI / 2 - 2 * floor((M_PI / 2 - lat) / (2 * s.step)) * s.step;
}

// From one side of a move to the other, a tenth of a millimetre on the ground. At a move of level l
// all finer ones move as well: the largest change in one frame that a flight can have.
static void test_squares_move_unseen(void **state)
{
    (void)state;
    static temporal_picture a, b;
    temporal_scene s = temporal_open(temporal_rough(), true, &PLANAR);
    for (int level = 4; level <= 19; level += 3) {
        double lat = latitude_of_move(level, 31 * RAD), side = 6378137 * 2 * M_PI / (1 << level);
        perigee_camera c = {.lat_deg = (lat - 1e-11) / RAD,
                            .lon_deg = 12,
                            .heading_deg = 40,
                            .pitch_deg = -20,
                            .fov_deg = 60};
        assert_true(nest_square_at(255, level, lat - 1e-11, 0).row !=
                    nest_square_at(255, level, lat + 1e-11, 0).row);
        c.alt_m = temporal_ground(&s, c.lat_deg, c.lon_deg) + side / 12;
        temporal_see(&s, &c, &a);
        c.lat_deg = (lat + 1e-11) / RAD;
        temporal_see(&s, &c, &b);
        temporal_change change = temporal_compare(&s, &c, &a, &b, NULL, NULL);
        char name[64];
        snprintf(name, sizeof name, "square of level %d moves", level);
        show(name, &change);
        assert_true(change.compared > TEMPORAL_PIXELS / 8);
        assert_true(change.p999_px <= 0.0012 + 2 * gpu_fixture_snap_px());
        assert_true(change.rms_px <= 0.004); // a single pixel at an edge of the relief may flip
        assert_true(change.rms <= 0.05);
    }
    temporal_close(&s);
}

// Where the finest level, or the coarsest, changes.
static void test_levels_come_unseen(void **state)
{
    (void)state;
    static temporal_picture a, b;
    temporal_scene s = temporal_open(temporal_rough(), true, &PLANAR);
    perigee_camera c = {
        .lat_deg = 31, .lon_deg = 12, .heading_deg = 40, .pitch_deg = -65, .fov_deg = 60};
    double ground = temporal_ground(&s, c.lat_deg, c.lon_deg);
    for (int level = 5; level <= 20; level += 5) {
        double low = 1, high = 4e7;
        perigee_stats stats;
        while (high / low - 1 > 1e-7) {
            double middle = sqrt(low * high);
            c.alt_m = ground + middle;
            scene_bind(TEMPORAL_WIDTH, TEMPORAL_HEIGHT);
            assert_int_equal(perigee_view_set_camera(s.view, &c), 0);
            assert_int_equal(perigee_view_render(s.view, TEMPORAL_WIDTH, TEMPORAL_HEIGHT), 0);
            perigee_view_get_stats(s.view, &stats);
            if ((int)stats.last_level >= level) low = middle;
            else high = middle;
        }
        c.alt_m = ground + high;
        int above = temporal_see(&s, &c, &a);
        c.alt_m = ground + low;
        assert_int_equal(temporal_see(&s, &c, &b), above + 1);
        temporal_change change = temporal_compare(&s, &c, &a, &b, NULL, NULL);
        char name[64];
        snprintf(name, sizeof name, "level %d to %d at %.4g m", above, above + 1, low);
        show(name, &change);
        assert_true(change.p999_px <= 0.0015);
        assert_true(change.rms_px <= 0.004);
        assert_true(change.rms <= 0.03);
    }
    temporal_close(&s);
}

// Over plains and up: the same camera by two paths, and by another view.
static void test_path_leaves_no_trace(void **state)
{
    (void)state;
    static temporal_picture a, b;
    temporal_scene s = temporal_open(temporal_rough(), true, &PLANAR);
    perigee_camera c = {.lat_deg = -44,
                        .lon_deg = 179.99,
                        .heading_deg = 80,
                        .pitch_deg = -15,
                        .fov_deg = 70},
                   away = c;
    c.alt_m = temporal_ground(&s, c.lat_deg, c.lon_deg) + 300;
    temporal_see(&s, &c, &a);
    for (int i = 1; i < 6; i++) {
        away.lat_deg = c.lat_deg + 0.001 * i;
        away.lon_deg = c.lon_deg + 0.003 * i;
        away.alt_m = c.alt_m + 80 * i;
        temporal_see(&s, &away, &b);
    }
    temporal_see(&s, &c, &b);
    for (int k = 0; k < TEMPORAL_PIXELS; k++) {
        bool same =
            memcmp(&a.z[k], &b.z[k], sizeof a.z[k]) == 0 || (isnan(a.z[k]) && isnan(b.z[k]));
        if (!same) fail_msg("pixel %d: %.9g m, and %.9g m after a detour", k, a.z[k], b.z[k]);
    }
    temporal_close(&s);
}

// Against the ray caster over the same heights, mid latitudes from the ground and the air.
static void test_terrain_is_at_its_place(void **state)
{
    (void)state;
    static temporal_picture truth, seen;
    const struct {
        double lat, above, pitch, rms, p999;
    } views[] = {{20, 150, -10, 0.005, 0.01},
                 {-50, 3000, -20, 0.0002, 0.0005},
                 {0.01, 40000, -40, 0.0005, 0.001},
                 {40, 3e6, -90, 0.004, 0.02}};
    temporal_scene s = temporal_open(temporal_analytic(), false, &PLANAR);
    for (int i = 0; i < 4; i++) {
        perigee_camera c = {.lat_deg = views[i].lat,
                            .lon_deg = -77,
                            .heading_deg = 200,
                            .pitch_deg = views[i].pitch,
                            .fov_deg = 60};
        c.alt_m = temporal_ground(&s, c.lat_deg, c.lon_deg) + views[i].above;
        temporal_see(&s, &c, &seen);
        temporal_see_reference(&s, &c, -1, &truth);
        temporal_change change = temporal_compare(&s, &c, &truth, &seen, NULL, NULL);
        char name[64];
        snprintf(name, sizeof name, "%g N, %g m above ground", views[i].lat, views[i].above);
        show(name, &change);
        assert_true(change.rms_px <= views[i].rms + gpu_fixture_snap_px());
        assert_true(change.p999_px <= views[i].p999 + gpu_fixture_snap_px());
        assert_true(change.compared > TEMPORAL_PIXELS / 8);
    }
    temporal_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_squares_move_unseen),
        cmocka_unit_test(test_levels_come_unseen),
        cmocka_unit_test(test_path_leaves_no_trace),
        cmocka_unit_test(test_terrain_is_at_its_place),
    };
    int rc = scene_open();
    return rc ? rc : scene_close(cmocka_run_group_tests(tests, NULL, NULL));
}
