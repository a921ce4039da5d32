// Several viewers at once over one cache of tiles on disk, fed by one server: the cache keeps its
// bound of bytes, a viewer that is killed harms nobody, and what is kept is what the server gave.
#include "fault_server.h"
#include "check.h"

#include <dirent.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/log.h"
#include "planet/source_set.h"

enum { VIEWERS = 4, ROWS = 4, COLS = 32, ZOOM = 4, LEVEL = ZOOM + 1, DISK_BYTES = 100 << 10 };

static char dir[] = "viewers-XXXXXX", path[64];
static int lines;

static void count_line(void *user, enum log_level level, const char *line)
{
    (void)user;
    lines += level <= LOG_WARN;
    if (level <= LOG_WARN) print_message("%s\n", line);
}

// One row of tiles either side of the equator and one more, the whole way round from `first` on;
// killed after `most` tiles. The exit status says what was wrong.
static void view(int first, int most)
{
    struct pyramid *p;
    pyramid_params tiles = {0};
    source_set_params params = {
        .disk_path = path, .disk_bytes = DISK_BYTES, .fetch = {.memory_bytes = 64 << 10}};
    struct source_set *set = source_set_create(&params);
    if (source_set_add(set, fault_url("/ok/{z}/{x}/{y}"), LAYER_COLOR, 1)) _exit(2);
    if (source_set_pyramid(set, &tiles, &p)) _exit(3);
    for (int i = 0; i < ROWS * COLS; i++) {
        int col = (first + i) % COLS;
        const pyramid_tile *tile;
        tile_id id = {LAYER_COLOR, ZOOM, 8 - ROWS / 2 + i / COLS, col};
        if (pyramid_acquire(p, id, &tile)) _exit(4);
        if (tile->rgba[0] != 10 * LEVEL || tile->rgba[1] != col) _exit(5);
        pyramid_release(p, &tile);
        struct fetch_counters net;
        struct disk_cache_counters disk;
        fetch_counters(source_set_fetcher(set), &net);
        disk_cache_counters(source_set_disk(set), &disk);
        if (net.memory_bytes > (64 << 10) + 4096) _exit(6);
        if (disk.bytes > DISK_BYTES) _exit(7);
        if (i == most) kill(getpid(), SIGKILL);
    }
    disk_cache_flush(source_set_disk(set));
    struct disk_cache_counters disk;
    disk_cache_counters(source_set_disk(set), &disk);
    pyramid_destroy(&p);
    source_set_destroy(&set);
    _exit(disk.failed ? 8 : lines ? 9 : 0);
}

// Bytes of all files of the cache.
static off_t folder_bytes(void)
{
    off_t sum = 0;
    DIR *d = opendir(dir);
    for (struct dirent *e; d && (e = readdir(d));) {
        char name[512];
        struct stat info;
        snprintf(name, sizeof name, "%s/%s", dir, e->d_name);
        if (!stat(name, &info) && S_ISREG(info.st_mode)) sum += info.st_size;
    }
    if (d) closedir(d);
    return sum;
}

// How many of the server's tiles are kept; each as the server gives it.
static int kept_bodies(size_t *bytes)
{
    struct disk_cache *disk;
    struct fetcher *fresh = fetcher_create(&(fetch_params){0});
    int kept = 0;
    *bytes = 0;
    assert_int_equal(disk_cache_open(path, DISK_BYTES, &disk), OK);
    for (int y = 0; y < 1 << LEVEL; y++)
        for (int x = 0; x < COLS; x++) {
            char name[64];
            disk_item item;
            const fetch_body *body;
            snprintf(name, sizeof name, "/ok/%d/%d/%d", LEVEL, x, y);
            if (!disk_cache_get(disk, fault_url(name), &item)) continue;
            assert_int_equal(fetch_wait(fresh, fault_url(name), 1 << 20, 20, &body), OK);
            assert_int_equal(item.size, body->size);
            assert_memory_equal(item.data, body->data, item.size);
            *bytes += item.size;
            kept++;
            fetch_release(fresh, &body);
            disk_item_deinit(&item);
        }
    disk_cache_close(&disk);
    fetcher_destroy(&fresh);
    return kept;
}

static void one_cache_for_all(void **state)
{
    (void)state;
    pid_t viewers[VIEWERS];
    for (int i = 0; i < VIEWERS; i++)
        if (!(viewers[i] = fork())) view(i * COLS / VIEWERS, i == 1 ? ROWS * COLS / 2 : -1);
    for (int i = 0; i < VIEWERS; i++) {
        int ended;
        assert_int_equal(waitpid(viewers[i], &ended, 0), viewers[i]);
        if (i == 1) assert_true(WIFSIGNALED(ended) && WTERMSIG(ended) == SIGKILL);
        else if (ended) fail_msg("viewer %d: status %x", i, (unsigned)ended);
    }
    size_t bytes;
    int asked = fault_server_seen("ok"), kept = kept_bodies(&bytes);
    print_message("%d viewers, %d requests: %d bodies of %zu bytes kept of %d, files %ld bytes\n",
                  VIEWERS, asked, kept, bytes, DISK_BYTES, (long)folder_bytes());
    assert_true(asked > kept); // not all fit
    assert_true(kept > 20 && bytes <= DISK_BYTES);
    assert_true(folder_bytes() < 3 * DISK_BYTES);
}

int main(void)
{
    log_set_sink(count_line, NULL);
    fault_server_start(0);
    if (!mkdtemp(dir)) return 1;
    snprintf(path, sizeof path, "%s/tiles.db", dir);
    const struct CMUnitTest tests[] = {cmocka_unit_test(one_cache_for_all)};
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    fault_server_stop();
    char command[128];
    snprintf(command, sizeof command, "rm -r %s", dir);
    return failed + (system(command) != 0);
}
