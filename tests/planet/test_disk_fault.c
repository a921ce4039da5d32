// A planet file on a disk that fails, and a disk that gets full while one is made: what was there
// goes on being shown, the message names the file, and a healthy disk makes all good.
#include "test_import_common.h"

#include <sys/wait.h>

#include "bad_disk.h"
#include "base/clock.h"
#include "planet/pyramid.h"

enum { SAMPLES = TILE_SIZE * TILE_SIZE };

static int lines;
static char said[4096];

static void keep_line(void *user, enum log_level level, const char *line)
{
    (void)user;
    if (level > LOG_WARN) return;
    lines++;
    snprintf(said, sizeof said, "%s", line);
}

static double hills(int band, double x, double y)
{
    (void)band;
    return 700 * sin(x * 0.7) * cos(y * 1.1) + 200 * sin(x * 6.1 + y * 4.3);
}

static const raster_spec globe = {.name = "globe.tif",
                                  .width = 1440,
                                  .height = 720,
                                  .bands = 1,
                                  .type = GDT_Float32,
                                  .crs = "EPSG:4326",
                                  .transform = {-180, 0.25, 0, 90, 0, -0.25},
                                  .value = hills};

static status import_with(const char *output, bool resume,
                          bool (*progress)(void *, const char *, double), void *user)
{
    char in[512], out[512];
    snprintf(in, sizeof in, "%s", in_dir("globe.tif"));
    snprintf(out, sizeof out, "%s", in_dir(output));
    import_source source = {.layer = LAYER_HEIGHT, .path = in};
    import_params p = {.sources = &source,
                       .source_count = 1,
                       .output = out,
                       .name = "Globe",
                       .threads = 1,
                       .resume = resume,
                       .progress = progress,
                       .user = user};
    return import_run(&p);
}

static status import_globe(const char *output, bool resume)
{
    return import_with(output, resume, NULL, NULL);
}

static int setup(void **state)
{
    bad_disk_install();
    if (make_test_dir(state)) return -1;
    write_raster(&globe);
    log_set_sink(keep_line, NULL);
    return import_globe("globe.planet", false) == OK ? 0 : -1;
}

static struct pyramid *open_pyramid(struct planet_file **file)
{
    struct pyramid *p;
    assert_int_equal(planet_file_open(in_dir("globe.planet"), file), OK);
    pyramid_params params = {0};
    assert_int_equal(pyramid_create(*file, &params, &p), OK);
    return p;
}

// Greatest difference of a tile from what is stored, and until when the tile stands.
static double off_by(struct pyramid *p, tile_id id, const float *stored, double *until_s)
{
    const pyramid_tile *tile;
    double off = 0;
    assert_int_equal(pyramid_acquire(p, id, &tile), OK);
    for (int i = 0; i < SAMPLES; i++) off = fmax(off, fabs(tile->heights[i] - stored[i]));
    *until_s = tile->until_s;
    pyramid_release(p, &tile);
    return off;
}

// Tiles that cannot be read for now come from coarser ones in memory, are told of once, and are
// themselves again some seconds after the disk is.
static void a_disk_that_fails(void **state)
{
    (void)state;
    static float stored[4][SAMPLES];
    struct planet_file *file;
    struct pyramid *p = open_pyramid(&file);
    struct pyramid_counters c;
    double until;
    const tile_id near = {LAYER_HEIGHT, 0, 0, 0};
    tile_id far[4];
    for (int i = 0; i < 4; i++) {
        far[i] = (tile_id){LAYER_HEIGHT, 2, 1, i};
        assert_int_equal(planet_file_read_height(file, far[i], stored[i]), OK);
    }
    pyramid_destroy(&p);
    planet_file_close(&file);

    p = open_pyramid(&file);
    const pyramid_tile *tile;
    for (int col = 0; col < 2; col++) {
        tile_id id = {LAYER_HEIGHT, 0, 0, col};
        assert_int_equal(pyramid_acquire(p, id, &tile), OK);
        pyramid_release(p, &tile);
    }
    lines = 0;
    bad_disk_fail_reads(true);
    for (int again = 0; again < 3; again++)
        for (int i = 0; i < 4; i++) {
            double off = off_by(p, far[i], stored[i], &until);
            assert_true(off > 1 && off < 2500); // the coarser one's
            assert_true(until < (double)INFINITY);
        }
    assert_int_equal(lines, 1);
    assert_non_null(strstr(said, "globe.planet"));
    assert_non_null(strstr(said, "going on without"));
    pyramid_counters(p, &c);
    assert_int_equal(c.corrupt, 0);
    assert_true(c.failed > 0);
    assert_true(c.cache_bytes < (64 << 20));
    assert_int_equal(off_by(p, near, stored[0], &until) > 0, 1); // in memory: still whole
    assert_true(until == (double)INFINITY);

    bad_disk_fail_reads(false);
    for (int i = 0; i < 4; i++) {
        off_by(p, far[i], stored[i], &until);
        while (clock_now_s() < until && until < (double)INFINITY) clock_sleep_s(0.05);
        check_near(off_by(p, far[i], stored[i], &until), 0, 0);
        assert_true(until == (double)INFINITY);
    }
    pyramid_destroy(&p);
    planet_file_close(&file);
}

static void opened_on_a_disk_that_fails(void **state)
{
    (void)state;
    struct planet_file *file;
    lines = 0;
    bad_disk_fail_reads(true);
    assert_int_equal(planet_file_open(in_dir("globe.planet"), &file), ERR_IO);
    bad_disk_fail_reads(false);
    assert_null(file);
    assert_int_equal(lines, 1);
    assert_non_null(strstr(said, "globe.planet"));
}

// Full after so many of the bytes that an import writes: the import ends with a message, there is
// no finished file, and with room it goes on to the same file.
static void a_disk_that_gets_full(void **state)
{
    (void)state;
    static const double shares[] = {0, 0.2, 0.5, 0.75, 0.97};
    long long before = bad_disk_written();
    assert_int_equal(import_globe("whole.planet", false), OK);
    long long all = bad_disk_written() - before;
    assert_true(all > 1000000);
    check_same_files(in_dir("globe.planet"), in_dir("whole.planet"));
    for (size_t i = 0; i < sizeof shares / sizeof *shares; i++) {
        lines = 0;
        bad_disk_room((long long)(shares[i] * (double)all));
        status s = import_globe("full.planet", false);
        bad_disk_room(-1);
        print_message("room for %.0f %% of %lld bytes: %s: %s\n", 100 * shares[i], all,
                      status_text(s), said);
        assert_int_equal(s, ERR_IO);
        assert_true(lines > 0 && lines < 4);
        assert_non_null(strstr(said, "full.planet"));
        assert_non_null(strstr(said, "full"));
        assert_true(access(in_dir("full.planet"), F_OK) != 0);
        assert_int_equal(import_globe("full.planet", true), OK);
        check_same_files(in_dir("globe.planet"), in_dir("full.planet"));
        unlink(in_dir("full.planet"));
    }
}

// An import in another process, held in its midst until something is written to `go`.
struct held {
    int at, go;
};

static bool hold(void *user, const char *stage, double done)
{
    (void)stage;
    (void)done;
    struct held *h = user;
    char x = 0;
    if (h->at < 0 || access(in_dir("twice.planet.part"), F_OK) != 0) return false;
    if (write(h->at, &x, 1) != 1 || read(h->go, &x, 1) != 1) return true;
    h->at = -1;
    return false;
}

// Whether it goes on with it or begins anew: the second one is refused and harms nothing.
static void two_imports_of_one_planet(void **state)
{
    (void)state;
    int at[2], go[2], result;
    char x = 0;
    assert_true(pipe(at) == 0 && pipe(go) == 0);
    pid_t child = fork();
    if (child == 0) {
        struct held held = {at[1], go[0]};
        close(at[0]);
        close(go[1]); // so that the end of the test is the end of the wait
        _exit(import_with("twice.planet", false, hold, &held) == OK ? 0 : 1);
    }
    close(at[1]);
    assert_int_equal(read(at[0], &x, 1), 1);
    for (int resume = 0; resume < 2; resume++) {
        lines = 0;
        assert_int_equal(import_globe("twice.planet", resume), ERR_IO);
        print_message("the second: %s\n", said);
        assert_non_null(strstr(said, "twice.planet"));
        assert_non_null(strstr(said, "another program"));
    }
    assert_int_equal(write(go[1], &x, 1), 1);
    waitpid(child, &result, 0);
    assert_true(WIFEXITED(result) && WEXITSTATUS(result) == 0);
    check_same_files(in_dir("globe.planet"), in_dir("twice.planet"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_disk_that_fails),
        cmocka_unit_test(opened_on_a_disk_that_fails),
        cmocka_unit_test(a_disk_that_gets_full),
        cmocka_unit_test(two_imports_of_one_planet),
    };
    return cmocka_run_group_tests(tests, setup, remove_test_dir);
}
