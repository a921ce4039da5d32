// A projected raster opened by the program itself (--flat): every mode against the reference, its
// places as geographic degrees and as the raster's own coordinates, wherever they are written, the
// camera off the map and under its ground. 45 N 9 E is easting 500,000 m, northing 4,982,950.4 m of
// UTM zone 32. Fails when broken: places written as those of the plane's own degrees (places,
// tables); the height by default that of a globe (places).
#include "app/compare_run.h"

#include <unistd.h>

#include "app/image_exr.h"

#define FLAT "utm.asc --flat -q --no-synthesis --size 96x72 "

enum { WIDTH = 200, HEIGHT = 160 };

// 30 m a sample; 45 N 9 E is its middle.
static void make_raster(void)
{
    FILE *f = fopen("utm.asc", "w");
    assert_non_null(f);
    fprintf(f, "ncols %d\nnrows %d\nxllcorner %.1f\nyllcorner %.1f\ncellsize 30\n", WIDTH, HEIGHT,
            500000.0 - 30 * WIDTH / 2, 4982950.4 - 30 * HEIGHT / 2);
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        fprintf(f, "%.2f ", 400 + 100 * sin(0.1 * (i % WIDTH)) * cos(0.08 * (i / WIDTH)));
    assert_int_equal(fclose(f), 0);
    write_text(
        "utm.prj",
        "PROJCS[\"UTM 32N\",GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS 84\",6378137,"
        "298.257223563]],PRIMEM[\"Greenwich\",0],UNIT[\"degree\",0.0174532925199433]],"
        "PROJECTION[\"Transverse_Mercator\"],PARAMETER[\"latitude_of_origin\",0],"
        "PARAMETER[\"central_meridian\",9],PARAMETER[\"scale_factor\",0.9996],"
        "PARAMETER[\"false_easting\",500000],PARAMETER[\"false_northing\",0],"
        "UNIT[\"metre\",1]]");
}

static int set_up(void **state)
{
    if (run_begin(state)) return -1;
    make_raster();
    write_text("views.json",
               "{\"views\":[{\"name\":\"down\",\"lat\":45,\"lon\":9,\"aboveGround\":5000,"
               "\"heading\":0,\"pitch\":-90},{\"name\":\"along\",\"lat\":44.99,\"lon\":8.98,"
               "\"aboveGround\":500,\"heading\":40,\"pitch\":-15}]}");
    write_text("flight.json",
               "{\"keys\":[{\"time\":0,\"lat\":45,\"lon\":9,\"alt\":3000,\"heading\":0,"
               "\"pitch\":-60},{\"time\":2,\"lat\":45.005,\"lon\":9,\"alt\":2500,\"heading\":0,"
               "\"pitch\":-60}]}");
    if (run("render hills.planet -q --size 8x8 -o probe.png") == 0) return 0;
    print_message("no OpenGL 4.5 here, nothing tested: %s", err);
    exit(77);
}

static double number_after(const char *path, const char *name)
{
    char text[TEXT_SIZE], key[64];
    read_text(path, text);
    snprintf(key, sizeof key, "\"%s\":", name);
    const char *at = strstr(text, key);
    return at ? atof(at + strlen(key)) : (double)NAN;
}

static void test_places(void **state)
{
    (void)state;
    image_exr_file p;
    expect_good("render " FLAT "--lat 45 --lon 9 --stats s.jsonl -o a.exr");
    check_near(number_after("s.jsonl", "lat"), 45, 1e-8);
    check_near(number_after("s.jsonl", "lon"), 9, 1e-8);
    check_near(number_after("s.jsonl", "easting"), 500000, 2e-3);
    check_near(number_after("s.jsonl", "northing"), 4982950.4, 2e-3);
    check_near(number_after("s.jsonl", "alt"), 6000, 1000); // all of the map is seen
    assert_int_equal(image_exr_read("a.exr", &p), 0);
    check_near(p.camera.lat_deg, 45, 1e-9);
    check_near(p.lat_deg[36 * 96 + 48], 45, 1e-3);
    check_near(p.lon_deg[36 * 96 + 48], 9, 1e-3);
    image_exr_file_deinit(&p);
    assert_int_equal(system("grep -q northing.lo a.exr"), 0);
    expect_good("render " FLAT "--mode reference --lat 45 --lon 9 -o r.exr");
    assert_int_equal(system("grep -q northing.lo r.exr"), 0);
    expect_good("render hills.planet -q --size 8x8 --stats globe.jsonl -o globe.png");
    assert_true(isnan(number_after("globe.jsonl", "easting")));
}

static void test_tables(void **state)
{
    (void)state;
    expect_good("compare " FLAT "--modes all --views views.json --repeats 0 --csv v.csv");
    for (int row = 0; row < 6; row++) {
        check_near(csv_number("v.csv", row, "missing_inside"), 0, 0);
        check_near(csv_number("v.csv", row, "extra_outside"), 0, 0);
        assert_true(csv_number("v.csv", row, "ground") > 96 * 72 / 4);
        assert_true(csv_number("v.csv", row, "geometric_px_p999") < 1);
        check_near(csv_number("v.csv", row, "geometric_px_lat"), 45, 0.05);
        check_near(csv_number("v.csv", row, "geometric_px_lon"), 9, 0.05);
    }
    check_near(csv_number("v.csv", 0, "lat"), 45, 1e-8);
    check_near(csv_number("v.csv", 0, "easting"), 500000, 2e-3);
    check_near(csv_number("v.csv", 0, "northing"), 4982950.4, 2e-3);
    check_near(csv_number("v.csv", 5, "lat"), 44.99, 1e-8);
    expect_good("compare " FLAT "--a grid --lat 45 --lon 9 --alt 3000 --csv one.csv -o d");
    check_near(csv_number("one.csv", 0, "lon"), 9, 1e-8);
    assert_non_null(strstr(out, "camera 45"));
    expect_good("compare hills.planet -q --size 32x24 --zoom 3 --a grid --csv globe.csv");
    assert_true(isnan(csv_number("globe.csv", 0, "easting")));
}

static void test_flight_at_equal_triangles(void **state)
{
    (void)state;
    expect_good("compare " FLAT "--modes all --path flight.json --frames 2 --equal triangles "
                "--repeats 0 --csv f.csv");
    for (int row = 0; row < 6; row++) {
        check_near(csv_number("f.csv", row, "missing_inside"), 0, 0);
        assert_true(csv_number("f.csv", row, "flicker_px_rms") >= 0);
    }
    check_near(csv_number("f.csv", 3, "lat"), 45.005, 1e-6);
}

static void test_off_the_map(void **state)
{
    (void)state;
    expect_good("render utm.asc --flat --size 32x24 --lat 45 --lon 9.5 --alt 2000 -o off.png");
    assert_non_null(strstr(err, "latitude 45, longitude 9.5: 36.4 km off the map"));
    expect_good("render utm.asc --flat --size 32x24 --lat 45 --lon 9.01 --alt 2000 -o on.png");
    assert_null(strstr(err, "off the map"));
    expect_fault("render " FLAT "--lat 45 --lon 9 --alt 100 -o never.png", "--alt 100: below");
    expect_fault("render " FLAT "--lat 45 --lon 9 --above-ground 0 -o never.png",
                 "--above-ground 0");
    expect_fault("render " FLAT "--lat 45 --lon 9 --alt -7e6 -o never.png", "--alt -7e6");
    assert_int_equal(access("never.png", F_OK), -1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_places),
        cmocka_unit_test(test_tables),
        cmocka_unit_test(test_flight_at_equal_triangles),
        cmocka_unit_test(test_off_the_map),
    };
    return cmocka_run_group_tests(tests, set_up, run_end);
}
