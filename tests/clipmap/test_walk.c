// Random walks of the viewer, with strips taken and uploaded in random portions: after every step
// each sample that a third of the levels, in turn, call valid is what recomputing it from nothing
// gives; at the end each sample of all levels.
#include "check.h"

#include "model.h"

enum { STEPS = 300 };

static const double PI = 3.14159265358979323846;

struct viewer {
    double lat, lon;
};

// Goes on along the great circle, over the poles.
static void walk(struct viewer *v, double north, double east)
{
    v->lat += north;
    v->lon += east;
    if (fabs(v->lat) > PI / 2) {
        v->lat = copysign(PI, v->lat) - v->lat;
        v->lon += PI;
    }
    if (v->lon > PI) v->lon -= 2 * PI;
    if (v->lon < -PI) v->lon += 2 * PI;
}

// A new leg of the walk every so often: how far one step goes, and sometimes a jump to a place of
// interest.
static double new_leg(struct viewer *v, struct check_random *r, int levels)
{
    switch (check_random_u64(r) % 8) {
    case 0:
        *v = (struct viewer){copysign(PI / 2, check_random_range(r, -1, 1)), 0.3};
        break;
    case 1:
        *v = (struct viewer){check_random_range(r, -1.5, 1.5), PI};
        break;
    case 2:
        *v = (struct viewer){check_random_range(r, -1.57, 1.57), check_random_range(r, -PI, PI)};
        break;
    case 3:
        v->lat = 1.0 + check_random_range(r, 0, 0.1);
        break; // where shares change
    default:
        break;
    }
    // A fraction of a sample up to a few windows, of any level.
    double step = ldexp(PI / 256, -(int)(check_random_u64(r) % (uint64_t)levels));
    return step * pow(10, check_random_range(r, -1, 2.5));
}

static void random_walk_of(const clipmap_params *params, uint64_t seed, int threads, int steps,
                           bool recasts)
{
    struct check_random r = {seed};
    struct model m;
    model_init(&m, params, threads, 3);
    if (recasts) model_recast(&m);
    struct viewer v = {0.5, 3.1};
    double leg = 0, bearing = 0;
    int64_t looked_at = 0;
    int finished = 0;
    for (int n = 0; n < steps; n++) {
        if (n % 20 == 0) {
            leg = new_leg(&v, &r, params->levels);
            bearing = check_random_range(&r, 0, 2 * PI);
        }
        walk(&v, leg * cos(bearing), leg * sin(bearing));
        int last = params->levels - 1 - (int)(check_random_u64(&r) % 16 == 0) * 3;
        while (recasts && model_upload(&m)) continue;
        clipmap_move(m.clipmap, v.lat, v.lon, last);
        if (check_random_u64(&r) % 2) clipmap_wait(m.clipmap, 0.01);
        int takes = (int)(check_random_u64(&r) % 30);
        for (int i = 0; i < takes; i++) {
            size_t budget = 1 + check_random_u64(&r) % 60000;
            if (check_random_u64(&r) % 3) model_take(&m, budget);
            else model_upload(&m);
        }
        if (check_random_u64(&r) % 12 == 0) {
            model_finish(&m);
            finished++;
        }
        looked_at += model_check_third(&m, n);
    }
    model_finish(&m);
    model_check(&m);
    struct clipmap_counters c;
    clipmap_counters(m.clipmap, &c);
    print_message("%d steps, %d completed, %lld valid samples checked; %.2f came as "
                  "residuals; %d recasts\n",
                  steps, finished, (long long)looked_at, (double)c.residuals / (double)c.samples,
                  m.recasts);
    assert_true(looked_at > 0 && finished > 0);
    // Of noise they fit only while the quanta are wide.
    assert_true(!params->residuals || c.residuals > c.samples / 10);
    assert_true(!recasts || m.recasts > 0);
    model_deinit(&m);
}

static void random_walk(const clipmap_params *params, uint64_t seed, int threads, int steps)
{
    random_walk_of(params, seed, threads, steps, false);
}

static clipmap_params heights(int cols, int levels, size_t staging)
{
    return (clipmap_params){LAYER_HEIGHT, {288, cols, 256}, levels, 1.00336, staging, 0, false};
}

static void small_windows(void **state)
{
    (void)state;
    clipmap_params p = heights(64, 10, (size_t)1 << 20);
    for (uint64_t seed = 1; seed <= 4; seed++) random_walk(&p, seed, 2, STEPS);
}

static void tight_staging(void **state)
{
    (void)state;
    clipmap_params p = heights(64, 8, 9000); // a few short strips
    random_walk(&p, 4, 2, STEPS / 2);
    p.staging_bytes = 256; // one row
    random_walk(&p, 5, 2, STEPS / 4);
}

static void real_windows(void **state)
{
    (void)state;
    clipmap_params p = {LAYER_HEIGHT, window_height_shape(256), 22, 1.00336, 0, 0, false};
    random_walk(&p, 6, 8, STEPS / 10);
}

static void residuals(void **state)
{
    (void)state;
    clipmap_params p = heights(64, 10, (size_t)1 << 20);
    p.residuals = true;
    for (uint64_t seed = 8; seed <= 10; seed++) random_walk(&p, seed, 2, STEPS);
    p.staging_bytes = 256;
    random_walk(&p, 11, 2, STEPS / 4);
}

static void colors(void **state)
{
    (void)state;
    clipmap_params p = {LAYER_COLOR, {288, 128, 256}, 6, 1.00336, (size_t)1 << 20, 0, false};
    random_walk(&p, 7, 2, STEPS / 4);
}

// The same walks where shares change in place.
static void recasts(void **state)
{
    (void)state;
    clipmap_params p = heights(64, 10, (size_t)1 << 20);
    for (uint64_t seed = 12; seed <= 13; seed++) random_walk_of(&p, seed, 2, STEPS, true);
    p.residuals = true;
    random_walk_of(&p, 14, 2, STEPS, true);
}

// Over a latitude where a share changes, and back: with nothing uploaded, as much is valid as the
// ring needs, on all rows; then the level is filled in place.
static void a_share_changes(struct model *m, int level, double lat, int64_t half_cols)
{
    int64_t cols = m->params.shape.cols;
    struct clipmap_counters before, after;
    model_finish(m);
    clipmap_counters(m->clipmap, &before);
    int share = clipmap_level_state(m->clipmap, level).held.share, recast = m->recasts;
    clipmap_move(m->clipmap, lat, 0.3, level);
    clipmap_level s = clipmap_level_state(m->clipmap, level);
    assert_int_equal(abs(s.window.share - share), 1);
    assert_int_equal(s.held.share, s.window.share);
    assert_true(m->recasts > recast && !s.complete);
    assert_int_equal(s.valid.row1 - s.valid.row0, m->params.shape.rows);
    assert_true(s.valid.col0 <= s.window.rect.col0 + cols / 2 - half_cols);
    assert_true(s.valid.col1 >= s.window.rect.col0 + cols / 2 + half_cols);
    model_check(m);
    model_finish(m);
    model_check(m);
    clipmap_counters(m->clipmap, &after);
    assert_int_equal(after.refills, before.refills);
    assert_true(clipmap_level_state(m->clipmap, level).complete);
}

static void shares_change_in_place(void **state)
{
    (void)state;
    enum { LEVEL = 8 };
    clipmap_params p = heights(64, LEVEL + 1, 0);
    struct model m;
    double low = 0.9, high = 1.2; // 64 columns halve once more between
    int share = window_at(&p.shape, LEVEL, low, 0.3, p.ring_bound).share;
    assert_int_equal(window_at(&p.shape, LEVEL, high, 0.3, p.ring_bound).share, share - 1);
    while (high - low > 1e-9) {
        double middle = 0.5 * (low + high);
        if (window_at(&p.shape, LEVEL, middle, 0.3, p.ring_bound).share == share) low = middle;
        else high = middle;
    }
    model_init(&m, &p, 2, 64);
    model_recast(&m);
    clipmap_move(m.clipmap, low, 0.3, LEVEL);
    a_share_changes(&m, LEVEL, high, p.shape.cols / 4 - 1);
    a_share_changes(&m, LEVEL, low, p.shape.cols / 2);
    model_deinit(&m);
}

// A slow flight over the north pole and on, one or two samples of the finest level a step: nothing
// is refilled but by a change of the share, and the finest levels hold the whole circle around the
// pole.
static void pole_crossing(void **state)
{
    (void)state;
    clipmap_params p = heights(64, 12, 0);
    struct model m;
    model_init(&m, &p, 2, 64);
    double step = PI / (256 << 10);
    struct viewer v = {PI / 2 - 100.25 * step, 2.0};
    clipmap_move(m.clipmap, v.lat, v.lon, 11);
    model_finish(&m);
    struct clipmap_counters before, after;
    clipmap_counters(m.clipmap, &before);
    for (int n = 0; n < 200; n++) {
        walk(&v, n < 100 ? step : -step, 0);
        clipmap_move(m.clipmap, v.lat, v.lon, 11);
        model_finish(&m);
        if (n % 10 == 0) model_check(&m);
        assert_int_equal(clipmap_level_state(m.clipmap, 11).window.share, 0);
    }
    clipmap_counters(m.clipmap, &after);
    assert_int_equal(after.refills, before.refills);
    // The window of the finest level stands still within 128 rows of the pole: there is nothing to
    // upload.
    assert_int_equal(after.bytes, before.bytes);
    model_deinit(&m);
}

static void antimeridian_crossing(void **state)
{
    (void)state;
    clipmap_params p = heights(64, 10, 0);
    struct model m;
    model_init(&m, &p, 2, 64);
    double step = 2 * PI / (64 << 8);
    struct viewer v = {0.2, PI - 20.3 * step};
    clipmap_move(m.clipmap, v.lat, v.lon, 9);
    model_finish(&m);
    struct clipmap_counters before, after;
    clipmap_counters(m.clipmap, &before);
    for (int n = 0; n < 80; n++) {
        walk(&v, 0, n < 40 ? step : -step);
        clipmap_move(m.clipmap, v.lat, v.lon, 9);
        if (n % 3) model_finish(&m);
        model_check(&m);
    }
    model_finish(&m);
    model_check(&m);
    clipmap_counters(m.clipmap, &after);
    assert_int_equal(after.refills, before.refills);
    model_deinit(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(small_windows),
        cmocka_unit_test(tight_staging),
        cmocka_unit_test(real_windows),
        cmocka_unit_test(residuals),
        cmocka_unit_test(colors),
        cmocka_unit_test(recasts),
        cmocka_unit_test(shares_change_in_place),
        cmocka_unit_test(pole_crossing),
        cmocka_unit_test(antimeridian_crossing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
