// What the command line says of data, by what comes of it: the estimate of an import and its
// report, vertical datums, a raster shown as it is beside the planet made of it, and rasters laid
// over one another by opacity and order. Fails when broken: a datum that does not reach the rasters
// that follow it; opacity not read, or read as transparency; the first layer on top; a raster shown
// half a sample off.
#include "app/compare_run.h"

#include <unistd.h>

#include "app/image_exr.h"

#define LOOK "-q --no-synthesis --lat 12 --lon 20 --alt 1e5 --size 64x48 "

enum { PIXELS = 64 * 48 };

// A grid of degrees that is `value` everywhere.
static void write_level(const char *name, int cols, int rows, double west, double south,
                        double cell, double value)
{
    char path[64], wkt[TEXT_SIZE];
    snprintf(path, sizeof path, "%s.asc", name);
    FILE *f = fopen(path, "w");
    assert_non_null(f);
    fprintf(f, "ncols %d\nnrows %d\nxllcorner %.9f\nyllcorner %.9f\ncellsize %.9f\n", cols, rows,
            west, south, cell);
    for (int i = 0; i < cols * rows; i++) fprintf(f, "%.2f ", value);
    assert_int_equal(fclose(f), 0);
    read_text("globe.prj", wkt);
    snprintf(path, sizeof path, "%s.prj", name);
    write_text(path, wkt);
}

static void test_estimate(void **state)
{
    (void)state;
    unsigned long long tiles, samples, made;
    double file, seconds;
    char unit[8];
    expect_good("import --estimate --height globe.asc");
    if (sscanf(out,
               "tiles %llu samples %llu file about %lf %7[a-zA-Z], while it is made twice as much "
               "time about %lf core-seconds",
               &tiles, &samples, &file, unit, &seconds) != 5)
        fail_msg("%s", out);
    expect_good("import --height globe.asc -o reported.planet");
    const char *complete = strstr(err, "complete: ");
    assert_non_null(complete);
    assert_int_equal(sscanf(complete, "complete: %llu tiles", &made), 1);
    assert_int_equal(tiles, made);
    assert_int_equal(samples, made * 65536);
    FILE *f = fopen("reported.planet", "rb");
    assert_non_null(f);
    fseek(f, 0, SEEK_END);
    double bytes = (double)ftell(f);
    fclose(f);
    print_message("%.3g %s estimated, %.0f made\n", file, unit, bytes);
    assert_string_equal(unit, "kB");
    check_near(1000 * file / bytes, 1, 0.25); // pages of 8 kB in a small file
    expect_fault("import --estimate --height none.asc", "none.asc");
}

static double number_in(const char *json, const char *name)
{
    const char *at = strstr(json, name);
    if (!at) fail_msg("no %s in %s", name, json);
    at = strpbrk(at + strlen(name), "-0123456789");
    return at ? atof(at) : (double)NAN;
}

// 500 m about one of NGA's test points of EGM96, where the geoid is 43.575 m below the ellipsoid;
// in a degree it changes by less than 4 m.
static void test_vertical(void **state)
{
    (void)state;
    static const struct {
        const char *options;
        double height;
    } cases[] = {
        {"--vertical egm96 --height level.asc", 500 - 43.575},
        {"--height level.asc", 500},
        {"--height level.asc --vertical egm96", 500}, // of those that follow
        {"--vertical egm96 --vertical ellipsoid --height level.asc", 500},
        {"--vertical EPSG:5773 --height level.asc", 500 - 43.575},
    };
    write_level("level", 50, 50, 102.44873 - 0.5, 46.87432 - 0.5, 0.02, 500);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char line[256];
        snprintf(line, sizeof line, "import -q --force %s -o v.planet", cases[i].options);
        expect_good(line);
        expect_good("info --json v.planet");
        double tolerance = cases[i].height < 500 ? 4 : 0;
        check_near(number_in(out, "\"heightMin\""), cases[i].height, tolerance);
        check_near(number_in(out, "\"heightMax\""), cases[i].height, tolerance);
    }
    expect_fault("import -q --force --vertical sea --height level.asc -o v.planet", "sea");
}

// Heights of a picture.
static void look(const char *what, float heights[PIXELS])
{
    char line[512];
    image_exr_file p;
    snprintf(line, sizeof line, "render %s " LOOK "-o look.exr", what);
    expect_good(line);
    assert_int_equal(image_exr_read("look.exr", &p), 0);
    memcpy(heights, p.height_m, PIXELS * sizeof *heights);
    image_exr_file_deinit(&p);
}

// `share` of the planet's heights and `beside` metres. Between vertices the ground is up to 2 m
// below its arc.
static void expect_heights(const char *what, double share, double beside, double tolerance)
{
    static float planet[PIXELS], got[PIXELS];
    double worst = 0;
    int ground = 0;
    look("hills.planet", planet);
    look(what, got);
    for (int i = 0; i < PIXELS; i++) {
        if (isnan(planet[i]) || isnan(got[i])) continue; // no ground
        worst = fmax(worst, fabs((double)got[i] - share * (double)planet[i] - beside));
        ground++;
    }
    print_message("%s: %.2f m off in %d pixels\n", what, worst, ground);
    assert_true(ground > PIXELS / 2);
    check_near(worst, 0, tolerance);
}

static void test_raster_as_it_is(void **state)
{
    (void)state;
    expect_heights("globe.asc", 1, 0, 8); // the planet's are in steps of a metre
}

static void test_layers(void **state)
{
    (void)state;
    write_level("high", 8, 4, -180, -90, 45, 9000);
    write_level("low", 8, 4, -180, -90, 45, 100);
    expect_heights("hills.planet --layer high.asc,opacity=0.25", 0.75, 2250, 4);
    expect_heights("hills.planet --layer high.asc,height,opacity=0", 1, 0, 4);
    expect_heights("hills.planet --layer high.asc --layer low.asc", 0, 100, 4);
    expect_heights("hills.planet --layer low.asc --layer high.asc", 0, 9000, 4);
    expect_heights("hills.planet --layer low.asc --layer high.asc,opacity=0.5", 0, 4550, 4);
    expect_fault("render hills.planet " LOOK "--layer low.asc,opacity=1.5 -o x.exr", "opacity");
    expect_fault("render hills.planet " LOOK "--layer none.asc -o x.exr", "none.asc");
}

static int set_up(void **state)
{
    if (run_begin(state)) return -1;
    if (run("render hills.planet -q --size 8x8 -o probe.png") == 0) return 0;
    print_message("no OpenGL 4.5 here, nothing tested: %s", err);
    exit(77);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_estimate),
        cmocka_unit_test(test_vertical),
        cmocka_unit_test(test_raster_as_it_is),
        cmocka_unit_test(test_layers),
    };
    return cmocka_run_group_tests(tests, set_up, run_end);
}
