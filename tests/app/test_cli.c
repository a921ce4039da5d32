// The program itself: what it answers without a GPU, and that each fault is exit status 1 and one
// line on standard error that names the thing. A small planet is imported through the program and
// looked at.
#include "check.h"

#include <fcntl.h>
#include <ftw.h>
#include <signal.h>
#include <stdbool.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "app/image_png.h"

enum { TEXT_SIZE = 1 << 16, MAX_ARGS = 40 };

// What a run of the program said and how it ended.
struct answer {
    int status; // exit status, -1: ended by a signal
    char out[TEXT_SIZE], err[TEXT_SIZE];
};

static struct answer answer;
static char folder[] = "cli-XXXXXX";
static bool gpu;         // an OpenGL 4.5 is here
static rlim_t file_most; // bytes the program may write to a file, as on a full disk; 0: any

// A file into TEXT_SIZE characters, with a zero after it; what does not fit is left out.
static size_t read_bytes(const char *path, char *text)
{
    FILE *f = fopen(path, "rb");
    size_t n = f ? fread(text, 1, TEXT_SIZE - 1, f) : 0;
    text[n] = '\0';
    if (f) fclose(f);
    return n;
}

static void redirect(const char *path, int to)
{
    int f = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0666);
    if (f < 0 || dup2(f, to) < 0) _exit(126);
}

// Runs the program with the words of `line`, without a display. "NAME=VALUE" words at the front go
// to its environment.
static void run(const char *line)
{
    char copy[1024], *argv[MAX_ARGS + 1] = {0};
    int argc = 0;
    snprintf(copy, sizeof copy, "perigee %s", line);
    for (char *word = strtok(copy, " "); word && argc < MAX_ARGS; word = strtok(NULL, " "))
        argv[argc++] = word;
    pid_t child = fork();
    if (child == 0) {
        unsetenv("DISPLAY");
        unsetenv("WAYLAND_DISPLAY");
        int first = 1;
        for (; argv[first] && strchr(argv[first], '=') && argv[first][0] != '-'; first++)
            putenv(argv[first]);
        argv[first - 1] = argv[0];
        redirect("out.txt", STDOUT_FILENO);
        redirect("err.txt", STDERR_FILENO);
        signal(SIGXFSZ, SIG_IGN);
        if (file_most) setrlimit(RLIMIT_FSIZE, &(struct rlimit){file_most, file_most});
        execv(PERIGEE_PROGRAM, argv + first - 1);
        _exit(127);
    }
    int state = 0;
    assert_int_equal(waitpid(child, &state, 0), child);
    answer.status = WIFEXITED(state) ? WEXITSTATUS(state) : -1;
    read_bytes("out.txt", answer.out);
    read_bytes("err.txt", answer.err);
}

static int count_lines(const char *text)
{
    int count = 0;
    for (; *text; text++) count += *text == '\n';
    return count;
}

static void expect_good(const char *line)
{
    run(line);
    if (answer.status != 0) fail_msg("'%s': status %d: %s", line, answer.status, answer.err);
}

static void expect_fault(const char *line, const char *words)
{
    run(line);
    if (answer.status != 1) fail_msg("'%s': status %d, not 1: %s", line, answer.status, answer.err);
    if (count_lines(answer.err) != 1) fail_msg("'%s': not one line: %s", line, answer.err);
    if (!strstr(answer.err, words)) fail_msg("'%s': '%s' is not in: %s", line, words, answer.err);
    if (strncmp(answer.err, "perigee: error: ", 16) != 0) fail_msg("'%s': %s", line, answer.err);
    if (answer.out[0]) fail_msg("'%s': standard output: %s", line, answer.out);
}

static void write_text(const char *path, const char *text)
{
    FILE *f = fopen(path, "w");
    assert_non_null(f);
    fputs(text, f);
    assert_int_equal(fclose(f), 0);
}

// A 72 x 36 grid of the whole globe: hills of 0 to 2000 m.
static void write_raster(void)
{
    FILE *f = fopen("globe.asc", "w");
    assert_non_null(f);
    fputs("ncols 72\nnrows 36\nxllcorner -180\nyllcorner -90\ncellsize 5\n", f);
    for (int row = 0; row < 36; row++)
        for (int col = 0; col < 72; col++)
            fprintf(f, "%.1f%c", 1000 * (1 + sin(row * M_PI / 18) * sin(col * M_PI / 12)),
                    col == 71 ? '\n' : ' ');
    assert_int_equal(fclose(f), 0);
    static const char wgs84[] =
        "GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS 84\",6378137,298.257223563]],"
        "PRIMEM[\"Greenwich\",0],UNIT[\"degree\",0.0174532925199433]]";
    write_text("globe.prj", wgs84);
    write_text("empty.prj", wgs84);
}

static char file_data[1 << 22];

static size_t load(const char *path)
{
    FILE *f = fopen(path, "rb");
    assert_non_null(f);
    size_t n = fread(file_data, 1, sizeof file_data, f);
    fclose(f);
    return n;
}

static void save(const char *path, size_t size)
{
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    fwrite(file_data, 1, size, f);
    assert_int_equal(fclose(f), 0);
}

static void truncate_copy(const char *from, const char *to, size_t keep)
{
    size_t n = load(from);
    save(to, n < keep ? n : keep);
}

// The same planet as if by a later program: SQLite keeps user_version in bytes 60 to 63.
static void future_copy(const char *from, const char *to)
{
    size_t n = load(from);
    file_data[63] = 99;
    save(to, n);
}

// One bit other in each body of a tile: bodies of heights begin with OpenEXR's magic number.
static int corrupt_copy(const char *from, const char *to)
{
    size_t n = load(from);
    int bodies = 0;
    for (size_t i = 0; i + 400 < n; i++) {
        if (memcmp(file_data + i, "PGL1", 4) != 0) continue;
        file_data[i + 200] ^= 4;
        bodies++;
    }
    save(to, n);
    return bodies;
}

static int set_up(void **state)
{
    (void)state;
    if (!mkdtemp(folder) || chdir(folder) != 0) return -1;
    write_raster();
    write_text("one.asc", "ncols 1\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 5\n7\n");
    write_text("empty.asc", "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 5\n"
                            "NODATA_value -9999\n-9999 -9999\n-9999 -9999\n");
    write_text("pixel.pgm", "P2\n2 2\n255\n1 2 3 4\n");
    write_text("bad.json", "{\n\"keys\": [,]}");
    write_text(
        "short.json",
        "{\"keys\":[{\"time\":0,\"lat\":0,\"lon\":0,\"alt\":5e6,\"heading\":0,\"pitch\":-90},"
        "{\"time\":1,\"lat\":10,\"lon\":0,\"aboveGround\":1e6,\"heading\":0,\"pitch\":-80}]}");
    write_text(
        "cold.json",
        "{\"keys\":[{\"time\":0,\"lat\":95,\"lon\":0,\"alt\":5,\"heading\":0,\"pitch\":0}]}");
    write_text("flat.json", "{\"equatorialRadius\":1000,\"polarRadius\":10}");
    write_text("atlas-relief-metres.csv", "no table\n");
    write_text("not.planet", "This is no planet file.\n");
    write_text("empty.planet", "");
    mkdir("folder.png", 0777);
    expect_good(
        "import --quiet --height globe.asc --name Hills --attribution Nobody -o hills.planet");
    assert_string_equal(answer.err, "");
    run("render -q hills.planet --size 16x16 -o probe.png");
    gpu = !strstr(answer.err, "no EGL") && !strstr(answer.err, "no OpenGL");
    truncate_copy("hills.planet", "cut.planet", 5000);
    truncate_copy("hills.planet", "head.planet", 60);
    future_copy("hills.planet", "future.planet");
    return 0;
}

static int remove_one(const char *path, const struct stat *info, int kind, struct FTW *at)
{
    (void)info;
    (void)kind;
    (void)at;
    return remove(path);
}

static int tear_down(void **state)
{
    (void)state;
    return chdir("..") != 0 || nftw(folder, remove_one, 16, FTW_DEPTH | FTW_PHYS) != 0;
}

// Without a GPU, a display or a home, and in a moment.
static void test_help(void **state)
{
    (void)state;
    static const char *const lines[] = {
        "--help",    "-h",         "help",          "--version",   "view --help",
        "render -h", "fly --help", "import --help", "info --help",
    };
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; i++) {
        char line[128];
        snprintf(line, sizeof line, "HOME= __EGL_VENDOR_LIBRARY_DIRS=none %s", lines[i]);
        expect_good(line);
        if (answer.err[0]) fail_msg("'%s': %s", line, answer.err);
        if (!strstr(answer.out, "erigee")) fail_msg("'%s' printed: %s", line, answer.out);
    }
    expect_good("render --help");
    assert_non_null(strstr(answer.out, "--lat DEG"));
    assert_non_null(strstr(answer.out, "Examples:"));
    assert_null(strstr(answer.out, "--path"));
}

static const struct {
    const char *line, *words;
} faults[] = {
    {"explode", "'explode'"},
    {"--lat 5", "'--lat'"},
    {"render hills.planet --lat 91 -o a.png", "--lat 91"},
    {"render hills.planet --alt nan -o a.png", "--alt nan"},
    {"render hills.planet --alt -6400000 -o a.png", "--alt -6400000"},
    {"render hills.planet --fov 0 -o a.png", "--fov 0"},
    {"render hills.planet --fov 180 -o a.png", "--fov 180"},
    {"render hills.planet --camera 0,0,inf -o a.png", "0,0,inf"},
    {"render hills.planet --threads 0 -o a.png", "--threads 0"},
    {"render hills.planet --threads 99999999999999999999 -o a.png", "--threads 9999"},
    {"render hills.planet --size 99999x99999 -o a.png", "--size 99999x99999"},
    {"render hills.planet --size 0x5 -o a.png", "--size 0x5"},
    {"render hills.planet --lat 22 --lon 17 --alt -3 -o a.png", "--alt -3"},
    {"render hills.planet -o a.jpg", "a.jpg"},
    {"render hills.planet -o nowhere/a.png", "nowhere/a.png"},
    {"render hills.planet -o folder.png", "folder.png"},
    {"render hills.planet -o a.png --stats nowhere/s", "nowhere/s"},
    {"render hills.planet -o a.png --shader-dir nowhere", "--shader-dir nowhere"},
    {"render missing.planet -o a.png", "missing.planet"},
    {"render not.planet -o a.png", "not.planet"},
    {"render empty.planet -o a.png", "empty.planet"},
    {"render head.planet -o a.png", "head.planet"},
    {"render cut.planet -o a.png", "cut.planet"},
    {"render future.planet -o a.png", "future.planet: planet file of version 99"},
    {"info future.planet", "future.planet"},
    {"render . -o a.png", "."},
    {"fly hills.planet --path missing.json -o f/%d.png", "missing.json"},
    {"fly hills.planet --path bad.json -o f/%d.png", "bad.json: line 2"},
    {"fly hills.planet --path cold.json -o f/%d.png", "cold.json: key 1: \"lat\" is 95"},
    {"fly hills.planet --path short.json -o f.png", "f.png"},
    {"fly hills.planet --path short.json -o f.mp4", "video"},
    {"fly hills.planet --path short.json -o hills.planet/%d.png", "hills.planet"},
    {"fly hills.planet --path short.json -o f/%d.png --contact-sheet folder.png", "folder.png"},
    {"fly hills.planet --path short.json -o f/%d.png --start 2", "--start 2"},
    {"import --height missing.tif -o new.planet", "missing.tif"},
    {"import --height pixel.pgm -o new.planet", "pixel.pgm"},
    {"import --height empty.asc -o none.planet", "none.planet: the sources hold no data"},
    {"import --height one.asc -o new.planet", "one.asc"},
    {"import --height bad.json -o new.planet", "bad.json"},
    {"import --height globe.asc -o nowhere/new.planet", "nowhere/new.planet"},
    {"import --height globe.asc -o hills.planet", "hills.planet"},
    {"import --height globe.asc --body flat.json -o new.planet", "flat.json"},
    {"import --height globe.asc --body short.json -o new.planet", "short.json"},
    {"import --earth --atlas nowhere -o new.planet", "nowhere"},
    {"PERIGEE_DATA_DIR=. import --earth -o new.planet", "./atlas-relief-metres.csv"},
    {"info missing.planet", "missing.planet"},
    {"info not.planet", "not.planet"},
    {"PERIGEE_EARTH= HOME= XDG_DATA_HOME= info", "PERIGEE_EARTH"},
    {"view hills.planet", "display"},
};

static void test_faults(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof faults / sizeof faults[0]; i++)
        expect_fault(faults[i].line, faults[i].words);
    assert_int_equal(access("a.png", F_OK), -1);
    assert_int_equal(access("a.png.part", F_OK), -1);
    assert_int_equal(access("new.planet", F_OK), -1);
}

static void test_no_gpu(void **state)
{
    (void)state;
    run("__EGL_VENDOR_LIBRARY_FILENAMES=none __EGL_VENDOR_LIBRARY_DIRS=none render --quiet "
        "hills.planet -o a.png");
    assert_int_equal(answer.status, 1);
    if (count_lines(answer.err) != 1) fail_msg("not one line: %s", answer.err);
    assert_int_equal(access("a.png", F_OK), -1);
}

// Standard output and files that refuse to take what is written.
static void test_full_disk(void **state)
{
    (void)state;
    if (!gpu) skip();
    if (access("/dev/full", W_OK) != 0) skip();
    expect_fault("render --quiet hills.planet --size 32x32 -o c.png --stats /dev/full",
                 "/dev/full");
}

// What was imported before the disk was full is not lost.
static void test_full_disk_import(void **state)
{
    (void)state;
    file_most = 60000;
    expect_fault("import -q --height globe.asc --name Hills --attribution Nobody -o full.planet",
                 "full.planet");
    file_most = 0;
    assert_int_equal(access("full.planet", F_OK), -1);
    expect_good(
        "import -q --height globe.asc --name Hills --attribution Nobody -o full.planet --resume");
    expect_good("info full.planet");
}

static void test_full_disk_picture(void **state)
{
    (void)state;
    if (!gpu) skip();
    file_most = 1000;
    run("render -q hills.planet --size 64x64 -o full.png");
    file_most = 0;
    assert_int_equal(answer.status, 1);
    assert_non_null(strstr(answer.err, "full.png"));
    assert_int_equal(access("full.png", F_OK), -1);
}

// Is any pixel of the picture lit?
static bool lit(const char *path, int width, int height)
{
    size_t size = 3 * (size_t)width * (size_t)height;
    uint8_t *rgb = malloc(size);
    assert_non_null(rgb);
    assert_int_equal(image_png_read(path, width, height, rgb), 0);
    bool any = false;
    for (size_t i = 0; i < size; i++) any = any || rgb[i] > 40;
    free(rgb);
    return any;
}

// Mesa can be told to offer less; another driver does not listen.
static void test_old_gl(void **state)
{
    (void)state;
    if (!gpu) skip();
    run("MESA_GL_VERSION_OVERRIDE=3.3 render -q hills.planet --size 16x16 -o old.png");
    if (answer.status == 0) skip();
    assert_int_equal(answer.status, 1);
    assert_int_equal(count_lines(answer.err), 1);
    assert_non_null(strstr(answer.err, "OpenGL 4.5"));
    assert_int_equal(access("old.png", F_OK), -1);
}

// A corrupt tile is named and counted, and the picture is made.
static void test_corrupt(void **state)
{
    (void)state;
    if (!gpu) skip();
    assert_true(corrupt_copy("hills.planet", "corrupt.planet") > 0);
    expect_good("render -q corrupt.planet --size 64x48 --stats c.jsonl -o corrupt.png");
    assert_non_null(strstr(answer.err, "corrupt.planet: tile height/0/0/0"));
    assert_true(lit("corrupt.png", 64, 48));
    static char stats[TEXT_SIZE];
    read_bytes("c.jsonl", stats);
    assert_non_null(strstr(stats, "\"tiles_corrupt\":2"));
}

static void test_info(void **state)
{
    (void)state;
    expect_good("info hills.planet");
    assert_non_null(strstr(answer.out, "Hills"));
    assert_non_null(strstr(answer.out, "Nobody"));
    assert_non_null(strstr(answer.out, "6378137.000"));
    expect_good("info --json hills.planet");
    assert_non_null(strstr(answer.out, "\"equatorialRadius\":\t6378137"));
    assert_non_null(strstr(answer.out, "\"complete\":\ttrue"));
    assert_non_null(strstr(answer.out, "\"codec\":"));
    assert_non_null(strstr(answer.out, "\"tiles\":"));
}

static void test_render(void **state)
{
    (void)state;
    if (!gpu) skip();
    expect_good("render hills.planet --size 96x64 --stats s.jsonl -o a.png");
    assert_true(lit("a.png", 96, 64));
    assert_non_null(strstr(answer.err, "Nobody"));
    static char stats[TEXT_SIZE];
    read_bytes("s.jsonl", stats);
    assert_int_equal(count_lines(stats), 1);
    assert_non_null(strstr(stats, "\"triangles_drawn\":"));
    assert_non_null(strstr(stats, "\"missing\":0"));
    expect_good("render --quiet hills.planet --size 50x40 --above-ground 500 --pitch -20 -o b.exr");
    assert_string_equal(answer.err, "");
    struct stat info;
    assert_int_equal(stat("b.exr", &info), 0);
    assert_true(info.st_size > 1000);
}

// An incomplete picture is written, and its status says so.
static void test_timeout(void **state)
{
    (void)state;
    if (!gpu) skip();
    run("render --quiet hills.planet --size 32x32 --timeout 0 -o late.png");
    assert_int_equal(answer.status, 1);
    assert_int_equal(count_lines(answer.err), 1);
    assert_non_null(strstr(answer.err, "missing: "));
    assert_int_equal(access("late.png", F_OK), 0);
}

static void test_fly(void **state)
{
    (void)state;
    if (!gpu) skip();
    expect_good("fly hills.planet --path short.json --fps 3 --size 64x48 -o f/%03d.png "
                "--contact-sheet f/sheet.png "
                "--contact-grid 2x2");
    for (int i = 0; i < 4; i++) {
        char path[32];
        snprintf(path, sizeof path, "f/%03d.png", i);
        assert_true(lit(path, 64, 48));
    }
    assert_int_equal(access("f/004.png", F_OK), -1);
    assert_true(lit("f/sheet.png", 2 * 68 + 4, 2 * 52 + 4));
    // Resumed, only the frame that is gone and the one of another size are made.
    unlink("f/001.png");
    truncate_copy("f/000.png", "f/002.png", 20);
    expect_good("fly --quiet hills.planet --path short.json --fps 3 --size 64x48 -o f/%03d.png "
                "--resume --stats f.jsonl");
    static char stats[TEXT_SIZE];
    read_bytes("f.jsonl", stats);
    assert_int_equal(count_lines(stats), 2);
    assert_non_null(strstr(stats, "\"frame\":1,"));
    assert_non_null(strstr(stats, "\"frame\":2,"));
    assert_true(lit("f/001.png", 64, 48));
}

// The reference needs no GPU; its frames are the same when a flight goes on.
static void test_reference(void **state)
{
    (void)state;
    expect_good("render hills.planet --mode reference --size 40x30 -o ref.png");
    assert_non_null(strstr(answer.err, "by distance, within"));
    assert_true(lit("ref.png", 40, 30));
    expect_good("render hills.planet --mode reference --zoom stored --size 40x30 -o ref.exr");
    assert_non_null(strstr(answer.err, "heights of zoom"));
    assert_null(strstr(answer.err, "by distance"));
    expect_good("fly -q hills.planet --mode reference --path short.json --fps 2 --size 40x30 "
                "-o r/%d.png");
    static char first[TEXT_SIZE], again[TEXT_SIZE];
    size_t size = read_bytes("r/1.png", first);
    assert_true(lit("r/1.png", 40, 30));
    unlink("r/1.png");
    expect_good("fly -q hills.planet --mode reference --path short.json --fps 2 --size 40x30 "
                "-o r/%d.png --resume --threads 3");
    assert_int_equal(read_bytes("r/1.png", again), size);
    assert_memory_equal(first, again, size);
    run("fly -q hills.planet --mode reference --path short.json --stats s -o r/%d.png");
    assert_int_equal(answer.status, 1);
    assert_non_null(strstr(answer.err, "--stats"));
    run("render -q hills.planet --mode reference --zoom 24 -o never.png");
    assert_int_equal(answer.status, 1);
    assert_non_null(strstr(answer.err, "tiles of zoom 24"));
    assert_int_equal(access("never.png", F_OK), -1);
}

// The same flight gives the same files, whatever the number of workers.
static void test_same_frames(void **state)
{
    (void)state;
    if (!gpu) skip();
    static char one[TEXT_SIZE], eight[TEXT_SIZE];
    expect_good(
        "fly -q hills.planet --path short.json --fps 2 --size 64x48 -o one-%d.png --threads 1");
    expect_good(
        "fly -q hills.planet --path short.json --fps 2 --size 64x48 -o eight-%d.png --threads 8");
    for (int i = 0; i < 3; i++) {
        char path[32];
        snprintf(path, sizeof path, "one-%d.png", i);
        size_t size = read_bytes(path, one);
        snprintf(path, sizeof path, "eight-%d.png", i);
        assert_int_equal(read_bytes(path, eight), size);
        assert_in_range(size, 100, TEXT_SIZE - 2);
        assert_memory_equal(one, eight, size);
    }
}

// Ctrl-C ends a flight after a whole frame, with 130 and a way to go on.
static void test_interrupt(void **state)
{
    (void)state;
    if (!gpu) skip();
    pid_t child = fork();
    if (child == 0) {
        redirect("out.txt", STDOUT_FILENO);
        redirect("err.txt", STDERR_FILENO);
        execl(PERIGEE_PROGRAM, PERIGEE_PROGRAM, "fly", "-q", "hills.planet", "--path", "short.json",
              "--fps", "1000", "--size", "64x48", "-o", "long/%04d.png", (char *)NULL);
        _exit(127);
    }
    for (int i = 0; i < 600 && access("long/0001.png", F_OK) != 0; i++) usleep(100000);
    int ended = 0;
    kill(child, SIGINT);
    assert_int_equal(waitpid(child, &ended, 0), child);
    assert_true(WIFEXITED(ended));
    assert_int_equal(WEXITSTATUS(ended), 130);
    read_bytes("err.txt", answer.err);
    assert_int_equal(count_lines(answer.err), 1);
    assert_non_null(strstr(answer.err, "--resume"));
    assert_true(lit("long/0001.png", 64, 48));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_help),
        cmocka_unit_test(test_faults),
        cmocka_unit_test(test_no_gpu),
        cmocka_unit_test(test_old_gl),
        cmocka_unit_test(test_full_disk),
        cmocka_unit_test(test_full_disk_import),
        cmocka_unit_test(test_full_disk_picture),
        cmocka_unit_test(test_corrupt),
        cmocka_unit_test(test_info),
        cmocka_unit_test(test_render),
        cmocka_unit_test(test_timeout),
        cmocka_unit_test(test_fly),
        cmocka_unit_test(test_reference),
        cmocka_unit_test(test_same_frames),
        cmocka_unit_test(test_interrupt),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
