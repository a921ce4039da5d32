// perigee compare --modes: its tables say what single compares and renders say, equal triangles and
// equal errors are equal and made again by the options it names, flicker is nothing where nothing
// changes, Ctrl-C keeps what is done, and each fault is exit status 1 and one line. Fails when
// broken: views not begun anew (rows then depend on those before), the judge's picture of the view
// before, sizes not set again after the search, flicker against one moment's judge only.
#include "app/compare_run.h"

#include <cjson/cJSON.h>
#include <signal.h>
#include <stdbool.h>
#include <sys/wait.h>
#include <unistd.h>

#include "perigee.h"

#define SIZE "-q --size 96x72 --zoom 3 "

#define HILLS "hills.planet " SIZE
#define ROUGH "rough.planet -q --size 120x90 --zoom stored --no-synthesis "

#define THREE "--modes spherical,planar,grid "
static const char *const modes[] = {"spherical", "planar", "grid"};
enum { MODES = sizeof modes / sizeof *modes };

static const struct {
    const char *name, *camera;
} views[] = {{"hills", "20,10,9000,30,-12,0,60"}, {"a \\\"globe\\\", far", "40,30,2e7,0,-90,0,50"}};

// Heights without any order, 1 degree apart: an error in every pixel.
static void make_rough(void)
{
    struct check_random random = {7};
    FILE *f = fopen("rough.asc", "w");
    assert_non_null(f);
    fputs("ncols 360\nnrows 180\nxllcorner -180\nyllcorner -90\ncellsize 1\n", f);
    for (int i = 0; i < 360 * 180; i++) fprintf(f, "%.0f ", check_random_range(&random, 0, 6000));
    assert_int_equal(fclose(f), 0);
    char text[TEXT_SIZE];
    read_text("globe.prj", text);
    write_text("rough.prj", text);
    expect_good("import --quiet --height rough.asc --name Rough -o rough.planet");
}

static int set_up(void **state)
{
    if (run_begin(state)) return -1;
    make_rough();
    write_text("views.json",
               "{\"name\":\"Two\",\"views\":[{\"name\":\"hills\",\"lat\":20,\"lon\":10,"
               "\"alt\":9000,\"heading\":30,\"pitch\":-12},{\"name\":\"a \\\"globe\\\", far\","
               "\"lat\":40,\"lon\":30,\"alt\":2e7,\"heading\":0,\"pitch\":-90,\"fov\":50}]}");
    write_text("below.json", "{\"views\":[{\"name\":\"under\",\"lat\":20,\"lon\":10,\"alt\":5,"
                             "\"heading\":30,\"pitch\":-12}]}");
    write_text("bad.json", "{\"views\":[{\"name\":\"north\",\"lat\":120,\"lon\":10,\"alt\":5,"
                           "\"heading\":30,\"pitch\":-12}]}");
    write_text("empty.json", "{\"views\":[]}");
    write_text("still.json",
               "{\"keys\":[{\"time\":0,\"lat\":20,\"lon\":10,\"alt\":9000,\"heading\":30,"
               "\"pitch\":-12},{\"time\":4,\"lat\":20,\"lon\":10,\"alt\":9000,\"heading\":30,"
               "\"pitch\":-12}]}");
    if (run("render hills.planet -q --size 8x8 -o probe.png") == 0) return 0;
    print_message("no OpenGL 4.5 here, nothing tested: %s", err);
    exit(77);
}

// The row of a view and a mode.
static int row_of(int view, int mode)
{
    return view * MODES + mode;
}

static void check_same(const char *table, int row, const char *other, const char *title)
{
    double a = csv_number(table, row, title), b = csv_number(other, 0, title);
    if (isnan(a) && isnan(b)) return;
    if (a != b) fail_msg("%s, row %d: %s is %.12g, alone %.12g", table, row, title, a, b);
}

// Of the one line of JSON that render writes.
static double stats_number(const char *path, const char *name)
{
    char text[TEXT_SIZE];
    read_text(path, text);
    cJSON *root = cJSON_Parse(text);
    double value = cJSON_GetNumberValue(cJSON_GetObjectItem(root, name));
    cJSON_Delete(root);
    return value;
}

static void test_tables_agree(void **state)
{
    (void)state;
    static const char *const titles[] = {
        "lat",          "alt",      "ground",           "silhouette",       "missing",
        "extra",        "edges_a",  "geometric_px_rms", "geometric_px_max", "geometric_px_p999",
        "limb_px_mean", "zoom_low", "psnr_db"};
    static char json[1 << 18], line[512];
    expect_good("compare " HILLS THREE "--views views.json --repeats 1 "
                "--csv all.csv --json all.json");
    assert_non_null(strstr(out, "2 views; medians"));
    FILE *f = fopen("all.json", "r");
    json[fread(json, 1, sizeof json - 1, f)] = '\0';
    fclose(f);
    cJSON *root = cJSON_Parse(json), *rows = cJSON_GetObjectItem(root, "rows");
    assert_int_equal(cJSON_GetArraySize(rows), 2 * MODES);
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < MODES; k++) {
            int row = row_of(i, k);
            snprintf(line, sizeof line, "compare " HILLS "--a %s --camera %s --csv one.csv",
                     modes[k], views[i].camera);
            expect_good(line);
            for (size_t t = 0; t < sizeof titles / sizeof *titles; t++)
                check_same("all.csv", row, "one.csv", titles[t]);
            snprintf(line, sizeof line,
                     "render hills.planet -q --size 96x72 --mode %s --camera %s --samples 1 "
                     "--stats s.json -o x.png",
                     modes[k], views[i].camera);
            expect_good(line);
            check_near(csv_number("all.csv", row, "triangles_drawn"),
                       stats_number("s.json", "triangles_drawn"), 0);
            check_near(csv_number("all.csv", row, "gpu_bytes"), stats_number("s.json", "gpu_bytes"),
                       0);
            assert_string_equal(csv_text("all.csv", row, "mode"), modes[k]);
            assert_true(csv_number("all.csv", row, "gpu_time") > 0);
            assert_true(isnan(csv_number("all.csv", row, "flicker_px_rms")));
            cJSON *object = cJSON_GetArrayItem(rows, row);
            check_near(cJSON_GetNumberValue(
                           cJSON_GetObjectItem(cJSON_GetObjectItem(object, "geometric_px"), "rms")),
                       csv_number("all.csv", row, "geometric_px_rms"), 1e-9);
        }
    snprintf(line, sizeof line, "compare " HILLS THREE "--camera %s --csv alone.csv",
             views[1].camera);
    expect_good(line);
    for (int k = 0; k < MODES; k++) // nothing was loaded before
        check_near(csv_number("all.csv", row_of(1, k), "bytes_filled"),
                   csv_number("alone.csv", k, "bytes_filled"), 0);
    check_near(csv_number("all.csv", 0, "gpu_time"), 1, 0);
    assert_string_equal(csv_text("all.csv", MODES, "view"), "a \"globe\", far");
    cJSON_Delete(root);
}

// The table of modes is perigee.h's, in its order.
static void test_all(void **state)
{
    (void)state;
    const char *name;
    int count = 0;
    expect_good("compare " HILLS "--modes all --repeats 0 --csv all.csv");
    for (; (name = perigee_mode_name((enum perigee_mode)count)); count++)
        assert_string_equal(csv_text("all.csv", count, "mode"), name);
    char text[TEXT_SIZE];
    read_text("all.csv", text);
    assert_int_equal(count_lines(text), 1 + count);
    assert_true(isnan(csv_number("all.csv", 0, "gpu_time")));
    expect_good("compare " HILLS "--modes grid,spherical --repeats 0 --csv two.csv");
    assert_string_equal(csv_text("two.csv", 0, "mode"), "grid");
    assert_string_equal(csv_text("two.csv", 1, "mode"), "spherical");
    read_text("two.csv", text);
    assert_int_equal(count_lines(text), 1 + 2);
}

// A judge that is a mode: against itself nothing differs.
static void test_judge(void **state)
{
    (void)state;
    expect_good("compare hills.planet -q --size 96x72 --camera 20,10,9000,30,-12,0,60 " THREE
                "--b planar --repeats 0 --csv j.csv");
    check_near(csv_number("j.csv", 1, "geometric_all_px_max"), 0, 0);
    check_near(csv_number("j.csv", 1, "mse"), 0, 0);
    assert_true(csv_number("j.csv", 0, "geometric_px_max") > 0);
}

// Every mode is within the tolerance that the table states, and made again by the options it names.
static void check_equal(const char *planet, const char *camera, const char *what, const char *title,
                        double goal)
{
    static char line[1024];
    snprintf(line, sizeof line,
             "compare %s --camera %s " THREE "--repeats 0 --equal %s --csv equal.csv", planet,
             camera, what);
    expect_good(line);
    for (int k = 0; k < MODES; k++) {
        double value = csv_number("equal.csv", k, title);
        print_message("%-16s %-10s: %g of %g, size %g\n", what, modes[k], value,
                      csv_number("equal.csv", k, "goal"), csv_number("equal.csv", k, "size"));
        check_near(csv_number("equal.csv", k, "goal"), goal, 0);
        check_near(value, goal, 0.1 * goal);
        check_near(csv_number("equal.csv", k, "reached"), 1, 0);
        snprintf(line, sizeof line,
                 "compare %s --camera %s --modes %s --repeats 0 %s --csv again.csv", planet, camera,
                 modes[k], csv_text("equal.csv", k, "options"));
        expect_good(line);
        check_same("equal.csv", k, "again.csv", title);
        check_same("equal.csv", k, "again.csv", "gpu_bytes");
    }
}

static void test_equal(void **state)
{
    (void)state;
    check_equal(HILLS, views[0].camera, "triangles=20000", "triangles_drawn", 20000);
    check_equal(ROUGH, "20,10,1e6,30,-50,0,60", "error=0.075", "geometric_px_p999", 0.075);
}

// Without a value the goal is the first mode's, at each view of a file anew.
static void test_equal_to_first(void **state)
{
    (void)state;
    expect_good("compare " HILLS THREE "--views views.json --repeats 0 --csv all.csv");
    expect_good("compare " HILLS THREE "--views views.json --repeats 0 --equal triangles "
                "--csv equal.csv");
    for (int row = 0; row < 2 * MODES; row++) {
        double goal = csv_number("equal.csv", row, "goal");
        check_near(goal, csv_number("all.csv", row / MODES * MODES, "triangles_drawn"), 0);
        check_near(csv_number("equal.csv", row, "triangles_drawn"), goal, 0.1 * goal);
    }
    check_near(csv_number("equal.csv", 0, "size"), 1, 0);
    assert_non_null(strstr(out, "2 of 2"));
}

// What cannot be reached is said; the row is of the nearest there is, not of the last one tried.
static void test_out_of_reach(void **state)
{
    (void)state;
    expect_good("compare " HILLS "--modes grid --camera 20,10,9000,30,-12,0,60 --repeats 0 "
                "--equal triangles=100 --csv far.csv");
    check_near(csv_number("far.csv", 0, "reached"), 0, 0);
    assert_non_null(strstr(out, "* not reached"));
    assert_non_null(strstr(out, "0.0312*"));
    // Between two steps of the rings that are a factor of three apart the default is nearest.
    expect_good("compare " HILLS "--modes spherical --camera 20,10,9000,30,-12,0,60 --repeats 0 "
                "--equal triangles=3000 --csv far.csv");
    check_near(csv_number("far.csv", 0, "reached"), 0, 0);
    expect_good("compare " HILLS "--modes spherical --camera 20,10,9000,30,-12,0,60 --repeats 0 "
                "--csv again.csv");
    check_near(csv_number("far.csv", 0, "size"), 1, 0);
    check_same("far.csv", 0, "again.csv", "triangles_drawn");
    check_same("far.csv", 0, "again.csv", "geometric_px_rms");
}

// A camera that stands still does not flicker; one that moves does, by less than its own errors at
// both moments allow.
static void test_flicker(void **state)
{
    (void)state;
    expect_good("compare " HILLS THREE "--path still.json --frames 2 --repeats 0 "
                "--csv still.csv");
    for (int row = 0; row < 2 * MODES; row++) {
        check_near(csv_number("still.csv", row, "flicker_px_max"), 0, 0);
        check_near(csv_number("still.csv", row, "flicker_color_max"), 0, 0);
        check_near(csv_number("still.csv", row, "bytes_step"), 0, 0);
    }
    expect_good("compare " HILLS THREE "--path path.json --frames 3 --fps 5 "
                "--repeats 0 --csv f.csv");
    assert_non_null(strstr(out, "flicker: change in 0.2 s of flight"));
    for (int row = 0; row < 3 * MODES; row++) {
        double moved = csv_number("f.csv", row, "flicker_px_max");
        check_near(csv_number("f.csv", row, "time_s"), row / MODES, 1e-9);
        assert_true(moved > 0 && moved < 2);
        assert_true(csv_number("f.csv", row, "flicker_color_rms") > 0);
    }
}

static void test_faults(void **state)
{
    (void)state;
    static const struct {
        const char *line, *words;
    } faults[] = {
        {"compare hills.planet --modes hexagonal", "'hexagonal' is not a mode (spherical, planar"},
        {"compare hills.planet --modes spherical,reference", "'reference' is not a mode"},
        {"compare hills.planet --modes grid,", "'' is not a mode"},
        {"compare hills.planet --modes all,grid", "'all' is not a mode"},
        {"compare hills.planet --modes grid,planar,grid", "'grid' stands there twice"},
        {"compare hills.planet --modes all --a grid", "--modes: not with --a"},
        {"compare hills.planet --modes all -o x", "--modes: not with -o"},
        {"compare hills.planet --modes all --picture x.png", "--modes: not with --picture"},
        {"compare hills.planet --modes all --samples 2", "--modes: not with --samples"},
        {"compare hills.planet --modes all --b photo.png", "photo.png: neither a mode"},
        {"compare hills.planet --modes all --views views.json --lat 3",
         "--views: not with --camera"},
        {"compare hills.planet --modes all --views views.json --path path.json",
         "--views: not with --path"},
        {"compare hills.planet --views views.json", "--views goes with --modes"},
        {"compare hills.planet --equal error", "--equal goes with --modes"},
        {"compare hills.planet --repeats 3", "--repeats goes with --modes"},
        {"compare hills.planet --fps 3", "--fps goes with --modes"},
        {"compare hills.planet --modes all --equal size", "--equal size: not triangles"},
        {"compare hills.planet --modes all --equal error=0", "--equal error=0: not"},
        {"compare hills.planet --modes all --equal triangles=many", "triangles=many: not"},
        {"compare hills.planet --modes all --repeats -1", "--repeats -1: not in 0..1000"},
        {"compare hills.planet --modes all --views empty.json", "empty.json: \"views\" is not"},
        {"compare hills.planet --modes all --views nowhere.json", "nowhere.json"},
        {"compare hills.planet --modes all --views bad.json",
         "bad.json: view 1, 'north': \"lat\" is 120"},
        {"compare -q hills.planet --modes all --views below.json",
         "below.json: view 'under': \"alt\" 5 is below the terrain"},
        {"compare missing.planet --modes all", "missing.planet"},
        {"compare hills.planet --modes all --csv nowhere/c.csv", "nowhere/c.csv"},
    };
    for (size_t i = 0; i < sizeof faults / sizeof *faults; i++)
        expect_fault(faults[i].line, faults[i].words);
}

// Ctrl-C ends with 130; the tables hold the frames that are done.
static void test_interrupt(void **state)
{
    (void)state;
    pid_t child = fork();
    if (child == 0) {
        if (!freopen("out.txt", "w", stdout) || !freopen("err.txt", "w", stderr)) _exit(126);
        execl(PERIGEE_PROGRAM, PERIGEE_PROGRAM, "compare", "-q", "hills.planet", "--modes",
              "spherical,planar,grid", "--path", "path.json", "--frames", "5000", "--size", "32x24",
              "--repeats", "0", "--csv", "long.csv", (char *)NULL);
        _exit(127);
    }
    for (int i = 0; i < 1200; i++, usleep(50000)) {
        read_text("out.txt", out);
        if (strstr(out, "frame 2")) break;
    }
    int ended = 0;
    kill(child, SIGINT);
    assert_int_equal(waitpid(child, &ended, 0), child);
    assert_true(WIFEXITED(ended));
    assert_int_equal(WEXITSTATUS(ended), 130);
    read_text("err.txt", err);
    assert_non_null(strstr(err, "interrupted after"));
    read_text("long.csv", out);
    assert_true(count_lines(out) >= 1 + 3 * MODES);
    assert_int_equal((count_lines(out) - 1) % MODES, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_tables_agree),   cmocka_unit_test(test_all),
        cmocka_unit_test(test_judge),          cmocka_unit_test(test_equal),
        cmocka_unit_test(test_equal_to_first), cmocka_unit_test(test_out_of_reach),
        cmocka_unit_test(test_flicker),        cmocka_unit_test(test_faults),
        cmocka_unit_test(test_interrupt),
    };
    return cmocka_run_group_tests(tests, set_up, run_end);
}
