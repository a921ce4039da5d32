// A server that was sick in one run and is healthy in the next: nothing of the sickness is left in
// the cache on disk, and what was good before is not lost by it.
#include "fault_server.h"
#include "check.h"

#include <unistd.h>

#include "base/log.h"
#include "planet/source_set.h"

static const char *const CACHE = "repair-tiles.db";

static int lines;

static void count_line(void *user, enum log_level level, const char *line)
{
    (void)user;
    (void)line;
    lines += level <= LOG_WARN;
}

static void forget_all(void)
{
    static const char *const parts[] = {"", "-wal", "-shm", "-journal"};
    char path[64];
    for (int i = 0; i < 4; i++) {
        snprintf(path, sizeof path, "%s%s", CACHE, parts[i]);
        unlink(path);
    }
}

// The red of two tiles, as one run sees them: the server's X and level stand in its tiles' colours.
struct seen {
    int left, right;
    struct fetch_counters net;
    uint64_t cache_bytes;
};

static struct seen run_once(void)
{
    struct seen r;
    int *red[2] = {&r.left, &r.right};
    struct pyramid *p;
    source_set_params params = {.disk_path = CACHE, .fetch = {.timeout_s = 5}};
    pyramid_params tiles = {.cache_bytes = 16 << 20};
    struct source_set *set = source_set_create(&params);
    assert_int_equal(source_set_add(set, fault_url("/sick/{z}/{x}/{y}"), LAYER_COLOR, 1), OK);
    assert_int_equal(source_set_pyramid(set, &tiles, &p), OK);
    for (int i = 0; i < 2; i++) {
        const pyramid_tile *tile;
        assert_int_equal(pyramid_acquire(p, (tile_id){LAYER_COLOR, 4, 7, 21 + i}, &tile), OK);
        *red[i] = tile->rgba[0] == 50 ? tile->rgba[1] : -tile->rgba[0];
        pyramid_release(p, &tile);
    }
    struct pyramid_counters c;
    pyramid_counters(p, &c);
    r.cache_bytes = c.cache_bytes;
    fetch_counters(source_set_fetcher(set), &r.net);
    pyramid_destroy(&p);
    source_set_destroy(&set);
    return r;
}

enum { BARE = -156 };

static const char *const SICK[] = {"status/500", "status/503", "status/403", "short", "huge",
                                   "html",       "size",       "bomb",       "cut",   "down"};

static void a_sick_run_leaves_nothing_behind(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof SICK / sizeof *SICK; i++) {
        forget_all();
        lines = 0;
        fault_server_down(1);
        fault_server_sick(SICK[i]);
        struct seen sick = run_once();
        if (sick.left != BARE || sick.right != BARE || lines < 1 || lines > 2)
            fail_msg("%s: saw %d, %d and said %d lines", SICK[i], sick.left, sick.right, lines);
        assert_true(sick.net.memory_bytes < 1 << 20);
        assert_true(sick.cache_bytes <= 16 << 20);
        fault_server_sick("ok");
        struct seen healthy = run_once();
        if (healthy.left != 21 || healthy.right != 22)
            fail_msg("healthy after %s: saw %d, %d", SICK[i], healthy.left, healthy.right);
    }
    forget_all();
}

static void what_was_good_outlives_a_sick_server(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof SICK / sizeof *SICK; i++) {
        forget_all();
        fault_server_sick("ok");
        assert_int_equal(run_once().left, 21);
        fault_server_sick(SICK[i]);
        struct seen sick = run_once();
        if (sick.left != 21 || sick.right != 22 || sick.net.started)
            fail_msg("%s: saw %d, %d", SICK[i], sick.left, sick.right);
    }
    forget_all();
}

int main(void)
{
    log_set_sink(count_line, NULL);
    fault_server_start(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_sick_run_leaves_nothing_behind),
        cmocka_unit_test(what_was_good_outlives_a_sick_server),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    fault_server_stop();
    return failed;
}
