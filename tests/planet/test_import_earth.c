// The default Earth against spot heights of general knowledge, and the promises of its making: a
// flat ocean, land above it, hollows kept. Skipped (77) where the atlas is not installed.
#include "test_import_common.h"

#include "planet/atlas.h"

enum { MAX_SPOTS = 200, KINDS = 5 };

static const char *const kinds[KINDS] = {"peak", "plain", "lake", "depression", "ocean"};

// Measured with this list; see the lines this test prints. Bias, median and 90 % of |error|,
// metres: peaks are lower because a sample of 2' is an average over 3.7 km and the greys end at
// 6300 m.
struct bound {
    double bias_low, bias_high, median, ninety;
};

static const struct bound bounds[KINDS];

struct spot {
    char name[64];
    double lat, lon, metres, got;
    int kind;
};

static struct spot spots[MAX_SPOTS];
static int spot_count;
static struct planet_file *earth;

static int kind_of(const char *name)
{
    for (int i = 0; i < KINDS; i++)
        if (!strcmp(name, kinds[i])) return i;
    fail_msg("unknown kind %s", name);
    return -1;
}

static void read_spots(void)
{
    FILE *f = fopen(SPOT_HEIGHTS_CSV, "r");
    assert_non_null(f);
    char line[256], kind[32];
    while (fgets(line, sizeof line, f)) {
        struct spot s;
        if (line[0] == '#' ||
            sscanf(line, "%63[^,],%lf,%lf,%lf,%31s", s.name, &s.lat, &s.lon, &s.metres, kind) != 5)
            continue;
        s.kind = kind_of(kind);
        assert_true(spot_count < MAX_SPOTS);
        spots[spot_count++] = s;
    }
    fclose(f);
}

static int open_earth(void **state)
{
    (void)state;
    if (access(EARTH_PLANET, R_OK)) {
        printf("skipped: the default Earth is not there\n");
        exit(77);
    }
    return planet_file_open(EARTH_PLANET, &earth);
}

static int close_earth(void **state)
{
    (void)state;
    planet_file_close(&earth);
    return 0;
}

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// A summit is the highest sample within 2 samples: published places are rounded.
static double height_of(const struct spot *s, int zoom)
{
    double lat = clamp_double(s->lat, -89.99, 89.99), best = height_near(earth, zoom, lat, s->lon);
    if (s->kind != 0) return best;
    double step = grid_step_lat(zoom) / RAD;
    for (int i = -2; i <= 2; i++)
        for (int k = -2; k <= 2; k++)
            best = fmax(
                best, height_near(earth, zoom, lat + i * step, s->lon + k * step / cos(lat * RAD)));
    return best;
}

static void test_spot_heights(void **state)
{
    (void)state;
    read_spots();
    int zoom = planet_file_meta(earth)->max_zoom[LAYER_HEIGHT];
    for (int kind = 0; kind < KINDS; kind++) {
        double errors[MAX_SPOTS], bias = 0;
        int n = 0;
        for (int i = 0; i < spot_count; i++) {
            if (spots[i].kind != kind) continue;
            double error = height_of(&spots[i], zoom) - spots[i].metres;
            if (kind != 4)
                print_message("  %-28s %6.0f m, error %7.1f m\n", spots[i].name, spots[i].metres,
                              error);
            bias += error;
            errors[n++] = fabs(error);
        }
        assert_true(n >= 10);
        bias /= n;
        qsort(errors, (size_t)n, sizeof *errors, compare_doubles);
        double median = errors[n / 2], ninety = errors[(int)(0.9 * (n - 1) + 0.5)];
        print_message("%s: %d, bias %.1f m, median |error| %.1f m, 90 %% %.1f m\n", kinds[kind], n,
                      bias, median, ninety);
        const struct bound *b = &bounds[kind];
        assert_true(bias >= b->bias_low && bias <= b->bias_high);
        assert_true(median <= b->median && ninety <= b->ninety);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_spot_heights)};
    return cmocka_run_group_tests(tests, open_earth, close_earth);
}
