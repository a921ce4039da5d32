// The cache of tiles on disk: bounded, least recently used, several at once, and on disks and
// clocks that fail it.
#include "planet/disk_cache.h"

#include "check.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/log.h"

enum { BODY = 10000 };

static char dir[64], path[128], last[1024];
static int lines;
static time_t clock_moved;

// The linker has the library call this one.
time_t __wrap_time(time_t *out);
time_t __wrap_time(time_t *out)
{
    struct timespec t;
    clock_gettime(CLOCK_REALTIME, &t);
    if (out) *out = t.tv_sec + clock_moved;
    return t.tv_sec + clock_moved;
}

static void keep_line(void *user, enum log_level level, const char *line)
{
    (void)user;
    (void)level;
    lines++;
    snprintf(last, sizeof last, "%s", line);
}

static int fresh(void **state)
{
    (void)state;
    static int n;
    snprintf(path, sizeof path, "%s/sub/%d/tiles.db", dir, n++);
    lines = 0;
    last[0] = '\0';
    clock_moved = 0;
    return 0;
}

static struct disk_cache *open_cache(uint64_t bytes)
{
    struct disk_cache *c;
    assert_int_equal(disk_cache_open(path, bytes, &c), OK);
    return c;
}

static void put(struct disk_cache *c, int number)
{
    static unsigned char body[BODY];
    char url[64];
    snprintf(url, sizeof url, "http://a/%d", number);
    for (int i = 0; i < BODY; i++) body[i] = (unsigned char)(number * 7 + i * i);
    disk_item item = {.data = body, .size = BODY, .etag = "\"e\"", .max_age_s = 1000};
    disk_cache_put(c, url, &item);
}

// Is it there, and what was put? `left`: how long it may be used.
static bool has(struct disk_cache *c, int number, double *left)
{
    char url[64];
    disk_item item;
    snprintf(url, sizeof url, "http://a/%d", number);
    if (!disk_cache_get(c, url, &item)) return false;
    assert_int_equal(item.size, BODY);
    for (int i = 0; i < BODY; i++)
        assert_int_equal(item.data[i], (unsigned char)(number * 7 + i * i));
    assert_string_equal(item.etag, "\"e\"");
    if (left) *left = item.max_age_s;
    disk_item_deinit(&item);
    return true;
}

static off_t file_bytes(const char *name)
{
    struct stat info;
    return stat(name, &info) ? 0 : info.st_size;
}

static void kept_from_run_to_run(void **state)
{
    (void)state;
    struct disk_cache *c = open_cache(1 << 20);
    disk_item absent = {.max_age_s = 50}, got;
    put(c, 1);
    disk_cache_put(c, "http://a/none", &absent);
    disk_cache_close(&c);
    c = open_cache(1 << 20);
    double left;
    assert_true(has(c, 1, &left));
    check_near(left, 1000, 5);
    assert_true(disk_cache_get(c, "http://a/none", &got));
    assert_null(got.data);
    assert_false(has(c, 2, NULL));
    disk_cache_forget(c, "http://a/1");
    disk_cache_flush(c);
    assert_false(has(c, 1, NULL));
    disk_cache_close(&c);
    assert_int_equal(lines, 0);
}

static void the_least_recently_used_go_first(void **state)
{
    (void)state;
    const uint64_t bound = 50 * BODY;
    struct disk_cache *c = open_cache(bound);
    for (int i = 0; i < 300; i++) {
        put(c, i);
        disk_cache_flush(c);
        if (i >= 1) assert_true(has(c, 0, NULL)); // used all the time
        disk_cache_flush(c);
        struct disk_cache_counters n;
        disk_cache_counters(c, &n);
        assert_true(n.bytes <= bound);
    }
    assert_true(has(c, 299, NULL));
    assert_true(has(c, 298, NULL));
    assert_false(has(c, 100, NULL));
    int kept = 0;
    for (int i = 0; i < 300; i++) kept += has(c, i, NULL);
    assert_true(kept > 20 && kept <= 50);
    disk_cache_close(&c);
    print_message("bound %d KiB: %d bodies of 10 kB kept, file %d KiB\n", (int)(bound / 1024), kept,
                  (int)(file_bytes(path) / 1024));
    assert_true(file_bytes(path) < (off_t)(2 * bound));
}

// A smaller bound takes hold with the next write, for the file on disk too: what is let go is given
// back to the file system. Fails without `incremental_vacuum`, and without `auto_vacuum`.
static void the_file_shrinks_with_its_bound(void **state)
{
    (void)state;
    struct disk_cache *c = open_cache(400 * BODY);
    for (int i = 0; i < 350; i++) put(c, i);
    disk_cache_close(&c);
    off_t before = file_bytes(path);
    c = open_cache(50 * BODY);
    put(c, 1000);
    disk_cache_flush(c);
    struct disk_cache_counters n;
    disk_cache_counters(c, &n);
    assert_true(n.bytes <= 50 * BODY);
    disk_cache_close(&c);
    print_message("file %d KiB, with a bound of %d KiB %d\n", (int)(before / 1024),
                  50 * BODY / 1024, (int)(file_bytes(path) / 1024));
    assert_true(before > 350 * BODY);
    assert_true(file_bytes(path) < 75 * BODY);
    c = open_cache(50 * BODY);
    assert_true(has(c, 1000, NULL));
    int kept = 0;
    for (int i = 0; i < 350; i++) kept += has(c, i, NULL);
    assert_true(kept > 20 && kept < 50);
    disk_cache_close(&c);
}

// A clock that went back makes what is there old, and one that comes right young again; what is put
// meanwhile is used as long as any.
static void a_clock_that_goes_back(void **state)
{
    (void)state;
    struct disk_cache *c = open_cache(1 << 20);
    double left;
    put(c, 1);
    disk_cache_flush(c);
    assert_true(has(c, 1, &left));
    assert_true(left > 900);
    clock_moved = -100000;
    assert_true(has(c, 1, &left));
    check_near(left, 0, 0);
    put(c, 2);
    disk_cache_flush(c);
    assert_true(has(c, 2, &left));
    check_near(left, 1000, 5);
    clock_moved = 500;
    assert_true(has(c, 1, &left));
    check_near(left, 500, 5);
    clock_moved = 2000;
    assert_true(has(c, 1, &left));
    check_near(left, 0, 0);
    disk_cache_close(&c);
}

static void write_many(int first, int count)
{
    struct disk_cache *c;
    if (disk_cache_open(path, 4 << 20, &c)) _exit(1);
    for (int i = 0; i < count; i++) {
        put(c, first + i);
        if (i % 20 == 19) disk_cache_flush(c);
    }
    disk_cache_close(&c);
    _exit(0);
}

// Several programs begin with it at the same moment, and fill it together.
static void many_writers(void **state)
{
    enum { WRITERS = 4, EACH = 60 };
    for (int round = 0; round < 10; round++) {
        pid_t children[WRITERS];
        fresh(state);
        for (int i = 0; i < WRITERS; i++)
            if (!(children[i] = fork())) write_many(1000 * i, EACH);
        for (int i = 0; i < WRITERS; i++) {
            int result;
            waitpid(children[i], &result, 0);
            assert_int_equal(result, 0);
        }
        struct disk_cache *c = open_cache(4 << 20);
        for (int i = 0; i < WRITERS * EACH; i++)
            assert_true(has(c, i / EACH * 1000 + i % EACH, NULL));
        disk_cache_close(&c);
        assert_int_equal(lines, 0);
    }
}

static void a_kill_loses_the_last_only(void **state)
{
    (void)state;
    for (int round = 0; round < 10; round++) {
        int told[2];
        assert_int_equal(pipe(told), 0);
        pid_t child = fork();
        if (!child) {
            struct disk_cache *c;
            if (disk_cache_open(path, 4 << 20, &c)) _exit(1);
            for (int i = 0;; i++) {
                put(c, round * 20 + i % 20);
                disk_cache_flush(c);
                if (i == 5 && write(told[1], "x", 1) != 1) _exit(1);
            }
        }
        char x;
        close(told[1]);
        assert_int_equal(read(told[0], &x, 1), 1);
        clock_sleep_s(0.002 * round);
        kill(child, SIGKILL);
        waitpid(child, NULL, 0);
        close(told[0]);
        struct disk_cache *c = open_cache(4 << 20);
        for (int i = 0; i < 5; i++) assert_true(has(c, round * 20 + i, NULL));
        disk_cache_close(&c);
    }
    assert_int_equal(lines, 0);
}

// A file system without room, by a limit on the size of files.
static void a_full_disk(void **state)
{
    (void)state;
    struct disk_cache *c = open_cache(4 << 20);
    put(c, 1);
    disk_cache_flush(c);
    signal(SIGXFSZ, SIG_IGN);
    struct rlimit was, limit;
    getrlimit(RLIMIT_FSIZE, &was);
    limit = was;
    limit.rlim_cur = 200000;
    setrlimit(RLIMIT_FSIZE, &limit);
    for (int i = 2; i < 100; i++) put(c, i);
    disk_cache_flush(c);
    setrlimit(RLIMIT_FSIZE, &was);
    struct disk_cache_counters n;
    disk_cache_counters(c, &n);
    assert_true(n.failed > 0);
    assert_int_equal(lines, 1);
    assert_non_null(strstr(last, path));
    assert_true(has(c, 1, NULL)); // what is there can be read
    disk_cache_close(&c);
    c = open_cache(4 << 20); // a later run
    for (int i = 2; i < 100; i++) put(c, i);
    disk_cache_flush(c);
    for (int i = 1; i < 100; i++) assert_true(has(c, i, NULL));
    disk_cache_close(&c);
}

// As somebody who may not write there.
static void read_only(void **state)
{
    (void)state;
    struct disk_cache *c = open_cache(4 << 20);
    put(c, 1);
    disk_cache_close(&c);
    char folder[128];
    snprintf(folder, sizeof folder, "%s", path);
    *strrchr(folder, '/') = '\0';
    chmod(path, 0444);
    chmod(folder, 0555);
    chmod(dir, 0755);
    pid_t child = fork();
    if (!child) {
        if (geteuid() == 0 && seteuid(65534)) _exit(77);
        if (disk_cache_open(path, 4 << 20, &c)) {
            print_message("%s\n", last);
            _exit(2);
        }
        put(c, 2);
        disk_cache_flush(c);
        int good =
            lines == 1 && strstr(last, "nothing is added") && has(c, 1, NULL) && !has(c, 2, NULL);
        disk_cache_close(&c);
        _exit(good ? 0 : 3);
    }
    int result;
    waitpid(child, &result, 0);
    chmod(folder, 0755);
    assert_int_equal(result, 0);
    snprintf(path, sizeof path, "/proc/no/such/tiles.db");
    assert_int_equal(disk_cache_open(path, 1 << 20, &c), ERR_IO);
    assert_null(c);
    assert_int_equal(lines, 1);
}

static void scribble(off_t at, size_t count)
{
    int f = open(path, O_WRONLY);
    char *junk = malloc(count);
    memset(junk, 0xa5, count);
    assert_int_equal(pwrite(f, junk, count, at), (ssize_t)count);
    free(junk);
    close(f);
}

// Bytes that rot: a body is noticed, a broken database is made anew.
static void rot(void **state)
{
    (void)state;
    struct disk_cache *c = open_cache(4 << 20);
    for (int i = 0; i < 50; i++) put(c, i);
    disk_cache_close(&c);
    off_t size = file_bytes(path);
    scribble(size / 2, 4096);
    c = open_cache(4 << 20);
    int kept = 0;
    for (int i = 0; i < 50; i++) kept += has(c, i, NULL); // each is whole or missing
    assert_true(kept < 50);
    disk_cache_close(&c);
    scribble(100, 8192); // the schema's page and the next
    c = open_cache(4 << 20);
    put(c, 7);
    disk_cache_flush(c);
    assert_true(has(c, 7, NULL));
    disk_cache_close(&c);
}

static void what_is_not_ours_is_left_alone(void **state)
{
    (void)state;
    snprintf(path, sizeof path, "%s/precious.txt", dir);
    FILE *f = fopen(path, "w");
    fputs("precious", f);
    fclose(f);
    struct disk_cache *c;
    assert_int_equal(disk_cache_open(path, 1 << 20, &c), ERR_FORMAT);
    assert_int_equal(lines, 1);
    assert_non_null(strstr(last, "precious.txt"));
    assert_int_equal(file_bytes(path), 8);
}

int main(void)
{
    log_set_sink(keep_line, NULL);
    strcpy(dir, "disk-cache-XXXXXX");
    if (!mkdtemp(dir)) return 1;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(kept_from_run_to_run, fresh),
        cmocka_unit_test_setup(the_least_recently_used_go_first, fresh),
        cmocka_unit_test_setup(the_file_shrinks_with_its_bound, fresh),
        cmocka_unit_test_setup(a_clock_that_goes_back, fresh),
        cmocka_unit_test_setup(many_writers, fresh),
        cmocka_unit_test_setup(a_kill_loses_the_last_only, fresh),
        cmocka_unit_test_setup(a_full_disk, fresh),
        cmocka_unit_test_setup(read_only, fresh),
        cmocka_unit_test_setup(rot, fresh),
        cmocka_unit_test_setup(what_is_not_ours_is_left_alone, fresh),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    char command[128];
    snprintf(command, sizeof command, "rm -r %s", dir);
    return failed + (system(command) != 0);
}
