// The planet file: what is written is read, and every kind of broken file gives one clear line.
#include "check.h"

#include <fcntl.h>
#include <pthread.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/log.h"
#include "planet_fixture.h"

enum { SAMPLES = TILE_SIZE * TILE_SIZE };

static int lines;
static char last_line[1024];

static void count_line(void *user, enum log_level level, const char *line)
{
    (void)user;
    if (level > LOG_WARN) return;
    lines++;
    snprintf(last_line, sizeof last_line, "%s", line);
}

static int setup(void **state)
{
    fixture *f = calloc(1, sizeof *f);
    fixture_init(f, "planet-file");
    *state = f;
    lines = 0;
    last_line[0] = '\0';
    log_set_sink(count_line, NULL);
    return 0;
}

static int teardown(void **state)
{
    log_set_sink(NULL, NULL);
    chmod(((fixture *)*state)->dir, 0755);
    fixture_deinit(*state);
    free(*state);
    return 0;
}

// Runs statements on the file, as a program that is none of ours would.
static void sql(const fixture *f, const char *statements)
{
    sqlite3 *db;
    assert_int_equal(sqlite3_open(f->path, &db), SQLITE_OK);
    assert_int_equal(sqlite3_exec(db, statements, NULL, NULL, NULL), SQLITE_OK);
    sqlite3_close(db);
}

static long size_of(const char *path)
{
    struct stat info;
    return stat(path, &info) == 0 ? (long)info.st_size : -1;
}

// One line, naming the file.
static void expect_refusal(const fixture *f, status want)
{
    struct planet_file *file;
    lines = 0;
    assert_int_equal(planet_file_open(f->path, &file), want);
    assert_null(file);
    assert_int_equal(lines, 1);
    assert_non_null(strstr(last_line, f->path));
}

static codec_blob body_of(float height)
{
    static float samples[SAMPLES];
    for (int i = 0; i < SAMPLES; i++) samples[i] = height;
    codec_blob body;
    assert_int_equal(codec_height_encode(samples, &body), OK);
    return body;
}

static void put_constant(struct planet_writer *w, tile_id id, float height)
{
    codec_blob body = body_of(height);
    assert_int_equal(planet_writer_put(w, id, &body, height, height), OK);
    codec_blob_deinit(&body);
}

static const struct planet_meta meta = {.name = "Test \"planet\"",
                                        .attribution = "\xc2\xa9 nobody",
                                        .ellipsoid = {1737400.0, 1736000.5},
                                        .synthesis_gain = 0.125};

// Tiles 0/0/0 = 10 and 0/0/1 = 20, and some of zoom 3.
static void write_small(const fixture *f)
{
    struct planet_writer *w;
    assert_int_equal(planet_writer_open(f->path, "print", false, &w), OK);
    put_constant(w, (tile_id){LAYER_HEIGHT, 0, 0, 0}, 10.0f);
    put_constant(w, (tile_id){LAYER_HEIGHT, 0, 0, 1}, 20.0f);
    for (int col = 0; col < 16; col++)
        put_constant(w, (tile_id){LAYER_HEIGHT, 3, 4, col}, col % 2 ? -5.0f : 10.0f);
    assert_int_equal(planet_writer_finish(w, &meta), OK);
    planet_writer_close(&w);
    assert_null(w);
    planet_writer_close(&w);
}

static void what_is_written_is_read(void **state)
{
    const fixture *f = *state;
    write_small(f);
    struct planet_file *file;
    assert_int_equal(planet_file_open(f->path, &file), OK);
    const struct planet_meta *m = planet_file_meta(file);
    assert_string_equal(m->name, meta.name);
    assert_string_equal(m->attribution, meta.attribution);
    assert_true(m->ellipsoid.a == meta.ellipsoid.a && m->ellipsoid.b == meta.ellipsoid.b);
    assert_true(m->synthesis_gain == 0.125 && m->complete);
    assert_int_equal(m->max_zoom[LAYER_HEIGHT], 3);
    assert_int_equal(m->max_zoom[LAYER_COLOR], -1);
    assert_true(m->height_min == -5.0 && m->height_max == 20.0);
    assert_string_equal(planet_file_path(file), f->path);
    static float heights[SAMPLES];
    assert_int_equal(planet_file_read_height(file, (tile_id){LAYER_HEIGHT, 0, 0, 1}, heights), OK);
    assert_true(heights[0] == 20.0f && heights[SAMPLES - 1] == 20.0f);
    float min, max;
    tile_id id = {LAYER_HEIGHT, 3, 4, 5}, absent = {LAYER_HEIGHT, 3, 3, 5};
    assert_int_equal(planet_file_read_range(file, id, &min, &max), OK);
    assert_true(min == -5.0f && max == -5.0f);
    assert_int_equal(planet_file_read_height(file, absent, heights), ERR_NOT_FOUND);
    assert_int_equal(planet_file_read_range(file, absent, &min, &max), ERR_NOT_FOUND);
    assert_int_equal(lines, 0);
    planet_file_close(&file);
    assert_null(file);
    planet_file_close(&file);
}

static void identical_bodies_are_stored_once(void **state)
{
    const fixture *f = *state;
    write_small(f);
    sqlite3 *db;
    sqlite3_stmt *stmt;
    assert_int_equal(sqlite3_open(f->path, &db), SQLITE_OK);
    sqlite3_prepare_v2(db, "SELECT (SELECT count(*) FROM body), (SELECT count(*) FROM tile)", -1,
                       &stmt, NULL);
    assert_int_equal(sqlite3_step(stmt), SQLITE_ROW);
    assert_int_equal(sqlite3_column_int(stmt, 0), 3);
    assert_int_equal(sqlite3_column_int(stmt, 1), 18);
    sqlite3_finalize(stmt);
    sqlite3_close(db);
}

static void pixels_and_missing_samples(void **state)
{
    const fixture *f = *state;
    struct planet_writer *w;
    static unsigned char pixels[SAMPLES * 3], got[SAMPLES * 3];
    memset(pixels, 77, sizeof pixels);
    assert_int_equal(planet_writer_open(f->path, "print", false, &w), OK);
    codec_blob body;
    tile_id color = {LAYER_COLOR, 0, 0, 0}, night = {LAYER_NIGHT, 0, 0, 1};
    assert_int_equal(codec_pixels_encode(pixels, 3, 90, &body), OK);
    assert_int_equal(planet_writer_put(w, color, &body, 0, 0), OK);
    codec_blob_deinit(&body);
    assert_int_equal(codec_pixels_encode(pixels, 1, 90, &body), OK);
    assert_int_equal(planet_writer_put(w, night, &body, 0, 0), OK);
    codec_blob_deinit(&body);
    body = body_of(NAN);
    tile_id empty = {LAYER_HEIGHT, 0, 0, 0};
    assert_int_equal(planet_writer_put(w, empty, &body, NAN, NAN), OK);
    codec_blob_deinit(&body);
    assert_int_equal(planet_writer_finish(w, &meta), OK);
    planet_writer_close(&w);
    struct planet_file *file;
    float min, max;
    assert_int_equal(planet_file_open(f->path, &file), OK);
    assert_int_equal(planet_file_read_pixels(file, color, got), OK);
    assert_true(abs(got[100] - 77) <= 1);
    assert_int_equal(planet_file_read_pixels(file, night, got), OK);
    assert_int_equal(planet_file_read_range(file, empty, &min, &max), ERR_NOT_FOUND);
    assert_true(planet_file_meta(file)->height_min == 0.0);
    planet_file_close(&file);
}

static void resume_goes_on_with_the_same_sources_only(void **state)
{
    const fixture *f = *state;
    struct planet_writer *w;
    tile_id a = {LAYER_HEIGHT, 2, 1, 3}, b = {LAYER_HEIGHT, 2, 1, 4};
    assert_int_equal(planet_writer_open(f->path, "one", false, &w), OK);
    put_constant(w, a, 1.0f);
    assert_true(planet_writer_has(w, a));
    assert_int_equal(planet_writer_commit(w), OK);
    put_constant(w, b, 2.0f);
    planet_writer_close(&w);
    // Begun and not finished: readable, and says so.
    struct planet_file *file;
    assert_int_equal(planet_file_open(f->path, &file), OK);
    assert_false(planet_file_meta(file)->complete);
    planet_file_close(&file);
    assert_int_equal(planet_writer_open(f->path, "two", true, &w), ERR_ARGUMENT);
    assert_null(w);
    assert_int_equal(lines, 1);
    assert_int_equal(planet_writer_open(f->path, "one", true, &w), OK);
    assert_true(planet_writer_has(w, a) && planet_writer_has(w, b));
    codec_blob body;
    float min, max;
    assert_int_equal(planet_writer_get(w, b, &body, &min, &max), OK);
    assert_true(body.size > 0);
    codec_blob_deinit(&body);
    assert_int_equal(planet_writer_get(w, (tile_id){LAYER_HEIGHT, 1, 0, 0}, &body, &min, &max),
                     ERR_NOT_FOUND);
    planet_writer_close(&w);
    // Without resume it begins anew.
    assert_int_equal(planet_writer_open(f->path, "two", false, &w), OK);
    assert_false(planet_writer_has(w, a));
    planet_writer_close(&w);
}

// A process killed while it writes loses nothing that it committed.
static void a_kill_loses_no_committed_tile(void **state)
{
    const fixture *f = *state;
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        struct planet_writer *w;
        if (planet_writer_open(f->path, "one", false, &w)) _exit(1);
        for (int col = 0; col < 16; col++) {
            codec_blob body = body_of((float)col);
            planet_writer_put(w, (tile_id){LAYER_HEIGHT, 3, 4, col}, &body, 0, 0);
            codec_blob_deinit(&body);
            if (col == 9) planet_writer_commit(w);
        }
        kill(getpid(), 9);
    }
    int end;
    waitpid(child, &end, 0);
    assert_true(WIFSIGNALED(end));
    struct planet_writer *w;
    assert_int_equal(planet_writer_open(f->path, "one", true, &w), OK);
    for (int col = 0; col < 16; col++)
        assert_int_equal(planet_writer_has(w, (tile_id){LAYER_HEIGHT, 3, 4, col}), col < 10);
    planet_writer_close(&w);
}

static void a_second_writer_is_refused(void **state)
{
    const fixture *f = *state;
    struct planet_writer *w, *second;
    assert_int_equal(planet_writer_open(f->path, "one", false, &w), OK);
    for (int resume = 0; resume < 2; resume++) {
        lines = 0;
        assert_int_equal(planet_writer_open(f->path, "one", resume, &second), ERR_IO);
        assert_null(second);
        assert_int_equal(lines, 1);
        assert_non_null(strstr(last_line, f->path));
        assert_non_null(strstr(last_line, "another program"));
        assert_true(size_of(f->path) >= 0); // the first one's is still there
    }
    planet_writer_close(&w);
    assert_int_equal(planet_writer_open(f->path, "one", true, &second), OK);
    planet_writer_close(&second);
}

static void a_finished_file_needs_no_write_access(void **state)
{
    const fixture *f = *state;
    write_small(f);
    char beside[160];
    snprintf(beside, sizeof beside, "%s-wal", f->path);
    assert_int_equal(size_of(beside), -1);
    if (geteuid() == 0) { // the superuser may write anywhere, so look at what is done instead
        struct planet_file *file;
        assert_int_equal(planet_file_open(f->path, &file), OK);
        assert_int_equal(size_of(beside), -1);
        planet_file_close(&file);
        return;
    }
    chmod(f->dir, 0555);
    struct planet_file *file;
    assert_int_equal(planet_file_open(f->path, &file), OK);
    planet_file_close(&file);
}

static void unwritable_places_are_refused(void **state)
{
    const fixture *f = *state;
    char path[200];
    struct planet_writer *w;
    snprintf(path, sizeof path, "%s/absent/x.planet", f->dir);
    assert_int_equal(planet_writer_open(path, "one", false, &w), ERR_IO);
    assert_null(w);
    assert_int_equal(lines, 1);
    assert_non_null(strstr(last_line, path));
}

static void missing_empty_and_foreign_files_are_refused(void **state)
{
    const fixture *f = *state;
    expect_refusal(f, ERR_NOT_FOUND);
    int fd = open(f->path, O_CREAT | O_WRONLY, 0644);
    expect_refusal(f, ERR_FORMAT);
    struct check_random random = {3};
    for (int i = 0; i < 4096; i++) {
        uint64_t junk = check_random_u64(&random);
        assert_int_equal(write(fd, &junk, sizeof junk), sizeof junk);
    }
    close(fd);
    expect_refusal(f, ERR_FORMAT);
    unlink(f->path);
    sql(f, "CREATE TABLE t(a)"); // a database, of something else
    expect_refusal(f, ERR_FORMAT);
    unlink(f->path);
    mkdir(f->path, 0755);
    expect_refusal(f, ERR_FORMAT);
    rmdir(f->path);
}

static void truncated_files_are_refused(void **state)
{
    const fixture *f = *state;
    write_small(f);
    long size = size_of(f->path);
    for (int k = 0; k < 12; k++) {
        long shorter = size * (11 - k) / 12 + (k == 0 ? size / 12 - 1 : 0);
        assert_int_equal(truncate(f->path, shorter), 0);
        expect_refusal(f, ERR_FORMAT);
    }
}

static long long fnv1a(const unsigned char *data, size_t size)
{
    uint64_t hash = 14695981039346656037u;
    for (size_t i = 0; i < size; i++) hash = (hash ^ data[i]) * 1099511628211u;
    return (long long)hash;
}

// Files of versions 1 and 2 have FNV-1a for their bodies. Fails when it is not asked for, or when
// nothing is.
static void earlier_versions_are_read(void **state)
{
    const fixture *f = *state;
    static float heights[SAMPLES];
    tile_id id = {LAYER_HEIGHT, 0, 0, 1};
    codec_blob body = body_of(20.0f);
    for (int version = 1; version <= 2; version++)
        for (int off = 0; off < 2; off++) {
            char text[160];
            write_small(f);
            snprintf(text, sizeof text,
                     "PRAGMA user_version = %d; UPDATE body SET hash = %lld"
                     " WHERE id = (SELECT body FROM tile WHERE zoom = 0 AND col = 1)",
                     version, fnv1a(body.data, body.size) + off);
            sql(f, text);
            sql(f, "DELETE FROM meta WHERE key = 'height_quantum'");
            struct planet_file *file;
            assert_int_equal(planet_file_open(f->path, &file), OK);
            assert_true(planet_file_meta(file)->quantum == 0);
            assert_int_equal(planet_file_read_height(file, id, heights), off ? ERR_FORMAT : OK);
            assert_true(off || heights[0] == 20.0f);
            planet_file_close(&file);
        }
    codec_blob_deinit(&body);
}

static void other_versions_are_refused(void **state)
{
    const fixture *f = *state;
    write_small(f);
    sql(f, "PRAGMA user_version = 1");
    struct planet_file *old;
    assert_int_equal(planet_file_open(f->path, &old), OK);
    planet_file_close(&old);
    sql(f, "PRAGMA user_version = 7");
    expect_refusal(f, ERR_VERSION);
    assert_non_null(strstr(last_line, "7"));
    struct planet_writer *w;
    assert_int_equal(planet_writer_open(f->path, "print", true, &w), ERR_VERSION);
}

static void missing_tables_and_absurd_values_are_refused(void **state)
{
    static const char *const faults[] = {
        "DROP TABLE meta",
        "DROP TABLE tile",
        "DROP TABLE body",
        "DELETE FROM meta WHERE key = 'name'",
        "UPDATE meta SET value = 1e300 WHERE key = 'ellipsoid_a'",
        "UPDATE meta SET value = -1 WHERE key = 'ellipsoid_b'",
        "UPDATE meta SET value = 'x' WHERE key = 'ellipsoid_b'",
        "UPDATE meta SET value = 25 WHERE key = 'max_zoom_height'",
        "UPDATE meta SET value = -2 WHERE key = 'max_zoom_color'",
        "UPDATE meta SET value = NULL WHERE key = 'synthesis_gain'",
        "UPDATE meta SET value = 1e9 WHERE key = 'synthesis_gain'",
        "UPDATE meta SET value = 1e30 WHERE key = 'height_max'",
        "UPDATE meta SET value = 100 WHERE key = 'height_min'",
        "DROP TABLE tile; CREATE VIEW tile AS WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i "
        "+ 1"
        " FROM n) SELECT 0 layer, 0 zoom, 0 row, 0 col, i body, 0 min, 0 max FROM n",
    };
    const fixture *f = *state;
    for (size_t i = 0; i < sizeof faults / sizeof faults[0]; i++) {
        write_small(f);
        sql(f, faults[i]);
        expect_refusal(f, ERR_FORMAT);
    }
}

static void long_texts_are_cut_at_a_character(void **state)
{
    const fixture *f = *state;
    write_small(f);
    sql(f, "UPDATE meta SET value = replace(hex(zeroblob(100)), '00', char(233) || char(10)) || 'x'"
           " WHERE key = 'name'");
    struct planet_file *file;
    assert_int_equal(planet_file_open(f->path, &file), OK);
    const char *name = planet_file_meta(file)->name;
    assert_int_equal(strlen(name), 63);
    assert_null(strchr(name, '\n'));
    planet_file_close(&file);
    sql(f,
        "UPDATE meta SET value = replace(hex(zeroblob(100)), '00', char(233)) WHERE key = 'name'");
    assert_int_equal(planet_file_open(f->path, &file), OK);
    assert_int_equal(strlen(planet_file_meta(file)->name), 62);
    planet_file_close(&file);
}

// A tile whose body is broken: one line that names path and tile, and the others are unharmed.
static void corrupt_tiles_are_named(void **state)
{
    static const char *const faults[] = {
        "UPDATE body SET data = x'0102' WHERE id = 1",
        "UPDATE body SET hash = hash + 1 WHERE id = 1",
        "UPDATE body SET data = 'text' WHERE id = 1",
        "UPDATE body SET data = zeroblob(0) WHERE id = 1",
        "UPDATE body SET data = zeroblob(8000000) WHERE id = 1",
        "DELETE FROM body WHERE id = 1",
    };
    const fixture *f = *state;
    static float heights[SAMPLES];
    for (size_t i = 0; i < sizeof faults / sizeof faults[0]; i++) {
        write_small(f);
        sql(f, faults[i]);
        struct planet_file *file;
        assert_int_equal(planet_file_open(f->path, &file), OK);
        lines = 0;
        tile_id broken = {LAYER_HEIGHT, 3, 4, 2}, whole = {LAYER_HEIGHT, 0, 0, 1};
        assert_int_equal(planet_file_read_height(file, broken, heights), ERR_FORMAT);
        assert_int_equal(lines, 1);
        assert_non_null(strstr(last_line, f->path));
        assert_non_null(strstr(last_line, "height/3/4/2"));
        assert_int_equal(planet_file_read_height(file, whole, heights), OK);
        planet_file_close(&file);
    }
    write_small(f);
    sql(f, "UPDATE tile SET min = 5, max = 1e39 WHERE zoom = 0");
    struct planet_file *file;
    float min, max;
    assert_int_equal(planet_file_open(f->path, &file), OK);
    assert_int_equal(planet_file_read_range(file, (tile_id){LAYER_HEIGHT, 0, 0, 0}, &min, &max),
                     ERR_FORMAT);
    planet_file_close(&file);
}

// Bytes of the database itself flipped: opening and reading everything may fail, never worse.
static void flipped_bytes_are_survived(void **state)
{
    const fixture *f = *state;
    static float heights[SAMPLES];
    struct check_random random = {11};
    write_small(f);
    long size = size_of(f->path);
    for (int k = 0; k < 150; k++) {
        write_small(f);
        int fd = open(f->path, O_RDWR);
        for (int flips = 0; flips < 4; flips++) {
            uint64_t r = check_random_u64(&random);
            char byte = (char)(r >> 40);
            assert_int_equal(pwrite(fd, &byte, 1, (long)(r % (uint64_t)size)), 1);
        }
        close(fd);
        struct planet_file *file;
        if (planet_file_open(f->path, &file)) continue;
        for (int col = 0; col < 16; col++)
            planet_file_read_height(file, (tile_id){LAYER_HEIGHT, 3, 4, col}, heights);
        planet_file_close(&file);
    }
}

static tile_id listed[32];

static void list_one(void *user, tile_id id)
{
    listed[(*(int *)user)++] = id;
}

static void listing_is_sorted_and_on_the_grid(void **state)
{
    const fixture *f = *state;
    write_small(f);
    sql(f, "INSERT INTO tile VALUES(0, 3, 4, 16, 1, 0, 0), (0, 3, 8, 0, 1, 0, 0),"
           " (0, 25, 0, 0, 1, 0, 0), (0, -1, 0, 0, 1, 0, 0), (0, 3, 4, 4294967296, 1, 0, 0)");
    struct planet_file *file;
    int count = 0;
    assert_int_equal(planet_file_open(f->path, &file), OK);
    assert_int_equal(planet_file_list(file, LAYER_HEIGHT, list_one, &count), OK);
    assert_int_equal(count, 18);
    assert_true(tile_id_equal(listed[0], (tile_id){LAYER_HEIGHT, 0, 0, 0}));
    for (int i = 2; i < 18; i++)
        assert_true(tile_id_equal(listed[i], (tile_id){LAYER_HEIGHT, 3, 4, i - 2}));
    planet_file_close(&file);
}

static void paths_with_odd_characters_work(void **state)
{
    fixture odd = *(fixture *)*state;
    snprintf(odd.path, sizeof odd.path, "%s/a b?c#d%%41'\".planet", odd.dir);
    write_small(&odd);
    struct planet_file *file;
    assert_int_equal(planet_file_open(odd.path, &file), OK);
    planet_file_close(&file);
}

static void *read_many(void *file)
{
    float *heights = malloc(SAMPLES * sizeof *heights);
    long bad = 0;
    for (int k = 0; k < 64; k++) {
        int col = k % 16;
        bad += planet_file_read_height(file, (tile_id){LAYER_HEIGHT, 3, 4, col}, heights) != OK;
        bad += heights[9] != (col % 2 ? -5.0f : 10.0f);
    }
    free(heights);
    return (void *)bad;
}

static void threads_read_at_once(void **state)
{
    const fixture *f = *state;
    write_small(f);
    struct planet_file *file;
    assert_int_equal(planet_file_open(f->path, &file), OK);
    pthread_t threads[4];
    for (int i = 0; i < 4; i++) pthread_create(&threads[i], NULL, read_many, file);
    for (int i = 0; i < 4; i++) {
        void *bad;
        pthread_join(threads[i], &bad);
        assert_null(bad);
    }
    planet_file_close(&file);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, setup, teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(what_is_written_is_read),
        TEST(identical_bodies_are_stored_once),
        TEST(pixels_and_missing_samples),
        TEST(resume_goes_on_with_the_same_sources_only),
        TEST(a_kill_loses_no_committed_tile),
        TEST(a_second_writer_is_refused),
        TEST(a_finished_file_needs_no_write_access),
        TEST(unwritable_places_are_refused),
        TEST(missing_empty_and_foreign_files_are_refused),
        TEST(truncated_files_are_refused),
        TEST(earlier_versions_are_read),
        TEST(other_versions_are_refused),
        TEST(missing_tables_and_absurd_values_are_refused),
        TEST(long_texts_are_cut_at_a_character),
        TEST(corrupt_tiles_are_named),
        TEST(flipped_bytes_are_survived),
        TEST(listing_is_sorted_and_on_the_grid),
        TEST(paths_with_odd_characters_work),
        TEST(threads_read_at_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
