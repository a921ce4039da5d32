// perigee compare: a picture against itself and against the mode that made it has no error, tables
// agree with one another, flights have a row a frame, Ctrl-C keeps the rows that are made, and each
// fault is exit status 1 and one line.
#include "app/compare_run.h"

#include <cjson/cJSON.h>
#include <signal.h>
#include <stdbool.h>
#include <sys/wait.h>
#include <unistd.h>

#include "app/image_exr.h"
#include "app/image_png.h"

static bool gpu; // an OpenGL 4.5 is here

#define VIEW  "hills.planet -q --size 96x72 --camera 20,10,9000,30,-12,0,60"
#define SPACE "hills.planet -q --size 96x72 --camera 20,10,2e7,0,-90,0,50"

static int set_up(void **state)
{
    if (run_begin(state)) return -1;
    write_text("text.exr", "no picture\n");
    write_text("patch.asc",
               "ncols 2\nnrows 2\nxllcorner 30\nyllcorner 40\ncellsize 0.1\n7 8\n9 99\n");
    char prj[TEXT_SIZE];
    read_text("globe.prj", prj);
    write_text("patch.prj", prj);
    expect_good("import --quiet --height patch.asc -o patch.planet");
    gpu = run("render " VIEW " -o clipmap.exr") == 0;
    expect_good("render " VIEW " --mode reference -o truth.exr");
    expect_good("render " SPACE " --mode reference -o space.exr");
    expect_good("render hills.planet -q --size 64x48 --camera 20,10,9000,30,-12,0,60 "
                "--mode reference -o small.exr");
    return 0;
}

// A file and the mode that made it, and two modes of one kind: nothing differs.
static void test_no_difference(void **state)
{
    (void)state;
    static const char *const lines[] = {
        "compare --a truth.exr --b truth.exr --csv same.csv",
        "compare hills.planet -q --a truth.exr --b reference --csv same.csv",
        "compare hills.planet -q --a reference --b truth.exr --csv same.csv",
        "compare " VIEW " --a reference --b reference --csv same.csv",
        "compare " VIEW " --a spherical --b spherical --csv same.csv",
    };
    for (int i = 0; i < 5; i++) {
        if (i == 4 && !gpu) continue;
        expect_good(lines[i]);
        assert_true(csv_number("same.csv", 0, "ground") > 96 * 72 / 4.0);
        check_near(csv_number("same.csv", 0, "geometric_px_max"), 0, 0);
        check_near(csv_number("same.csv", 0, "geometric_all_px_max"), 0, 0);
        check_near(csv_number("same.csv", 0, "depth_m_max"), 0, 0);
        check_near(csv_number("same.csv", 0, "limb_px_max"), 0, 0);
        check_near(csv_number("same.csv", 0, "mse"), 0, 0);
        check_near(csv_number("same.csv", 0, "missing") + csv_number("same.csv", 0, "extra"), 0, 0);
        assert_non_null(strstr(out, "colour: equal in"));
    }
}

// The reference between its own samples: other ground, and the tables say which.
static void test_heights(void **state)
{
    (void)state;
    expect_good("compare hills.planet -q --a truth.exr --zoom stored --csv heights.csv");
    assert_null(strstr(out, "bicubic"));
    expect_good("compare hills.planet -q --a truth.exr --zoom stored --heights bicubic "
                "--csv curved.csv --json curved.json");
    assert_non_null(strstr(out, ", bicubic)"));
    assert_true(csv_number("heights.csv", 0, "geometric_px_rms") !=
                csv_number("curved.csv", 0, "geometric_px_rms"));
    char text[TEXT_SIZE];
    read_text("curved.json", text);
    assert_non_null(strstr(text, "\"bicubic\":\ttrue"));
    expect_good("render " VIEW " --mode reference --heights bicubic -v -o curved.exr");
    assert_non_null(strstr(err, ", bicubic"));
}

// Supersampled colours: the same geometry, other colours on both sides, and equal ones of one mode.
static void test_samples(void **state)
{
    (void)state;
    expect_good("compare " VIEW " --a reference --samples 2 --csv same.csv");
    assert_non_null(strstr(out, "the mean of 2 x 2 samples a pixel"));
    check_near(csv_number("same.csv", 0, "mse"), 0, 0);
    expect_fault("compare hills.planet -q --a truth.exr --samples 2", "truth.exr: has its colours");
    expect_fault("compare " VIEW " --size 4000x3000 --samples 5", "--samples 5");
    if (!gpu) return;
    expect_good("compare " VIEW " --zoom 3 --csv one.csv");
    expect_good("compare " VIEW " --zoom 3 --samples 3 --csv nine.csv");
    static const char *const same[] = {"ground", "geometric_px_rms", "depth_m_max", "limb_px_max"};
    for (int i = 0; i < 4; i++)
        check_near(csv_number("nine.csv", 0, same[i]), csv_number("one.csv", 0, same[i]), 0);
    double one = csv_number("one.csv", 0, "mse"), nine = csv_number("nine.csv", 0, "mse");
    print_message("colour: mse %.3g, of means of nine samples %.3g\n", one, nine);
    assert_true(nine > 0 && nine < 1.2 * one && nine != one);
}

// The clipmap against the reference, seen three ways: small errors, and the same in every table.
static void test_tables(void **state)
{
    (void)state;
    if (!gpu) skip();
    expect_good("compare " VIEW " --zoom 3 --csv c.csv --json c.json --picture c.png -o d");
    assert_non_null(strstr(out, "a: spherical\nb: reference (heights of zoom 3)"));
    assert_non_null(strstr(out, "geometric error, px"));
    assert_non_null(strstr(out, "without air"));
    double rms = csv_number("c.csv", 0, "geometric_px_rms");
    assert_true(rms > 0 && rms < 0.5);
    assert_true(csv_number("c.csv", 0, "psnr_db") > 20);
    char text[32];
    snprintf(text, sizeof text, "%.4g", rms);
    assert_non_null(strstr(out, text));
    static char json[TEXT_SIZE];
    read_text("c.json", json);
    cJSON *root = cJSON_Parse(json);
    cJSON *frame = cJSON_GetArrayItem(cJSON_GetObjectItem(root, "frames"), 0);
    cJSON *geometric = cJSON_GetObjectItem(frame, "geometric_px");
    check_near(cJSON_GetNumberValue(cJSON_GetObjectItem(geometric, "rms")), rms, 1e-10);
    check_near(cJSON_GetNumberValue(cJSON_GetObjectItem(frame, "ground")),
               csv_number("c.csv", 0, "ground"), 0);
    assert_non_null(strstr(cJSON_GetStringValue(cJSON_GetObjectItem(root, "psnr")), "log10"));
    cJSON_Delete(root);
    int width, height;
    assert_int_equal(image_png_size("c.png", &width, &height), 0);
    assert_true(width >= 3 * 96 && height > 72);
    assert_int_equal(image_png_size("d.png", &width, &height), 0);
    assert_int_equal(width * 1000 + height, 96072);
    FILE *f = fopen("d.exr", "rb");
    static char bytes[1 << 20];
    assert_non_null(f);
    size_t n = fread(bytes, 1, sizeof bytes, f);
    fclose(f);
    assert_non_null(memmem(bytes, n, "geometric_px", 12));
    assert_non_null(memmem(bytes, n, "camera.fov", 10));
}

// A side with air and one without differ in colour only: the sky's glow is not the judge's matter.
static void test_without_air(void **state)
{
    (void)state;
    if (!gpu) skip();
    expect_good("compare hills.planet -q --a clipmap.exr --b spherical --csv air.csv");
    check_near(csv_number("air.csv", 0, "geometric_all_px_max"), 0, 0);
    assert_true(csv_number("air.csv", 0, "mse") > 1e-6);
    assert_non_null(strstr(out, "colours of files are compared as they are"));
}

// A camera turned by half a pixel is half a pixel of error: the command's whole way on known
// ground.
static void test_known_error(void **state)
{
    (void)state;
    double half = atan(0.5 * 2 * tan(M_PI / 6) / 72) * 180 / M_PI;
    char line[256];
    snprintf(line, sizeof line,
             "render hills.planet -q --size 96x72 --camera 20,10,9000,30,%.12f,0,60 "
             "--mode reference -o turned.exr",
             -12 + half);
    expect_good(line);
    image_exr_file turned, truth;
    assert_int_equal(image_exr_read("turned.exr", &turned), 0);
    assert_int_equal(image_exr_read("truth.exr", &truth), 0);
    image_exr image = {.width = 96,
                       .height = 72,
                       .planes = {.z_m = turned.z_m},
                       .camera = truth.camera,
                       .planet = "Hills",
                       .attribution = "Nobody"};
    assert_int_equal(image_exr_write("shifted.exr", &image), 0);
    image_exr_file_deinit(&turned);
    image_exr_file_deinit(&truth);
    expect_good("compare --a shifted.exr --b truth.exr --csv shifted.csv");
    assert_non_null(strstr(out, "colour: not compared"));
    check_near(csv_number("shifted.csv", 0, "geometric_px_median"), 0.5, 0.1);
    check_near(csv_number("shifted.csv", 0, "geometric_px_max"), 0.5, 0.25);
    check_near(csv_number("shifted.csv", 0, "limb_px_mean"), 0.5, 0.5);
    assert_true(isnan(csv_number("shifted.csv", 0, "psnr_db")));
}

static void test_flight(void **state)
{
    (void)state;
    expect_good("compare hills.planet -q --size 48x36 --a reference --b reference --path path.json "
                "--frames 3 --csv f.csv --json f.json -o f --picture worst.png");
    assert_int_equal(count_lines(out), 2 + 3);
    static char csv[TEXT_SIZE];
    read_text("f.csv", csv);
    assert_int_equal(count_lines(csv), 1 + 3);
    for (int i = 0; i < 3; i++) {
        char name[32];
        check_near(csv_number("f.csv", i, "time_s"), i, 1e-9);
        check_near(csv_number("f.csv", i, "frame"), i, 0);
        snprintf(name, sizeof name, "f-%05d.exr", i);
        assert_int_equal(access(name, F_OK), 0);
    }
    check_near(csv_number("f.csv", 2, "lat"), 10, 1e-6);
    assert_int_equal(access("worst.png", F_OK), 0);
    expect_good("compare hills.planet -q --size 48x36 --a reference --b reference --path path.json "
                "--frames 1 --start 1 --csv f.csv");
    check_near(csv_number("f.csv", 0, "time_s"), 1, 1e-9);
}

static void test_faults(void **state)
{
    (void)state;
    static const struct {
        const char *line, *words;
    } faults[] = {
        {"compare hills.planet --a hexagonal", "hexagonal: neither a mode"},
        {"compare hills.planet --b photo.png", "photo.png: neither a mode"},
        {"compare --a missing.exr --b truth.exr", "missing.exr"},
        {"compare --a text.exr --b truth.exr", "text.exr: not an EXR"},
        {"compare --a truth.exr --b small.exr", "small.exr 64x48"},
        {"compare --a truth.exr --b space.exr", "camera.alt"},
        {"compare --a errors.exr --b truth.exr", "errors.exr: no channel Z"},
        {"compare hills.planet --a truth.exr --size 10x10", "--size 10x10"},
        {"compare hills.planet --a truth.exr --lat 5", "camera is that of the file"},
        {"compare hills.planet --a truth.exr --path path.json", "--path"},
        {"compare hills.planet --path path.json --lat 3", "--path path.json"},
        {"compare hills.planet --path missing.json", "missing.json"},
        {"compare -q hills.planet --path path.json --start 3", "--start 3"},
        {"compare hills.planet --frames 3", "--path"},
        {"compare hills.planet --frames 0", "--frames 0"},
        {"compare --a truth.exr --b truth.exr --zoom 3", "--zoom: only with"},
        {"compare missing.planet --a reference", "missing.planet"},
        {"compare " VIEW " --a reference --zoom 24", "zoom 24"},
        {"compare " VIEW " --a reference --alt -5", "--alt -5"},
        {"compare hills.planet --csv nowhere/c.csv", "nowhere/c.csv"},
        {"compare hills.planet --json nowhere/c.json", "nowhere/c.json"},
        {"compare hills.planet --picture c.jpg", "--picture c.jpg"},
        {"compare hills.planet -o nowhere/d", "nowhere/d"},
        {"compare hills.planet -o x --picture x.png", "x.png"},
        {"compare hills.planet more", "'more'"},
        {"compare -q patch.planet --a reference --size 48x36 --camera -20,10,9000,30,-12,0,60",
         "patch.planet: holds no heights that the camera over -20"},
    };
    expect_good("compare --a truth.exr --b truth.exr -o errors");
    for (size_t i = 0; i < sizeof faults / sizeof faults[0]; i++)
        expect_fault(faults[i].line, faults[i].words);
}

// A region's planet is judged where any of its heights is in sight.
static void test_region(void **state)
{
    (void)state;
    static const char *const cameras[] = {"40.1,30.1,20000,0,-90,0,60", "39.5,30.1,9000,0,-20,0,60",
                                          "39.2,30.9,4e5,0,-90,0,60", "40,30,9000,0,80,0,30"};
    for (int i = 0; i < 4; i++) {
        char line[256];
        snprintf(line, sizeof line,
                 "compare -q patch.planet --a reference --size 48x36 --camera %s", cameras[i]);
        expect_good(line);
    }
}

// Ctrl-C ends a flight with 130; the tables hold the frames that are done.
static void test_interrupt(void **state)
{
    (void)state;
    const char *mode = gpu ? "spherical" : "reference";
    pid_t child = fork();
    if (child == 0) {
        if (!freopen("out.txt", "w", stdout) || !freopen("err.txt", "w", stderr)) _exit(126);
        execl(PERIGEE_PROGRAM, PERIGEE_PROGRAM, "compare", "-q", "hills.planet", "--a", mode, "--b",
              mode, "--path", "path.json", "--frames", "5000", "--size", "32x24", "--csv",
              "long.csv", "-o", "long", (char *)NULL);
        _exit(127);
    }
    for (int i = 0; i < 600 && access("long-00002.png", F_OK) != 0; i++) usleep(50000);
    int ended = 0;
    kill(child, SIGINT);
    assert_int_equal(waitpid(child, &ended, 0), child);
    assert_true(WIFEXITED(ended));
    assert_int_equal(WEXITSTATUS(ended), 130);
    read_text("err.txt", err);
    assert_int_equal(count_lines(err), 1);
    assert_non_null(strstr(err, "interrupted after"));
    read_text("long.csv", out);
    assert_true(count_lines(out) >= 1 + 3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_heights),       cmocka_unit_test(test_samples),
        cmocka_unit_test(test_no_difference), cmocka_unit_test(test_tables),
        cmocka_unit_test(test_without_air),   cmocka_unit_test(test_known_error),
        cmocka_unit_test(test_flight),        cmocka_unit_test(test_region),
        cmocka_unit_test(test_faults),        cmocka_unit_test(test_interrupt),
    };
    return cmocka_run_group_tests(tests, set_up, run_end);
}
