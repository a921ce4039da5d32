// What streaming costs and in which order it comes: strip areas, still viewers, coarse before fine,
// bounded staging, refused memory, shared pools, any number of threads.
#include "check.h"

#include "model.h"

static const double PI = 3.14159265358979323846;

static clipmap_params heights(int cols, int levels, size_t staging)
{
    return (clipmap_params){LAYER_HEIGHT, {288, cols, 256}, levels, 1.00336, staging, 0, false};
}

static int64_t area(window_rect r)
{
    return window_rect_empty(r) ? 0 : (r.row1 - r.row0) * (r.col1 - r.col0);
}

static void bytes_follow_the_strip_area(void **state)
{
    (void)state;
    clipmap_params p = {LAYER_HEIGHT, window_height_shape(256), 22, 1.00336, 0, 0, false};
    struct model m;
    model_init(&m, &p, 2, 64);
    struct check_random r = {3};
    double lat = 0.8, lon = 0.2, step = PI / ldexp(256, 20);
    clipmap_move(m.clipmap, lat, lon, 21);
    model_finish(&m);
    struct clipmap_counters a, b;
    clipmap_counters(m.clipmap, &a);
    assert_int_equal(a.refills, 22);
    assert_int_equal(a.samples, 22 * 336 * 512);
    for (int n = 0; n < 60; n++) {
        window was[22];
        for (int i = 0; i < 22; i++) was[i] = clipmap_level_state(m.clipmap, i).window;
        clipmap_counters(m.clipmap, &a);
        double rows = check_random_range(&r, -40, 40), cols = check_random_range(&r, -40, 40);
        lat += rows * step;
        lon += cols * step;
        clipmap_move(m.clipmap, lat, lon, 21);
        model_finish(&m);
        clipmap_counters(m.clipmap, &b);
        int64_t expected = 0;
        for (int i = 0; i < 22; i++) {
            window w = clipmap_level_state(m.clipmap, i).window;
            assert_int_equal(w.share, was[i].share);
            expected += area(w.rect) - area(window_rect_intersect(w.rect, was[i].rect));
        }
        assert_int_equal(b.samples - a.samples, expected);
        assert_int_equal(b.bytes - a.bytes, 4 * expected);
        assert_int_equal(b.refills, a.refills);
        // All levels together pay for at most twice the finest one's strips, and the rounding of
        // each.
        double finest = (fabs(rows) + 1) * 512 + (fabs(cols) + 1) * 336;
        assert_true((double)expected <= 2 * finest + 22 * (512 + 336));
    }
    model_deinit(&m);
}

static void a_still_viewer_costs_nothing(void **state)
{
    (void)state;
    clipmap_params p = heights(64, 16, 0);
    struct model m;
    model_init(&m, &p, 2, 64);
    clipmap_move(m.clipmap, 0.4, 1, 15);
    model_finish(&m);
    struct clipmap_counters a, b;
    clipmap_counters(m.clipmap, &a);
    int asked = fake_pyramid_asked(m.pyramid), missing = -1;
    for (int n = 0; n < 100; n++) {
        clipmap_move(m.clipmap, 0.4, 1, 15);
        assert_false(model_take(&m, SIZE_MAX));
        assert_false(clipmap_wait(m.clipmap, 5)); // nothing outstanding: returns at once
    }
    clipmap_counters(m.clipmap, &b);
    assert_memory_equal(&a, &b, sizeof a);
    assert_int_equal(fake_pyramid_asked(m.pyramid), asked);
    assert_true(clipmap_complete(m.clipmap, &missing));
    assert_int_equal(missing, 0);
    model_deinit(&m);
}

static uint64_t hash_after_flight(int threads)
{
    clipmap_params p = heights(128, 16, 300000);
    struct model m;
    model_init(&m, &p, threads, 8);
    for (int n = 0; n < 12; n++) {
        clipmap_move(m.clipmap, 1.2 + 0.031 * n, -3 + 0.2 * n, 15);
        if (n % 2) model_finish(&m);
        else
            while (model_take(&m, 20000)) model_upload(&m);
    }
    model_finish(&m);
    uint64_t h = model_hash(&m, 15);
    model_deinit(&m);
    return h;
}

static void threads_do_not_matter(void **state)
{
    (void)state;
    assert_int_equal(hash_after_flight(1), hash_after_flight(8));
}

static void strips_come_coarse_first(void **state)
{
    (void)state;
    clipmap_params p = heights(64, 12, 0);
    struct model m;
    model_init(&m, &p, 1, 64);
    clipmap_move(m.clipmap, 0.3, 0, 11);
    pool_drain(m.pool);
    clipmap_strip s;
    int level = 0, strips = 0, missing;
    assert_false(clipmap_complete(m.clipmap, &missing));
    for (; clipmap_next_strip(m.clipmap, SIZE_MAX, &s); strips++) {
        assert_true(s.level >= level);
        level = s.level;
        clipmap_uploaded(m.clipmap, &s);
    }
    assert_int_equal(level, 11);
    assert_int_equal(strips, missing);
    assert_true(clipmap_complete(m.clipmap, NULL));
    model_deinit(&m);
}

// Work of coarse levels that comes up while finer levels are still queued goes before theirs.
static void coarse_latecomers_go_first(void **state)
{
    (void)state;
    clipmap_params p = heights(64, 12, 0);
    struct model m;
    model_init(&m, &p, 1, 64);
    double lat = 0.3, step = PI / ldexp(256, 5); // of level 6
    clipmap_move(m.clipmap, lat, 0, 6);
    model_finish(&m);
    fake_pyramid_slow(m.pyramid, 2000);
    clipmap_move(m.clipmap, lat, 0, 11);
    clipmap_move(m.clipmap, lat + 1.5 * step, 0, 11); // level 11 by 48 rows: its plan goes on
    clipmap_strip s;
    assert_true(clipmap_wait(m.clipmap, 10));
    pool_drain(m.pool);
    assert_true(clipmap_next_strip(m.clipmap, SIZE_MAX, &s));
    assert_true(s.level <= 6);
    clipmap_uploaded(m.clipmap, &s);
    for (int level = s.level; clipmap_next_strip(m.clipmap, SIZE_MAX, &s); level = s.level) {
        assert_true(s.level >= level);
        clipmap_uploaded(m.clipmap, &s);
        pool_drain(m.pool);
    }
    model_deinit(&m);
}

// The finest window moves on by more than itself every frame and the budget is small: the levels
// whose windows move slowly become complete all the same, and in order.
static void fast_flight_does_not_starve_coarse_levels(void **state)
{
    (void)state;
    clipmap_params p = heights(64, 16, 200000);
    struct model m;
    model_init(&m, &p, 2, 64);
    double lat = -0.5;
    for (int n = 0; n < 150; n++) {
        lat += 400 * PI / ldexp(256, 14);
        clipmap_move(m.clipmap, lat, 0.1, 15);
        clipmap_wait(m.clipmap, 0.01);
        for (size_t left = 40000; model_take(&m, left);) {
            left -= m.pending[(m.first + m.count - 1) % MODEL_PENDING].bytes;
            model_upload(&m);
        }
        if (n % 30 == 0) model_check(&m);
    }
    for (int i = 0; i < 6; i++) {
        window_rect v = clipmap_level_state(m.clipmap, i).valid;
        assert_true(area(v) > 288 * 64 * 8 / 10);
    }
    model_finish(&m);
    model_check(&m);
    model_deinit(&m);
}

static void a_slow_source_never_blocks_the_viewer(void **state)
{
    (void)state;
    clipmap_params p = heights(64, 16, 0);
    struct model m;
    model_init(&m, &p, 2, 64);
    fake_pyramid_slow(m.pyramid, 3000);
    for (int n = 0; n < 200; n++) {
        clipmap_move(m.clipmap, -1.5 + 0.01 * n, 0.1 * n, 15);
        while (model_take(&m, 20000)) model_upload(&m);
    }
    // 200 frames need some thousand tiles: with 3 ms each on two workers they were not waited for.
    assert_true(fake_pyramid_asked(m.pyramid) < 2000);
    model_check(&m);
    model_deinit(&m); // with work under way
}

static void refused_memory_is_tried_again(void **state)
{
    (void)state;
    clipmap_params p = heights(64, 6, 0);
    struct model m;
    model_init(&m, &p, 2, 64);
    fake_pyramid_refuse(m.pyramid, 1 << 30);
    clipmap_move(m.clipmap, 0.3, 0, 5);
    assert_false(clipmap_wait(m.clipmap, 0.1));
    int missing;
    assert_false(clipmap_complete(m.clipmap, &missing));
    assert_true(missing >= 6);
    fake_pyramid_refuse(m.pyramid, 3);
    for (int n = 0; n < 10; n++) {
        clipmap_move(m.clipmap, 0.3, 0, 5);
        while (clipmap_wait(m.clipmap, 0.05))
            while (model_take(&m, SIZE_MAX)) model_upload(&m);
    }
    assert_true(clipmap_complete(m.clipmap, NULL));
    model_check(&m);
    model_deinit(&m);
}

static void two_clipmaps_share_a_small_pool(void **state)
{
    (void)state;
    clipmap_params p = heights(64, 12, 0);
    struct model a, b;
    model_init(&a, &p, 2, 1);
    model_init(&b, &p, 1, 1);
    clipmap_destroy(&b.clipmap);
    assert_int_equal(clipmap_create(b.pyramid, a.pool, &p, &b.clipmap), OK);
    for (int n = 0; n < 10; n++) {
        clipmap_move(a.clipmap, 0.3 + 0.1 * n, 0, 11);
        clipmap_move(b.clipmap, -0.3 - 0.1 * n, 1, 11);
        model_finish(&a);
        model_finish(&b);
    }
    model_check(&a);
    model_check(&b);
    clipmap_destroy(&b.clipmap);
    model_deinit(&a);
    model_deinit(&b);
}

static void states_before_the_first_move(void **state)
{
    (void)state;
    clipmap_params p = heights(64, 4, 0);
    struct model m;
    model_init(&m, &p, 1, 4);
    clipmap_level s = clipmap_level_state(m.clipmap, 3);
    assert_false(s.complete);
    assert_true(window_rect_empty(s.valid) && s.min > s.max);
    assert_false(model_take(&m, SIZE_MAX));
    assert_false(clipmap_wait(m.clipmap, 1));
    model_deinit(&m);
    clipmap_destroy(&m.clipmap); // NULL-safe
}

static void levels_not_wanted_are_left_alone(void **state)
{
    (void)state;
    clipmap_params p = heights(64, 12, 0);
    struct model m;
    model_init(&m, &p, 2, 64);
    clipmap_move(m.clipmap, 0.3, 0, 5);
    model_finish(&m);
    assert_true(clipmap_level_state(m.clipmap, 5).complete);
    for (int i = 6; i < 12; i++)
        assert_true(window_rect_empty(clipmap_level_state(m.clipmap, i).valid));
    clipmap_move(m.clipmap, 0.3, 0, 99); // no more than there are
    model_finish(&m);
    clipmap_move(m.clipmap, 0.3, 0, 2);
    assert_true(clipmap_complete(m.clipmap, NULL));
    assert_true(clipmap_level_state(m.clipmap, 11).complete);
    model_check(&m);
    model_deinit(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bytes_follow_the_strip_area),
        cmocka_unit_test(a_still_viewer_costs_nothing),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(strips_come_coarse_first),
        cmocka_unit_test(coarse_latecomers_go_first),
        cmocka_unit_test(fast_flight_does_not_starve_coarse_levels),
        cmocka_unit_test(a_slow_source_never_blocks_the_viewer),
        cmocka_unit_test(refused_memory_is_tried_again),
        cmocka_unit_test(two_clipmaps_share_a_small_pool),
        cmocka_unit_test(states_before_the_first_move),
        cmocka_unit_test(levels_not_wanted_are_left_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
