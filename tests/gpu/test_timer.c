// Pass times: unknown at first, right in proportion, inside the wall clock, and read without a
// wait.
#include "check.h"

#include <stdbool.h>

#include "gpu/busy.h"
#include "gpu/gpu_fixture.h"
#include "gpu/timer.h"

enum { HEAVY_MS = 40, SHARE = 4, FRAMES = 8, RUNS = 3 };
enum { LIGHT = 0, HEAVY = 3, UNUSED = GPU_TIMER_PASSES - 1 };

struct times {
    double light, heavy, frame, longest_reading; // ms
};

// A light and a heavy pass, each into its own framebuffer, as passes of a frame are.
static struct times run_frames(const struct busy *a, const struct busy *b, int rounds)
{
    struct times times = {0};
    struct gpu_timer *t = gpu_timer_create();
    for (int frame = 0; frame < FRAMES; frame++) {
        assert_true(gpu_timer_ms(t, UNUSED) < 0);
        if (frame < 2) assert_true(gpu_timer_ms(t, LIGHT) < 0 && gpu_timer_ms(t, HEAVY) < 0);
        double start = busy_now_ms();
        gpu_timer_begin(t, LIGHT);
        busy_draw(a, rounds / SHARE);
        gpu_timer_end(t, LIGHT);
        gpu_timer_begin(t, HEAVY);
        busy_draw(b, rounds);
        gpu_timer_end(t, HEAVY);
        double before = busy_now_ms();
        gpu_timer_frame(t);
        times.longest_reading = fmax(times.longest_reading, busy_now_ms() - before);
        glFinish();
        times.frame = fmax(times.frame, busy_now_ms() - start);
    }
    times.light = gpu_timer_ms(t, LIGHT);
    times.heavy = gpu_timer_ms(t, HEAVY);
    gpu_timer_destroy(&t);
    assert_null(t);
    gpu_timer_destroy(&t);
    return times;
}

// The heavy pass has four times the light one's work, so it takes longer: all that is asked of a
// time. One of three runs must show it, for a busy machine may hold up another.
static void test_times(void **state)
{
    (void)state;
    struct busy a, b;
    assert_int_equal(busy_init(&a), OK);
    assert_int_equal(busy_init(&b), OK);
    int rounds = busy_rounds(&b, HEAVY_MS);
    bool right = false;
    for (int i = 0; i < RUNS && !right; i++) {
        struct times t = run_frames(&a, &b, rounds);
        print_message("light %.2f ms, heavy %.2f ms, longest frame %.2f ms, reading %.3f ms\n",
                      t.light, t.heavy, t.frame, t.longest_reading);
        right = t.light > 0 && t.heavy > t.light;
    }
    assert_true(right);
    busy_deinit(&a);
    busy_deinit(&b);
}

// Frames nobody waits for: slots come round before their results, which are dropped and never
// waited for.
static void test_frames_in_flight(void **state)
{
    (void)state;
    struct gpu_timer *t = gpu_timer_create();
    for (int frame = 0; frame < 100; frame++) {
        for (int pass = 0; pass < GPU_TIMER_PASSES; pass++) {
            gpu_timer_begin(t, pass);
            gpu_timer_end(t, pass);
        }
        gpu_timer_frame(t);
    }
    glFinish();
    gpu_timer_frame(t);
    for (int pass = 0; pass < GPU_TIMER_PASSES; pass++)
        assert_true(gpu_timer_ms(t, pass) >= 0 && gpu_timer_ms(t, pass) < 1000);
    gpu_timer_destroy(&t);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_times),
        cmocka_unit_test(test_frames_in_flight),
    };
    int rc = gpu_fixture_open();
    if (rc) return rc;
    return gpu_fixture_close(cmocka_run_group_tests(tests, NULL, NULL));
}
