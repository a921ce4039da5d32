// Greys to heights: the table, the ocean, de-banding.
#include "check.h"

#include <stdbool.h>
#include <unistd.h>

#include "planet/atlas.h"

static atlas_table table;
static char csv_path[300];

static const char *write_csv(const char *text)
{
    const char *base = getenv("TMPDIR");
    snprintf(csv_path, sizeof csv_path, "%s/perigee-atlas-XXXXXX", base ? base : P_tmpdir);
    int fd = mkstemp(csv_path);
    assert_true(fd >= 0);
    assert_int_equal(write(fd, text, strlen(text)), strlen(text));
    close(fd);
    return csv_path;
}

// 20 m a grey, 10 m from the coast on either side.
static char *plain_csv(void)
{
    static char text[8192];
    size_t n = 0;
    for (int g = 0; g < 256; g++)
        n += (size_t)snprintf(text + n, sizeof text - n, "%d,%d\n", g, 20 * (g - 97) + 10);
    return text;
}

static int read_plain(void **state)
{
    (void)state;
    status s = atlas_read_table(write_csv(plain_csv()), &table);
    unlink(csv_path);
    return s;
}

static void test_table(void **state)
{
    (void)state;
    check_near(table.metres[100], 70, 0);
    check_near(table.low[100], 60, 0);
    check_near(table.high[100], 80, 0);
    check_near(table.high[96], 0, 0);
    check_near(table.low[97], 0, 0);
    atlas_table t;
    assert_int_equal(atlas_read_table("there/is/none.csv", &t), ERR_NOT_FOUND);
    assert_int_equal(atlas_read_table(write_csv("0,1\n1,2\n"), &t), ERR_FORMAT);
    unlink(csv_path);
    char *text = plain_csv();
    memcpy(strstr(text, "\n120,"), "\n119,", 5);
    assert_int_equal(atlas_read_table(write_csv(text), &t), ERR_FORMAT);
    unlink(csv_path);
}

// The table that ships: it can be read, and sea level lies between greys 96 and 97.
static void test_shipped_table(void **state)
{
    (void)state;
    atlas_table t;
    assert_int_equal(atlas_read_table(RELIEF_CSV, &t), OK);
    assert_true(t.metres[0] < -9000 && t.metres[255] > 6000);
    for (int g = 0; g < 256; g++) assert_true(t.low[g] <= t.metres[g] && t.metres[g] <= t.high[g]);
}

// A map in letters: '~' deep ocean, '-' shallow, 'v' below zero, '#' land.
static void find_sea(const char *const *rows, int width, int height, int gap, char *out)
{
    unsigned char greys[1024], sea[1024];
    for (int i = 0; i < width * height; i++) {
        char c = rows[i / width][i % width];
        greys[i] = c == '~' ? 20 : c == '-' ? 94 : c == 'v' ? 80 : 120;
    }
    assert_int_equal(atlas_find_sea(greys, width, height, 46, gap, sea), OK);
    for (int i = 0; i < width * height; i++) out[i] = sea[i] ? 'o' : '.';
    out[width * height] = 0;
}

static void test_sea(void **state)
{
    (void)state;
    char got[1025];
    // Over edges and the border; not over corners; a hollow stays.
    static const char *const map[] = {"-##v##-~", "-#vv##--", "##v###-#", "-######v", "########"};
    find_sea(map, 8, 5, 0, got);
    assert_string_equal(got, "o.....oo"
                             "o.....oo"
                             "......o."
                             "........"
                             "........");
    // A strait of two samples is crossed, one of three is not; also over the border and over
    // corners.
    static const char *const straits[] = {"~##v###v", "########", "########", "###v####",
                                          "#####v##"};
    find_sea(straits, 8, 5, 2, got);
    assert_string_equal(got, "o..o...o"
                             "........"
                             "........"
                             "...o...."
                             ".....o..");
    find_sea(straits, 8, 5, 1, got);
    assert_string_equal(got, "o......o"
                             "........"
                             "........"
                             "........"
                             "........");
    static const char *const none[] = {"vv##", "vv##"};
    find_sea(none, 4, 2, 2, got);
    assert_string_equal(got, "........");
}

// Smooth hills with a coast, quantised: what comes back stays in its interval and is nearer to the
// hills.
enum { W = 512, H = 256 };

static double hills(int x, int y)
{
    double round_pole = pow(sin(M_PI * (y + 0.5) / H), 2);
    return round_pole * (300 * sin(2 * M_PI * x / W) + 150 * sin(4 * M_PI * x / W + 1)) + 47;
}

static void test_heights(void **state)
{
    (void)state;
    static unsigned char greys[W * H];
    static float heights[W * H];
    double table_error = 0, error = 0;
    for (int i = 0; i < W * H; i++)
        greys[i] = (unsigned char)(97 + floor(hills(i % W, i / W) / 20));
    atlas_params p = {.greys = greys, .width = W, .height = H, .table = &table, .threads = 2};
    assert_int_equal(atlas_make_heights(&p, heights), OK);
    for (int i = 0; i < W * H; i++) {
        double truth = hills(i % W, i / W);
        assert_true(heights[i] >= table.low[greys[i]] && heights[i] <= table.high[greys[i]]);
        assert_true((truth >= 0) == (heights[i] > 0));
        table_error += pow(table.metres[greys[i]] - truth, 2);
        error += pow((double)heights[i] - truth, 2);
    }
    table_error = sqrt(table_error / (W * H));
    error = sqrt(error / (W * H));
    print_message("rms error of the table %.2f m, de-banded %.2f m\n", table_error, error);
    check_near(table_error, 20 / sqrt(12), 0.5);
    assert_true(error < 0.2 * table_error); // measured 0.73 of 5.58 m
    // Nothing special where left meets right.
    for (int y = 0; y < H; y++)
        check_near(heights[y * W] - heights[y * W + W - 1], heights[y * W + 1] - heights[y * W], 4);
}

static bool stop_at_once(void *user, double done)
{
    (void)user;
    (void)done;
    return true;
}

static void test_summits_and_sea(void **state)
{
    (void)state;
    static unsigned char greys[64 * 64], sea[64 * 64];
    static float heights[64 * 64];
    memset(greys, 150, sizeof greys);
    greys[10 * 64 + 10] = 180; // a summit
    greys[30 * 64 + 30] = 110; // a pit
    for (int i = 50 * 64; i < 64 * 64; i++) {
        greys[i] = 80;
        sea[i] = 1;
    }
    for (int x = 0; x < 64; x++) greys[49 * 64 + x] = 97; // a beach
    atlas_params p = {
        .greys = greys, .sea = sea, .width = 64, .height = 64, .table = &table, .threads = 1};
    assert_int_equal(atlas_make_heights(&p, heights), OK);
    assert_true(heights[10 * 64 + 10] >= table.metres[180]);
    assert_true(heights[30 * 64 + 30] <= table.metres[110]);
    for (int i = 50 * 64; i < 64 * 64; i++) assert_true(heights[i] == 0);
    for (int x = 0; x < 64; x++) assert_true(heights[49 * 64 + x] > 0);
    p.progress = stop_at_once;
    assert_int_equal(atlas_make_heights(&p, heights), ERR_CANCELLED);
}

static void test_missing_tile(void **state)
{
    (void)state;
    unsigned char grey;
    assert_int_equal(atlas_read_tile("there/is/none", 0, 0, &grey), ERR_NOT_FOUND);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_table),
        cmocka_unit_test(test_shipped_table),
        cmocka_unit_test(test_sea),
        cmocka_unit_test(test_heights),
        cmocka_unit_test(test_summits_and_sea),
        cmocka_unit_test(test_missing_tile),
    };
    return cmocka_run_group_tests(tests, read_plain, NULL);
}
