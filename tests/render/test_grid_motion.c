// The persistent grid in motion: its vertices stay on the screen and slide over the ground, so a
// fixed point of it is drawn now from this triangle, now from that, of finer or coarser heights. By
// how much is it off, and by how much does that change from frame to frame? Bounds are two to three
// times what was measured (tests/ACCURACY-geometries.md, which says what makes it fail).
#include "render/temporal.h"
#include "gpu/gpu_fixture.h"

static const double RAD = M_PI / 180;

enum { ACROSS = 20, DOWN = 10, POINTS = ACROSS * DOWN, STEPS = 4 };

struct point {
    double lat, lon, height, before; // before: deviation in the last frame
};

struct swim {
    double sum, worst, jump_sum, jump;
    int count, jumps;
};

static temporal_picture frame;

// Points of the ground under a grid of pixels.
static void lay_points(const temporal_scene *s, const perigee_camera *c, struct point p[POINTS])
{
    static double lat[TEMPORAL_PIXELS], lon[TEMPORAL_PIXELS];
    perigee_planes planes = {.lat_deg = lat, .lon_deg = lon};
    temporal_see(s, c, &frame);
    assert_int_equal(perigee_view_read_planes(s->view, &planes), 0);
    for (int i = 0; i < POINTS; i++) {
        int x = (i % ACROSS + 1) * TEMPORAL_WIDTH / (ACROSS + 1),
            y = (i / ACROSS + 1) * TEMPORAL_HEIGHT / (DOWN + 1), k = y * TEMPORAL_WIDTH + x;
        p[i] = (struct point){NAN, NAN, NAN, NAN};
        if (isnan(frame.z[k])) continue;
        p[i].lat = lat[k] * RAD;
        p[i].lon = lon[k] * RAD;
        p[i].height = temporal_ground(s, lat[k], lon[k]);
    }
}

static void follow(const temporal_scene *s, const perigee_camera *c, struct point p[POINTS],
                   struct swim *w)
{
    temporal_see(s, c, &frame);
    for (int i = 0; i < POINTS; i++) {
        if (isnan(p[i].height)) continue;
        double off = temporal_deviation(s, c, &frame, p[i].lat, p[i].lon, p[i].height);
        if (!isnan(off)) {
            w->sum += off * off;
            w->worst = fmax(w->worst, fabs(off));
            w->count++;
        }
        double jump = fabs(off - p[i].before);
        if (!isnan(jump)) {
            w->jump_sum += jump * jump;
            w->jump = fmax(w->jump, jump);
            w->jumps++;
        }
        p[i].before = off;
    }
}

static const struct walk {
    double above, step, pitch, fov; // m, m, deg
} walks[] = {{300000, 500, -30, 60}, {30000, 60, -25, 60}, {100000, 30, -20, 8}};

static void points_stay(bool mean)
{
    const perigee_view_params params = {.mode = PERIGEE_MODE_GRID, .grid_farthest = !mean};
    const double snap = 2 * gpu_fixture_snap_px();
    temporal_scene s = temporal_open(temporal_rough(), false, &params);
    for (size_t f = 0; f < sizeof walks / sizeof *walks; f++) {
        struct point p[POINTS];
        struct swim w = {0};
        perigee_camera c = {.lat_deg = 31,
                            .lon_deg = 12,
                            .heading_deg = 20,
                            .pitch_deg = walks[f].pitch,
                            .fov_deg = walks[f].fov};
        c.alt_m = temporal_ground(&s, c.lat_deg, c.lon_deg) + walks[f].above;
        lay_points(&s, &c, p);
        for (int i = 0; i < STEPS; i++, c.lat_deg += walks[f].step / s.ellipsoid.a / RAD)
            follow(&s, &c, p, &w);
        double off = sqrt(w.sum / w.count), jump = sqrt(w.jump_sum / w.jumps);
        print_message("%s, %6.0f m, %2.0f degrees: off by %.4f rms, %.4f px at most (%d); moves by "
                      "%.4f rms, %.4f px at most (%d)\n",
                      mean ? "mean" : "farthest", walks[f].above, walks[f].fov, off, w.worst,
                      w.count, jump, w.jump, w.jumps);
        assert_true(w.count > POINTS);
        assert_true(off <= 0.002);
        assert_true(w.worst <= 0.015);
        assert_true(jump <= 0.0005 + snap);
        assert_true(w.jump <= 0.0025 + snap);
    }
    temporal_close(&s);
}

static void test_farthest(void **state)
{
    (void)state;
    points_stay(false);
}

static void test_mean(void **state)
{
    (void)state;
    points_stay(true);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_farthest),
                                       cmocka_unit_test(test_mean)};
    int rc = scene_open();
    return rc ? rc : scene_close(cmocka_run_group_tests(tests, NULL, NULL));
}
