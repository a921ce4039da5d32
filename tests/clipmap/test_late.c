// Tiles that come late: nothing waits for them, what a turn made useless is given up, coarse levels
// are asked for first, and what lies ahead before what lies behind.
#include "check.h"

#include <unistd.h>

#include "model.h"

static const clipmap_params PARAMS = {LAYER_HEIGHT, {288, 512, 256}, 12, 1.00336, 0, 0, false};

// Frames until the workers have asked for all they can.
static void settle(struct model *m, double lat, double lon, int last)
{
    struct clipmap_counters c;
    for (int same = 0, before = -1; same < 3;) {
        clipmap_move(m->clipmap, lat, lon, last);
        pool_drain(m->pool);
        while (model_take(m, SIZE_MAX)) model_upload(m);
        clipmap_counters(m->clipmap, &c);
        same = c.waiting == before ? same + 1 : 0;
        before = c.waiting;
    }
}

static void late_tiles_complete_the_windows(void **state)
{
    (void)state;
    struct model m;
    int stale, steps = 0;
    model_init(&m, &PARAMS, 2, 64);
    fake_pyramid_late(m.pyramid);
    settle(&m, 0.8, 0.2, 11);
    assert_false(clipmap_complete(m.clipmap, NULL));
    assert_true(fake_pyramid_under_way(m.pyramid, &stale) > 20);
    assert_int_equal(stale, 0);
    while (!clipmap_complete(m.clipmap, NULL) && steps++ < 2000) {
        fake_pyramid_deliver(m.pyramid, 3);
        clipmap_move(m.clipmap, 0.8, 0.2, 11);
        clipmap_wait(m.clipmap, 0.02);
        while (model_take(&m, SIZE_MAX)) model_upload(&m);
        model_check_third(&m, steps);
    }
    assert_true(clipmap_complete(m.clipmap, NULL));
    model_check(&m);
    model_deinit(&m);
}

static void coarse_levels_come_first(void **state)
{
    (void)state;
    struct model m;
    model_init(&m, &PARAMS, 2, 64);
    fake_pyramid_late(m.pyramid);
    bool complete[12] = {false};
    for (int steps = 0; steps < 3000 && !complete[11]; steps++) {
        fake_pyramid_deliver(m.pyramid, 1);
        clipmap_move(m.clipmap, 0.8, 0.2, 11);
        clipmap_wait(m.clipmap, 0.01);
        while (model_take(&m, SIZE_MAX)) model_upload(&m);
        for (int i = 0; i < 12; i++) {
            complete[i] = clipmap_level_state(m.clipmap, i).complete;
            if (i > 0 && complete[i]) assert_true(complete[i - 1]);
        }
    }
    assert_true(complete[11]);
    model_deinit(&m);
}

// After a turn at most 10 % of what is in flight is stale.
static void a_turn_gives_up_what_is_stale(void **state)
{
    (void)state;
    struct model m;
    int stale;
    model_init(&m, &PARAMS, 2, 64);
    fake_pyramid_late(m.pyramid);
    settle(&m, 0.8, 0.2, 11);
    int before = fake_pyramid_under_way(m.pyramid, &stale);
    clipmap_move(m.clipmap, -0.5, 2.5, 11); // the other side of the world
    fake_pyramid_under_way(m.pyramid, &stale);
    print_message("of %d tiles under way %d are given up by a turn\n", before, stale);
    // Levels 0 and 1 hold the whole circle and stay.
    assert_true(stale * 10 >= before * 6);
    settle(&m, -0.5, 2.5, 11);
    int wanted = fake_pyramid_deliver(m.pyramid, 1 << 20);
    settle(&m, -0.5, 2.5, 11);
    while (fake_pyramid_deliver(m.pyramid, 1 << 20)) settle(&m, -0.5, 2.5, 11);
    assert_true(wanted > 20);
    assert_true(clipmap_complete(m.clipmap, NULL));
    model_check(&m);
    model_deinit(&m);
}

// Frames of a still viewer until nothing stands in any more.
static void recover(struct model *m)
{
    int frames = 0;
    while (clipmap_provisional(m->clipmap)) {
        assert_true(frames++ < 30000);
        clipmap_begin_frame(m->clipmap, false);
        while (model_take(m, SIZE_MAX)) assert_true(m->pending[m->first].again), model_upload(m);
        assert_true(clipmap_complete(m->clipmap, NULL)); // all is valid all the time
        usleep(200);
    }
}

static void check_stand_ins(const clipmap_params *params)
{
    struct model m;
    struct clipmap_counters before, after;
    model_init(&m, params, 2, 64);
    clipmap_move(m.clipmap, 0.8, 0.2, 11);
    model_finish(&m);
    uint64_t right = model_hash(&m, 11);
    assert_false(clipmap_provisional(m.clipmap));
    model_deinit(&m);
    model_init(&m, params, 2, 64);
    fake_pyramid_stand_in(m.pyramid, true);
    clipmap_move(m.clipmap, 0.8, 0.2, 11);
    model_finish(&m);
    assert_true(clipmap_provisional(m.clipmap));
    assert_true(model_hash(&m, 11) != right);
    fake_pyramid_stand_in(m.pyramid, false);
    recover(&m);
    assert_true(model_hash(&m, 11) == right);
    model_check(&m);
    // What has no stand-ins is left alone, and a part of it that a move brought is known.
    clipmap_counters(m.clipmap, &before);
    for (int i = 0; i < 10; i++) {
        clipmap_begin_frame(m.clipmap, false);
        assert_false(model_take(&m, SIZE_MAX));
    }
    fake_pyramid_stand_in(m.pyramid, true);
    clipmap_move(m.clipmap, 0.8001, 0.2, 11);
    model_finish(&m);
    assert_true(clipmap_provisional(m.clipmap));
    fake_pyramid_stand_in(m.pyramid, false);
    recover(&m);
    model_check(&m);
    clipmap_counters(m.clipmap, &after);
    assert_int_equal(after.refills, before.refills); // no level is emptied for it
    model_deinit(&m);
}

static void stand_ins_are_filled_again(void **state)
{
    (void)state;
    check_stand_ins(&PARAMS);
}

// A source that goes on failing, whose stand-ins are given up at once: coarse levels are not filled
// again and again before the finest has come.
static void stand_ins_let_what_is_missing_come(void **state)
{
    (void)state;
    struct model m;
    int64_t again[CLIPMAP_MAX_LEVELS] = {0};
    const int64_t texels = (int64_t)PARAMS.shape.rows * PARAMS.shape.cols;
    model_init(&m, &PARAMS, 2, 64);
    fake_pyramid_stand_in(m.pyramid, true);
    clipmap_move(m.clipmap, 0.8, 0.2, 11);
    for (int frame = 0; frame < 30000 && !clipmap_complete(m.clipmap, NULL); frame++) {
        clipmap_begin_frame(m.clipmap, false);
        while (!clipmap_complete(m.clipmap, NULL) && model_take(&m, SIZE_MAX)) {
            const clipmap_strip *s = &m.pending[m.first];
            if (s->again) again[s->level] += (int64_t)s->rows * s->cols;
            assert_true(again[s->level] <= texels);
            model_upload(&m);
        }
        usleep(200);
    }
    assert_true(clipmap_complete(m.clipmap, NULL));
    model_deinit(&m);
}

// Residuals, which the model adds up, are of what will stand: with parents that stand in for it, in
// the texture or on the worker, there are none.
static void stand_ins_have_no_residuals(void **state)
{
    (void)state;
    clipmap_params p = PARAMS;
    p.residuals = true;
    check_stand_ins(&p);
    for (int first = 0; first < 2; first++) {
        struct model m;
        model_init(&m, &p, 2, 64);
        fake_pyramid_stand_in(m.pyramid, first == 0);
        clipmap_move(m.clipmap, 0.8, 0.2, 8);
        model_finish(&m);
        fake_pyramid_stand_in(m.pyramid, first == 1);
        clipmap_move(m.clipmap, 0.83, 0.2, 8); // a few samples of each level
        model_finish(&m);
        model_deinit(&m);
    }
}

// Dropping everything while tiles are on their way.
static void destroyed_with_tiles_under_way(void **state)
{
    (void)state;
    struct model m;
    int stale;
    model_init(&m, &PARAMS, 2, 64);
    fake_pyramid_late(m.pyramid);
    clipmap_move(m.clipmap, 0.8, 0.2, 11);
    usleep(3000);
    clipmap_destroy(&m.clipmap);
    int count = fake_pyramid_under_way(m.pyramid, &stale);
    assert_int_equal(stale, count);
    model_deinit(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(late_tiles_complete_the_windows),
        cmocka_unit_test(coarse_levels_come_first),
        cmocka_unit_test(a_turn_gives_up_what_is_stale),
        cmocka_unit_test(stand_ins_are_filled_again),
        cmocka_unit_test(stand_ins_let_what_is_missing_come),
        cmocka_unit_test(stand_ins_have_no_residuals),
        cmocka_unit_test(destroyed_with_tiles_under_way),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
