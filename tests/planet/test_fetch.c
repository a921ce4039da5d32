// The fetcher and the remote source against a server that misbehaves in every way it knows.
#include "fault_server.h"
#include "check.h"

#include <unistd.h>

#include "base/clock.h"
#include "base/log.h"
#include "planet/fetch.h"
#include "planet/pyramid.h"
#include "planet/source_remote.h"
#include "planet/source_set.h"

static char last[1024];
static int lines;

static void keep_line(void *user, enum log_level level, const char *line)
{
    (void)user;
    if (level > LOG_WARN) return;
    lines++;
    snprintf(last, sizeof last, "%s", line);
}

static status get(struct fetcher *f, const char *path, size_t *size)
{
    const fetch_body *body;
    status s = fetch_wait(f, fault_url(path), 1 << 20, 20, &body);
    if (!s) *size = body->size;
    if (!s) fetch_release(f, &body);
    return s;
}

static struct fetcher *fetcher(void)
{
    fetch_params params = {.timeout_s = 5};
    return fetcher_create(&params);
}

static void answers(void **state)
{
    (void)state;
    static const struct {
        const char *path;
        status want;
        int asked; // times
    } cases[] = {
        {"/ok/1/2/3", OK, 1},
        {"/ok/1/2/3", OK, 1}, // from memory
        {"/to/ok/1/2/3", OK, 2},
        {"/status/404/1", ERR_NOT_FOUND, 1},
        {"/status/410/1", ERR_NOT_FOUND, 1},
        {"/status/204/1", ERR_NOT_FOUND, 1},
        {"/status/403/1", ERR_FORMAT, 1},
        {"/status/304/1", ERR_FORMAT, 1},
        {"/huge/1", ERR_FORMAT, 1},
        {"/endless/1", ERR_FORMAT, 1},
        {"/to/file/1", ERR_FORMAT, 1},
        {"/to/ftp/1", ERR_FORMAT, 1},
        {"/loop/1", ERR_FORMAT, 5},
        {"/flaky/2/1/2/3", OK, 3},
        {"/status/500/1", ERR_IO, 4},
        {"/short/1", ERR_IO, 4},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char part[32];
        size_t size;
        struct fetcher *f = fetcher();
        snprintf(part, sizeof part, "%s", cases[i].path + 1);
        *strchr(part, '/') = '\0';
        int before = fault_server_seen(part) + fault_server_seen("ok") * (part[0] == 't');
        status s = get(f, cases[i].path, &size);
        if (s != cases[i].want) fail_msg("%s: %s", cases[i].path, status_text(s));
        if (!s) s = get(f, cases[i].path, &size);
        int after = fault_server_seen(part) + fault_server_seen("ok") * (part[0] == 't');
        if (after - before != cases[i].asked)
            fail_msg("%s: asked %d times", cases[i].path, after - before);
        fetcher_destroy(&f);
    }
}

// Nothing but http and https is spoken, whoever asks.
static void other_schemes_are_refused(void **state)
{
    (void)state;
    static const char *const urls[] = {"file:///etc/hostname", "ftp://127.0.0.1/x",
                                       "gopher://127.0.0.1/x", "dict://127.0.0.1/x"};
    for (size_t i = 0; i < sizeof urls / sizeof *urls; i++) {
        struct fetcher *f = fetcher();
        const fetch_body *body;
        lines = 0;
        assert_int_equal(fetch_wait(f, urls[i], 1 << 20, 20, &body), ERR_FORMAT);
        assert_int_equal(lines, 1);
        assert_non_null(strstr(last, urls[i]));
        fetcher_destroy(&f);
    }
}

// Between tries are pauses that grow: 1/4 s, 1/2 s, 1 s at least. A busy machine makes them longer.
static void pauses_grow(void **state)
{
    (void)state;
    static const int least_ms[] = {250, 500, 1000};
    struct fetcher *f = fetcher();
    size_t size;
    assert_int_equal(get(f, "/status/502/1", &size), ERR_IO);
    for (int i = 0; i < 3; i++) {
        int pause = fault_server_pause("/status/502/1", i);
        print_message("pause %d: %d ms\n", i, pause);
        assert_true(pause >= least_ms[i]);
    }
    assert_int_equal(fault_server_pause("/status/502/1", 3), -1);
    fetcher_destroy(&f);
}

// A server that takes the question and says nothing is not waited for.
static void silence_ends(void **state)
{
    (void)state;
    fetch_params params = {.timeout_s = 0.3};
    struct fetcher *f = fetcher_create(&params);
    size_t size;
    int before = fault_server_seen("slow");
    assert_int_equal(get(f, "/slow/20000/1/2/3", &size), ERR_IO);
    assert_int_equal(fault_server_seen("slow") - before, 4);
    fetcher_destroy(&f);
}

// Documents too are read up to a bound.
static void a_document_that_is_too_large(void **state)
{
    (void)state;
    source_set_params none = {0};
    struct source_set *set = source_set_create(&none);
    lines = 0;
    assert_int_equal(source_set_add(set, fault_url("/endless/planet.json"), LAYER_COUNT, 1),
                     ERR_FORMAT);
    assert_true(lines > 0 && lines <= 2);
    assert_non_null(strstr(last, "/endless/planet.json: refused"));
    source_set_destroy(&set);
}

// Retry-After: nothing is asked of the server before.
static void retry_after_is_kept(void **state)
{
    (void)state;
    struct fetcher *f = fetcher();
    size_t size;
    double start = clock_now_s();
    assert_int_equal(get(f, "/busy/2/1/5/6/7", &size), OK);
    assert_true(clock_now_s() - start >= 1.9);
    assert_int_equal(fault_server_seen("busy"), 2);
    fetcher_destroy(&f);
}

// What is old on disk is asked for by its tag or its date; "the same" brings no body, and the one
// on disk is given.
static void the_same_as_before(void **state)
{
    (void)state;
    static const char *const kinds[] = {"tag", "dated"};
    char dir[] = "fetch-XXXXXX", path[64], command[64];
    assert_non_null(mkdtemp(dir));
    snprintf(path, sizeof path, "%s/tiles.db", dir);
    for (int i = 0; i < 6; i++) {
        static size_t sizes[6];
        char what[32];
        struct disk_cache *disk;
        struct fetch_counters c;
        assert_int_equal(disk_cache_open(path, 1 << 20, &disk), OK);
        fetch_params params = {.timeout_s = 5, .disk = disk};
        struct fetcher *f = fetcher_create(&params);
        snprintf(what, sizeof what, "/%s/4/5/6", kinds[i / 3]);
        assert_int_equal(get(f, what, &sizes[i]), OK);
        assert_int_equal(sizes[i], sizes[0]);
        fetch_counters(f, &c);
        assert_int_equal(c.started, 1);
        assert_int_equal(c.same, i % 3 > 0);
        assert_true(i % 3 == 0 || c.bytes == 0);
        fetcher_destroy(&f);
        disk_cache_close(&disk);
        assert_int_equal(fault_server_seen(kinds[i / 3]), i % 3 + 1);
    }
    snprintf(command, sizeof command, "rm -r %s", dir);
    assert_int_equal(system(command), 0);
}

// A body in compressed form is not unpacked beyond the bound; wrong bodies are refused once and not
// fetched again.
static void bodies_that_are_no_tiles(void **state)
{
    (void)state;
    static const struct {
        const char *kind, *said;
    } cases[] = {{"html", "no JPEG, PNG or WebP"},
                 {"size", "512 x 512 pixels"},
                 {"bomb", "60000 x 60000 pixels"},
                 {"cut", "a broken PNG"}};
    for (int i = 0; i < 4; i++) {
        char url[256];
        source_spec spec;
        struct source *source;
        struct pyramid *p;
        struct fetcher *f = fetcher();
        snprintf(url, sizeof url, "%s%s/{z}/{x}/{y}", fault_url("/"), cases[i].kind);
        assert_int_equal(source_spec_of_template(url, LAYER_COLOR, &spec), OK);
        assert_int_equal(source_remote_open_take(&spec, f, &source), OK);
        pyramid_layer layer = {source, 1};
        pyramid_params params = {0};
        assert_int_equal(pyramid_create_stack(&layer, 1, &params, &p), OK);
        const pyramid_tile *tile;
        lines = 0;
        for (int again = 0; again < 2; again++)
            for (int col = 0; col < 4; col++) {
                tile_id id = {LAYER_COLOR, 1, 0, col};
                assert_int_equal(pyramid_acquire(p, id, &tile), OK);
                assert_int_equal(tile->rgba[0], 156); // bare ground
                pyramid_release(p, &tile);
            }
        assert_int_equal(lines, 1); // told once for a server
        if (!strstr(last, cases[i].said)) fail_msg("%s: said \"%s\"", cases[i].kind, last);
        struct fetch_counters c;
        fetch_counters(f, &c);
        assert_true(c.refused > 3);
        assert_int_equal((int)c.started, fault_server_seen(cases[i].kind));
        pyramid_destroy(&p);
        source_close(&source);
        fetcher_destroy(&f);
    }
}

// The place of every tile: its colour says which it is.
static void tiles_come_from_their_place(void **state)
{
    (void)state;
    source_spec spec;
    struct source *source;
    struct fetcher *f = fetcher();
    uint8_t *rgba = malloc(TILE_SIZE * TILE_SIZE * 4);
    assert_int_equal(source_spec_of_template(fault_url("/ok/{z}/{x}/{y}"), LAYER_COLOR, &spec), OK);
    assert_int_equal(source_remote_open_take(&spec, f, &source), OK);
    tile_id id = {LAYER_COLOR, 4, 7, 21}; // just north of the equator: level 5
    struct want *want = want_create(0);
    double until;
    while (source_read(source, id, want, rgba, &until) == ERR_PENDING) want_wait(want, 5);
    assert_int_equal(rgba[0], 50);
    assert_int_equal(rgba[1], 21);
    // Rows of the planet's 7th tile from the north end at the equator, as do Mercator's of y 15.
    assert_int_equal(rgba[4 * (TILE_SIZE * TILE_SIZE - 1) + 2], 15);
    want_release(&want);
    free(rgba);
    source_close(&source);
    fetcher_destroy(&f);
}

// Both codes of heights: 100 m a level of the server.
static void heights_of_both_codes(void **state)
{
    (void)state;
    static const char *const codes[][2] = {{"height", "terrarium"}, {"rgb", "terrain-rgb"}};
    float *heights = malloc(TILE_SIZE * TILE_SIZE * sizeof *heights);
    for (int i = 0; i < 2; i++) {
        char text[512], path[64];
        source_spec spec;
        struct source *source;
        struct fetcher *f = fetcher();
        snprintf(path, sizeof path, "/%s/", codes[i][0]);
        snprintf(text, sizeof text, "{\"tiles\":[\"%s{z}/{x}/{y}\"],\"encoding\":\"%s\"}",
                 fault_url(path), codes[i][1]);
        assert_int_equal(source_spec_parse(text, strlen(text), "test", &spec), OK);
        assert_int_equal(source_remote_open_take(&spec, f, &source), OK);
        tile_id id = {LAYER_HEIGHT, 4, 7, 21}; // of level 5, as above
        struct want *want = want_create(0);
        double until;
        while (source_read(source, id, want, heights, &until) == ERR_PENDING) want_wait(want, 5);
        for (int k = 0; k < TILE_SIZE * TILE_SIZE; k++) check_near(heights[k], 500, 1e-3);
        want_release(&want);
        source_close(&source);
        fetcher_destroy(&f);
    }
    free(heights);
}

// At most `in_flight` at once, and most wanted first.
static void in_flight_is_bounded(void **state)
{
    (void)state;
    enum { COUNT = 60 };
    fetch_params params = {.in_flight = 5, .per_host = 5};
    struct fetcher *f = fetcher_create(&params);
    struct want *wants[COUNT];
    const fetch_body *body;
    struct fetch_counters c;
    double until, done[COUNT] = {0};
    char path[64];
    for (int i = 0; i < COUNT; i++) {
        wants[i] = want_create(COUNT - i); // the last one is wanted most
        snprintf(path, sizeof path, "/slow/30/9/%d/9", i);
        assert_int_equal(fetch_get(f, fault_url(path), 1 << 20, wants[i], &body, &until),
                         ERR_PENDING);
    }
    for (int left = COUNT; left;) {
        left = 0;
        for (int i = 0; i < COUNT; i++) {
            left += !want_ready(wants[i]);
            if (want_ready(wants[i]) && done[i] == 0) done[i] = clock_now_s();
        }
        usleep(1000);
    }
    fetch_counters(f, &c);
    assert_true(c.most_in_flight <= 5);
    assert_true(fault_server_most() <= 5);
    // The few that were asked for first may have started before there was a choice.
    double wanted_most = 0, wanted_least = 0;
    for (int i = 0; i < COUNT / 2; i++) {
        wanted_least += done[i];
        wanted_most += done[COUNT - 1 - i];
    }
    assert_true(wanted_most < wanted_least - 0.1 * COUNT / 2);
    for (int i = 0; i < COUNT; i++) want_release(&wants[i]);
    fetcher_destroy(&f);
}

// What nobody wants any more is stopped, in line and in flight.
static void cancelled_transfers_stop(void **state)
{
    (void)state;
    enum { COUNT = 100 };
    struct fetcher *f = fetcher_create(&(fetch_params){.per_host = 32});
    const fetch_body *body;
    struct fetch_counters c;
    double until;
    char path[64];
    struct want *old = want_create(0), *new = want_create(0);
    for (int i = 0; i < COUNT; i++) {
        snprintf(path, sizeof path, "/slow/2000/8/%d/8", i);
        fetch_get(f, fault_url(path), 1 << 20, old, &body, &until);
    }
    clock_sleep_s(0.2);
    fetch_counters(f, &c);
    assert_int_equal(c.in_flight, 32);
    want_release(&old);
    for (int i = 0; i < 10; i++) {
        snprintf(path, sizeof path, "/ok/7/%d/7", i);
        fetch_get(f, fault_url(path), 1 << 20, new, &body, &until);
    }
    clock_sleep_s(0.05); // three frames
    fetch_counters(f, &c);
    assert_int_equal(c.stale, 0);
    assert_true(c.cancelled >= 30);
    assert_true(want_wait(new, 5));

    want_release(&new);
    fetcher_destroy(&f);
}

// A server that is down is left alone, told once, and found again.
static void a_dead_server_is_left_alone_and_found_again(void **state)
{
    (void)state;
    struct fetcher *f = fetcher();
    size_t size;
    char path[64];
    lines = 0;
    fault_server_down(1);
    int before = fault_server_seen("down");
    double start = clock_now_s();
    struct want *want = want_create(0);
    for (int i = 0; i < 10000; i++) {
        const fetch_body *body;
        double until;
        snprintf(path, sizeof path, "/down/9/%d/1", i);
        fetch_get(f, fault_url(path), 1 << 20, want, &body, &until);
    }
    assert_true(want_wait(want, 60));
    struct fetch_counters c;
    fetch_counters(f, &c);
    print_message("10,000 dead tiles: %.2f s, %d requests, %zu KiB known, %d line(s)\n",
                  clock_now_s() - start, fault_server_seen("down") - before, c.memory_bytes / 1024,
                  lines);
    assert_true(fault_server_seen("down") - before < 100);
    assert_true(c.memory_bytes < (8 << 20));
    assert_int_equal(lines, 1);
    fault_server_down(0);
    status s = ERR_IO;
    for (int i = 0; i < 40 && s; i++) {
        snprintf(path, sizeof path, "/down/8/%d/1", i);
        s = get(f, path, &size);
        if (s) clock_sleep_s(0.5);
    }
    assert_int_equal(s, OK);
    want_release(&want);
    fetcher_destroy(&f);
}

// Memory stays within its bound, whatever is asked for.
static void memory_is_bounded(void **state)
{
    (void)state;
    fetch_params params = {.memory_bytes = 64 << 10};
    struct fetcher *f = fetcher_create(&params);
    char path[64];
    size_t size;
    struct fetch_counters c;
    for (int i = 0; i < 300; i++) {
        snprintf(path, sizeof path, i % 3 ? "/ok/6/%d/1" : "/status/404/%d", i);
        get(f, path, &size);
        fetch_counters(f, &c);
        assert_true(c.memory_bytes <= (64 << 10) + 2000);
    }
    fetcher_destroy(&f);
}

int main(void)
{
    log_set_sink(keep_line, NULL);
    fault_server_start(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(answers),
        cmocka_unit_test(in_flight_is_bounded),
        cmocka_unit_test(other_schemes_are_refused),
        cmocka_unit_test(pauses_grow),
        cmocka_unit_test(silence_ends),
        cmocka_unit_test(a_document_that_is_too_large),
        cmocka_unit_test(retry_after_is_kept),
        cmocka_unit_test(the_same_as_before),
        cmocka_unit_test(bodies_that_are_no_tiles),
        cmocka_unit_test(tiles_come_from_their_place),
        cmocka_unit_test(heights_of_both_codes),
        cmocka_unit_test(cancelled_transfers_stop),
        cmocka_unit_test(a_dead_server_is_left_alone_and_found_again),
        cmocka_unit_test(memory_is_bounded),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    fault_server_stop();
    return failed;
}
