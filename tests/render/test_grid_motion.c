// The persistent grid in motion: its vertices stay on the screen and slide over the ground, so a
// fixed point of it is drawn now from this triangle, now from that, of finer or coarser heights. By
// how much is it off, and by how much does that change from frame to frame? Bounds are two to three
// times what was measured (tests/ACCURACY-geometries.md, which says what makes it fail).
// And does anything jump where vertices change their level?
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

// Straight down in equal small shares of the height, so that the distances of the vertices, and
// with them their levels, pass whole numbers row by row. What moves evenly cancels in the second
// difference of a pixel's distance; what jumps stays, however small the steps. In heights of a
// pixel.
enum { ROWS = 30, COLUMNS = 40, FRAMES = 100 };

#define STEP (1.0 / 400) // of a doubling

static int compare_double(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static size_t add_jumps(const temporal_picture *a, const temporal_picture *b,
                        const temporal_picture *c, double pixels, double *out)
{
    size_t n = 0;
    for (int k = 0; k < TEMPORAL_PIXELS; k++) {
        double jump = log((double)a->z[k]) - 2 * log((double)b->z[k]) + log((double)c->z[k]);
        if (!isnan(jump)) out[n++] = pixels * fabs(jump);
    }
    return n;
}

static void levels_change_unseen(double above, double pitch, bool farthest)
{
    const perigee_view_params params = {.mode = PERIGEE_MODE_GRID,
                                        .grid_rows = ROWS,
                                        .grid_columns = COLUMNS,
                                        .grid_farthest = farthest};
    static temporal_picture seen[3];
    temporal_scene s = temporal_open(temporal_rough(), false, &params);
    perigee_camera c = {
        .lat_deg = 31, .lon_deg = 12, .heading_deg = 20, .pitch_deg = pitch, .fov_deg = 60};
    double ground = temporal_ground(&s, c.lat_deg, c.lon_deg),
           pixels = TEMPORAL_HEIGHT / (2 * tan(c.fov_deg * RAD / 2));
    double *jumps = malloc((size_t)FRAMES * TEMPORAL_PIXELS * sizeof *jumps);
    size_t n = 0;
    assert_non_null(jumps);
    for (int i = 0; i < FRAMES; i++) {
        c.alt_m = ground + above * exp2(-i * STEP);
        temporal_see(&s, &c, &seen[i % 3]);
        if (i > 1)
            n += add_jumps(&seen[(i - 2) % 3], &seen[(i - 1) % 3], &seen[i % 3], pixels, jumps + n);
    }
    assert_true(n == (size_t)(FRAMES - 2) * TEMPORAL_PIXELS);
    qsort(jumps, n, sizeof *jumps, compare_double);
    double most = jumps[n - 1], p999 = jumps[(size_t)(0.999 * (double)n)];
    free(jumps);
    print_message("%s, down from %.0f m: jumps by %.4f px (99.9 %%), %.4f at most\n",
                  farthest ? "farthest" : "mean", above, p999, most);
    assert_true(p999 <= 0.0016);
    assert_true(most <= 0.006);
    temporal_close(&s);
}

static void test_levels_change(void **state)
{
    (void)state;
    for (int farthest = 0; farthest < 2; farthest++) {
        levels_change_unseen(1e6, -90, farthest);
        levels_change_unseen(5e5, -80, farthest);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_farthest), cmocka_unit_test(test_mean),
                                       cmocka_unit_test(test_levels_change)};
    int rc = scene_open();
    return rc ? rc : scene_close(cmocka_run_group_tests(tests, NULL, NULL));
}
