// Too much to do in a frame: the budget of samples is kept, fine levels yield and come back, the
// coarse ones are always there, and nothing is asked for that would come too late to be seen.
#include "check.h"

#include <unistd.h>

#include "model.h"

static const double PI = 3.14159265358979323846;

enum { LEVELS = 16, WINDOW = 288 * 512 };

static clipmap_params params(size_t samples_frame)
{
    return (clipmap_params){LAYER_HEIGHT, {288, 512, 256}, LEVELS, 1.00336, 0, samples_frame,
                            false};
}

static int finest_of(uint32_t levels)
{
    int first = 0;
    while (first < LEVELS && !(levels >> first & 1)) first++;
    return first;
}

// One frame with workers that are done at once: what is not there is the budget's doing.
static struct clipmap_counters frame(struct model *m, double lat, double lon)
{
    clipmap_move(m->clipmap, lat, lon, LEVELS - 1);
    pool_drain(m->pool);
    clipmap_begin_frame(m->clipmap, false);
    while (model_take(m, SIZE_MAX)) {
        model_upload(m);
        pool_drain(m->pool);
    }
    struct clipmap_counters c;
    clipmap_counters(m->clipmap, &c);
    return c;
}

// A flight that gets faster until the finest window is left behind in every frame many times over,
// and then stands still.
static void fine_levels_yield_and_come_back(void **state)
{
    (void)state;
    enum { FRAMES = 120 };
    const size_t budgets[] = {WINDOW, WINDOW / 4};
    for (int b = 0; b < 2; b++) {
        clipmap_params p = params(b ? budgets[b] : 0);
        struct model m;
        model_init(&m, &p, 1, 64);
        double lat = -0.6, row = PI / ldexp(256, LEVELS - 2);
        for (int i = 0; i < 100; i++) frame(&m, lat, 0.1);
        assert_true(clipmap_complete(m.clipmap, NULL));
        struct clipmap_counters before, c = {0};
        clipmap_counters(m.clipmap, &before);
        int first_yielding = LEVELS, late_coarse = 0;
        for (int n = 0; n < FRAMES; n++) {
            double speed = 0.5 * exp2(14.0 * n / FRAMES); // rows of the finest
            lat += speed * row;
            c = frame(&m, lat, 0.1);
            assert_true(c.frame_samples <= budgets[b]);
            int first = finest_of(c.yielded);
            // All finer ones yield too.
            assert_int_equal(c.yielded, ((uint32_t)1 << LEVELS) - ((uint32_t)1 << first));
            if (n < 10) assert_int_equal(c.yielded, 0);
            first_yielding = first < first_yielding ? first : first_yielding;
            for (int i = 0; i < 4; i++) late_coarse += !clipmap_level_state(m.clipmap, i).complete;
            if (n % 20 == 0) model_check_third(&m, n / 20);
        }
        assert_true(first_yielding > 3 && first_yielding < LEVELS - 4);
        assert_int_equal(late_coarse, 0);
        int frames = 0;
        while (!clipmap_complete(m.clipmap, NULL) && frames < 300) {
            c = frame(&m, lat, 0.1);
            assert_true(c.frame_samples <= budgets[b]);
            frames++;
        }
        c = frame(&m, lat, 0.1);
        assert_int_equal(c.yielded, 0);
        clipmap_counters(m.clipmap, &c);
        print_message("budget %zu: at most %llu samples a frame; levels from %d on yielded; "
                      "complete %d frames after\n",
                      budgets[b], (unsigned long long)c.most_frame_samples, first_yielding, frames);
        assert_true(c.most_frame_samples <= budgets[b]);
        // Each level anew at the most, and some frames in which rows did not fill the budget.
        assert_true(frames <= (int)((LEVELS - first_yielding + 1) * WINDOW / budgets[b]) + 8);
        model_check(&m);
        model_deinit(&m);
    }
}

// Speed that all the levels can follow makes none of them yield.
static void a_calm_flight_yields_nothing(void **state)
{
    (void)state;
    clipmap_params p = params(0);
    struct model m;
    model_init(&m, &p, 2, 64);
    double lat = 0.4, row = PI / ldexp(256, LEVELS - 2);
    for (int i = 0; i < 40; i++) frame(&m, lat, 1);
    for (int n = 0; n < 60; n++) {
        struct clipmap_counters c = frame(&m, lat += 30 * row, 1);
        assert_int_equal(c.yielded, 0);
        assert_true(clipmap_complete(m.clipmap, NULL));
    }
    model_deinit(&m);
}

// A step over half the planet is no flight: the place arrived at is asked for in the same frame.
static void a_jump_is_no_flight(void **state)
{
    (void)state;
    clipmap_params p = params(0);
    struct model m;
    int stale;
    model_init(&m, &p, 2, 64);
    for (int i = 0; i < 40; i++) frame(&m, 0.4, 1);
    fake_pyramid_late(m.pyramid);
    clipmap_move(m.clipmap, -0.7, 2.9, LEVELS - 1);
    pool_drain(m.pool);
    int asked = fake_pyramid_under_way(m.pyramid, &stale);
    print_message("%d tiles asked for by a jump\n", asked);
    assert_true(asked >= 2 * (LEVELS - 4));
    model_deinit(&m);
}

// Does a tile overlap the window of a level of its zoom? By longitudes and latitudes alone.
static bool overlaps(tile_id id, const window *w, const window_shape *shape)
{
    if (id.zoom != w->zoom) return false;
    int64_t row0 = (int64_t)id.row * TILE_SIZE, rows = (int64_t)TILE_SIZE * grid_rows(id.zoom);
    double west = 2 * PI * id.col / grid_cols(id.zoom, id.row) - PI;
    double east = 2 * PI * (id.col + 1) / grid_cols(id.zoom, id.row) - PI;
    double step = window_step_lon(shape, w);
    double left = (double)w->rect.col0 * step - PI, right = (double)w->rect.col1 * step - PI;
    if (w->rect.row0 < 0 || w->rect.row1 > rows) return true; // beyond a pole: of no interest here
    if (row0 >= w->rect.row1 || row0 + TILE_SIZE <= w->rect.row0) return false;
    for (int turn = -2; turn <= 2; turn++) // a column more on each side: interpolation
        if (west + 2 * PI * turn < right + step && east + 2 * PI * turn > left - step) return true;
    return false;
}

static int stale_in_flight(const struct model *m, const struct fake_traffic *t)
{
    int stale = 0;
    for (int k = 0; k < t->flying_count; k++) {
        bool useful = false;
        for (int i = 0; i < LEVELS && !useful; i++) {
            clipmap_level s = clipmap_level_state(m->clipmap, i);
            useful = overlaps(t->flying[k], &s.window, &m->params.shape);
        }
        stale += !useful;
    }
    return stale;
}

static void slow_frame(struct model *m, const struct fake_line *line, struct fake_traffic *t,
                       double lat, double lon)
{
    clipmap_move(m->clipmap, lat, lon, LEVELS - 1);
    pool_drain(m->pool);
    fake_pyramid_tick(m->pyramid, line, t);
    clipmap_begin_frame(m->clipmap, false);
    while (model_take(m, SIZE_MAX)) {
        model_upload(m);
        pool_drain(m->pool);
    }
}

struct turn {
    int stale, flying; // of all frames but the first after the turn
    int frames, came;  // until all is complete
};

// Tiles take 8 frames. In the midst of asking for one side of the planet, a turn to the other. What
// is in flight is judged by its place.
static struct turn turn_round(bool first_come)
{
    const struct fake_line line = {12, 8, first_come};
    clipmap_params p = params(0);
    struct turn r = {0};
    struct fake_traffic t = {0};
    struct model m;
    model_init(&m, &p, 1, 64);
    fake_pyramid_late(m.pyramid);
    for (int n = 0; n < 20; n++) slow_frame(&m, &line, &t, -0.9, 0.1);
    assert_true(t.flying_count == line.slots);
    t = (struct fake_traffic){0};
    while (!clipmap_complete(m.clipmap, NULL) || r.frames == 0) {
        slow_frame(&m, &line, &t, 0.5, -2.6);
        if (r.frames++ > 0) r.stale += stale_in_flight(&m, &t), r.flying += t.flying_count;
        assert_true(r.frames < 3000);
    }
    r.came = t.came;
    model_check(&m);
    model_deinit(&m);
    return r;
}

static void after_a_turn_nothing_stale_is_under_way(void **state)
{
    (void)state;
    struct turn queue = turn_round(true), ours = turn_round(false);
    print_message("after a turn: of what is in flight %.1f %% are stale, complete after %d frames "
                  "and %d tiles; first come, first served: %.1f %%, %d frames, %d tiles\n",
                  100.0 * ours.stale / ours.flying, ours.frames, ours.came,
                  100.0 * queue.stale / queue.flying, queue.frames, queue.came);
    assert_true(10 * ours.stale <= ours.flying);
    assert_true(10 * queue.stale > queue.flying); // the measure sees what is stale
    assert_true(ours.frames < queue.frames);
}

// Faster than tiles of the fine levels can come: the coarse levels are there in every frame, and
// hardly a tile is fetched in vain, because levels that are outrun are not asked for.
static void in_a_fast_flight_the_coarse_levels_are_there(void **state)
{
    (void)state;
    const struct fake_line line = {12, 8, false};
    clipmap_params p = params(0);
    struct fake_traffic t = {0};
    struct model m;
    model_init(&m, &p, 1, 64);
    fake_pyramid_late(m.pyramid);
    double lat = -0.19, row = PI / ldexp(256, LEVELS - 2);
    for (int n = 0; n < 600; n++) slow_frame(&m, &line, &t, lat, 0.1);
    assert_true(clipmap_complete(m.clipmap, NULL));
    int finest = LEVELS;
    uint32_t yielded = 0;
    for (int n = 0; n < 250; n++) {
        lat += fmin(n, 50) * 40 * row; // up to 7 windows of the finest level a frame
        if (n == 100) t = (struct fake_traffic){0};
        slow_frame(&m, &line, &t, lat, 0.1);
        struct clipmap_counters c;
        clipmap_counters(m.clipmap, &c);
        yielded |= c.yielded;
        int valid = 0;
        while (valid < LEVELS) {
            clipmap_level s = clipmap_level_state(m.clipmap, valid);
            if (window_rect_empty(s.valid) ||
                2 * (s.valid.row1 - s.valid.row0) < s.window.rect.row1 - s.window.rect.row0)
                break;
            valid++;
        }
        finest = valid < finest ? valid : finest;
    }
    print_message("fast flight: levels 0 to %d always there, from %d on yielded; of %d tiles %d "
                  "came in vain, %d were stopped\n",
                  finest - 1, finest_of(yielded), t.came, t.in_vain, t.stopped);
    assert_true(finest >= 6);
    assert_true(finest_of(yielded) < LEVELS);
    assert_true(5 * (t.in_vain + t.stopped) <= t.came);
    for (int n = 0; n < 600 && !clipmap_complete(m.clipmap, NULL); n++)
        slow_frame(&m, &line, &t, lat, 0.1);
    assert_true(clipmap_complete(m.clipmap, NULL)); // and all comes back
    model_check(&m);
    model_deinit(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fine_levels_yield_and_come_back),
        cmocka_unit_test(a_calm_flight_yields_nothing),
        cmocka_unit_test(a_jump_is_no_flight),
        cmocka_unit_test(after_a_turn_nothing_stale_is_under_way),
        cmocka_unit_test(in_a_fast_flight_the_coarse_levels_are_there),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
