// Measurement 2: fetching heights from the windows (shaders/lib/windows.glsl) against the same
// weights and sums in double. Prints the table of tests/ACCURACY-transforms.md; fails when a bar is
// broken.
//   accuracy_fetch [--dense]
// The unit of error is the spacing of floats (ulp) at the largest sample that takes part. Places
// are given, or come out exact, in float: so the error is that of the fetch alone; that of the
// place has its own row.
#include <stdlib.h>
#include <string.h>

#include "check.h"
#include "clipmap/window.h"
#include "fetch_kernel.h"
#include "gpu/gpu_fixture.h"
#include "report.h"

enum { CASES = 40000, TEXELS = FETCH_ROWS * FETCH_COLUMNS };

// Metres of the finest level's place are 1 / SCALE rad; dlonlat are multiples of STEP rad, so that
// every level's place has at most 23 bits.
#define SCALE 1024.0
#define STEP  0x1p-22

static const char *const FIELDS[] = {"noise of +-8848 m", "hills", "flat, 1234.5678 m"};
enum { FIELD_COUNT = 3 };

static float heights[FETCH_LEVELS * TEXELS];
static struct fetch_case cases[CASES];
static struct fetch_result results[CASES];
static struct levels_block levels;
static struct check_random dice = {2004};

enum { BINS = 400 }; // of 1/100 ulp; the last holds all that is larger

// Worst, and how often: for the 99.9 % point.
struct spread {
    double worst;
    long counts[BINS], total;
};

struct errors {
    struct spread bilinear, trilinear; // ulp
    double bilinear_m, bilinear_share, place_texel;
};

// Windows about the focus, each twice as coarse as the next; the finest one is late and not whole.
static void fill_levels(void)
{
    memset(&levels, 0, sizeof levels);
    for (int i = 0; i < FETCH_LEVELS; i++) {
        float scale = (float)(SCALE * exp2(i - FETCH_LEVELS + 1));
        const float map[4] = {scale, scale, FETCH_ROWS / 2, FETCH_COLUMNS / 2};
        const float torus[4] = {(float)(check_random_u64(&dice) % FETCH_ROWS),
                                (float)(check_random_u64(&dice) % FETCH_COLUMNS),
                                i == FETCH_LEVELS - 1 ? 0.8125f : 1, 0};
        const float valid[4] = {0, i == FETCH_LEVELS - 1 ? 250 : FETCH_ROWS, 0, FETCH_COLUMNS};
        memcpy(levels.height_map[i], map, sizeof map);
        memcpy(levels.height_torus[i], torus, sizeof torus);
        memcpy(levels.height_valid[i], valid, sizeof valid);
    }
}

// A surface over the map, the same for every level: slopes to 30 degrees at a sample of 250 m.
static double hills(double lat, double lon)
{
    return 1500 * sin(60 * lat) * cos(70 * lon) + 900 * sin(11 * lon + 5 * lat) +
           40 * sin(400 * lat) * sin(500 * lon);
}

// Texels of all levels, where the torus of `levels` puts them.
static void fill_heights(int field)
{
    for (int i = 0; i < FETCH_LEVELS * TEXELS; i++) {
        int level = i / TEXELS, row = i % TEXELS / FETCH_COLUMNS, column = i % FETCH_COLUMNS;
        const float *map = levels.height_map[level], *torus = levels.height_torus[level];
        row = (row - (int)torus[0] + FETCH_ROWS) % FETCH_ROWS;
        column = (column - (int)torus[1] + FETCH_COLUMNS) % FETCH_COLUMNS;
        double lat = (map[2] - row - 0.5) / map[0], lon = (column + 0.5 - map[3]) / map[1];
        double noise = check_random_range(&dice, -8848, 8848);
        heights[i] = (float)(field == 0 ? noise : field == 1 ? hills(lat, lon) : 1234.5678);
    }
}

// A window as src/render/windows.c hands it over, and what it was before rounding.
static void window_numbers(double exact_map[4], float map[4])
{
    window_shape shape = window_height_shape(256);
    int level = 1 + (int)(check_random_u64(&dice) % 22);
    double lat = check_random_range(&dice, -M_PI / 2, M_PI / 2), row, column;
    double lon = check_random_range(&dice, -M_PI, M_PI);
    window w = window_at(&shape, level, lat, lon, 1.0034);
    window_coordinates(&shape, &w, lat, lon, &row, &column);
    exact_map[0] = 1 / window_step_lat(&w);
    exact_map[1] = 1 / window_step_lon(&shape, &w);
    exact_map[2] = row - (double)w.rect.row0;
    exact_map[3] = column - (double)w.rect.col0;
    for (int i = 0; i < 4; i++) map[i] = (float)exact_map[i];
}

static double grid_value(double low, double high)
{
    return round(check_random_range(&dice, low, high) / STEP) * STEP;
}

static void fill_chain_case(struct fetch_case *c)
{
    c->dlonlat[0] = (float)grid_value(-0.24, 0.24);
    c->dlonlat[1] = (float)grid_value(-0.13, 0.13);
    c->place[0] = (float)check_random_range(&dice, 0, FETCH_ROWS);
    c->place[1] = (float)check_random_range(&dice, 0, FETCH_COLUMNS);
    c->coarser = (float)check_random_range(&dice, -0.2, 1.2);
    c->coarser = fminf(1, fmaxf(0, c->coarser));
    c->level = (float)(check_random_u64(&dice) % FETCH_LEVELS);
}

static double sample(int level, long row, long column)
{
    row = (row + (long)levels.height_torus[level][0] + FETCH_ROWS) % FETCH_ROWS;
    column = (column + (long)levels.height_torus[level][1] + FETCH_COLUMNS) % FETCH_COLUMNS;
    return heights[level * TEXELS + row * FETCH_COLUMNS + column];
}

// The samples that take part, and the heights made from them.
struct span {
    double low, high;
};

static const struct span NONE = {INFINITY, -INFINITY};

// Of the k-th of four samples along an axis, at f between the middle two: linear, of the samples
// less a fifth of their second differences when sharp.
static double weight(bool sharp, int k, double f)
{
    double tent[6] = {0, 0, 1 - f, f, 0, 0};
    double second = tent[k] - 2 * tent[k + 1] + tent[k + 2];
    return tent[k + 1] - (sharp ? 0.2 * second : 0);
}

// The surface of the samples about a place, which `span` grows by.
static double surface(bool sharp, int level, double row, double column, struct span *span)
{
    double r = floor(row - 0.5), c = floor(column - 0.5), sum = 0;
    for (int k = 0, first = sharp ? 0 : 1, n = 4 - 2 * first; k < n * n; k++) {
        int y = first + k / n, x = first + k % n;
        double h = sample(level, (long)r + y - 1, (long)c + x - 1);
        sum += h * weight(sharp, y, row - 0.5 - r) * weight(sharp, x, column - 0.5 - c);
        span->low = fmin(span->low, h);
        span->high = fmax(span->high, h);
    }
    span->low = fmin(span->low, sum);
    span->high = fmax(span->high, sum);
    return sum;
}

static double ramp(int level, double row, double column)
{
    const float *v = levels.height_valid[level];
    double inside = fmin(fmin(row - v[0], v[1] - row), fmin(column - v[2], v[3] - column));
    return levels.height_torus[level][2] * fmin(1, fmax(0, (inside - 1.5) / 4));
}

// What a level does not cover its coarser one does, and the share `coarser` of the finest.
static double chain(bool sharp, const struct fetch_case *c, struct span *span)
{
    double sum = 0, left = 1;
    for (int i = (int)c->level; i >= 0; i--) {
        const float *map = levels.height_map[i];
        double row = map[2] - (double)c->dlonlat[1] * map[0];
        double column = map[3] + (double)c->dlonlat[0] * map[1];
        double w = ramp(i, row, column);
        if (i == (int)c->level && i > 0) w *= 1 - (double)c->coarser;
        if (w > 0) sum += left * w * surface(sharp, i, row, column, span);
        left *= 1 - w;
    }
    return sum;
}

// Spacing of floats at the largest number that takes part: a sample, a difference of two, a height.
static double ulp(struct span s)
{
    double largest = fmax(s.high - s.low, fmax(fabs(s.low), fabs(s.high)));
    return ldexp(1, ilogb(largest) - 23);
}

static void spread_add(struct spread *s, double error)
{
    s->worst = worse(s->worst, error);
    s->counts[error * 100 < BINS ? (int)(error * 100) : BINS - 1]++;
    s->total++;
}

static double spread_most(const struct spread *s)
{
    long left = s->total / 1000;
    int i = BINS - 1;
    while (i > 0 && (left -= s->counts[i]) >= 0) i--;
    return (i + 1) / 100.0;
}

static void judge_fetch(bool sharp, const struct fetch_case *c, const struct fetch_result *got,
                        struct errors *e)
{
    struct span four = NONE, all = NONE;
    double want = surface(false, (int)c->level, c->place[0], c->place[1], &four);
    double off = fabs(got->bilinear - want);
    spread_add(&e->bilinear, off / ulp(four));
    e->bilinear_m = worse(e->bilinear_m, off);
    if (four.high > four.low)
        e->bilinear_share = worse(e->bilinear_share, off / (four.high - four.low));
    want = chain(sharp, c, &all);
    if (all.high < all.low) return;
    spread_add(&e->trilinear, fabs(got->trilinear - want) / ulp(all));
}

enum how { EMULATED, SHARP, HARDWARE, HOWS };

static status measure_fetch(int field, enum how how, int runs, struct errors *e)
{
    static const char *const defines[HOWS] = {NULL, "#define CHAIN_SAMPLE sharp_height\n",
                                              "#define HARDWARE_FILTER 1\n"};
    memset(e, 0, sizeof *e);
    memset(cases, 0, sizeof cases);
    for (int k = 0; k < runs; k++) {
        fill_levels();
        fill_heights(field);
        for (int i = 0; i < CASES; i++) fill_chain_case(&cases[i]);
        status s = fetch_kernel_run(heights, &levels, defines[how], cases, results, CASES);
        if (s) return s;
        for (int i = 0; i < CASES; i++) judge_fetch(how == SHARP, &cases[i], &results[i], e);
    }
    return OK;
}

static status measure_place(int runs, struct errors *e)
{
    static double maps[CASES][4];
    memset(e, 0, sizeof *e);
    memset(cases, 0, sizeof cases);
    fill_levels();
    for (int k = 0; k < runs; k++) {
        for (int i = 0; i < CASES; i++) {
            struct fetch_case *c = &cases[i];
            window_numbers(maps[i], c->map);
            c->dlonlat[0] = (float)(check_random_range(&dice, -256, 256) / maps[i][1]);
            c->dlonlat[1] = (float)(check_random_range(&dice, -140, 140) / maps[i][0]);
        }
        status s = fetch_kernel_run(heights, &levels, NULL, cases, results, CASES);
        if (s) return s;
        for (int i = 0; i < CASES; i++) {
            const float *d = cases[i].dlonlat, *got = results[i].place;
            const double *m = maps[i];
            e->place_texel = worse(e->place_texel, fabs(got[0] - (m[2] - d[1] * m[0])));
            e->place_texel = worse(e->place_texel, fabs(got[1] - (m[3] + d[0] * m[1])));
        }
    }
    return OK;
}

static void print_row(const char *name, const struct errors e[HOWS])
{
    const struct errors *b = &e[EMULATED], *s = &e[SHARP], *h = &e[HARDWARE];
    printf("| %s | %.2f (%.1e) | %.2f | %.2f | %.2f | %.2f | %.2f | %.3g (%.1e) | 1/%.0f |\n", name,
           b->bilinear.worst, b->bilinear_m, spread_most(&b->bilinear), b->trilinear.worst,
           spread_most(&b->trilinear), s->trilinear.worst, spread_most(&s->trilinear),
           h->bilinear.worst, h->bilinear_m, 1 / h->bilinear_share);
}

static int measure(bool dense)
{
    static struct errors e[FIELD_COUNT][HOWS], place;
    int runs = dense ? 60 : 3;
    status s = measure_place(runs, &place);
    for (int f = 0; !s && f < FIELD_COUNT; f++)
        for (int how = 0; !s && how < HOWS; how++)
            s = measure_fetch(f, (enum how)how, runs, &e[f][how]);
    if (s) return EXIT_FAILURE;
    printf("\n| heights | bilinear, ulp (m) | 99.9 %% | trilinear, ulp | 99.9 %% | sharp, ulp | "
           "99.9 %% | hardware bilinear, ulp (m) | of the samples' range "
           "|\n|---|---|---|---|---|---|---|---|---|\n");
    double one = 0, chained = 0, bilinear = 0, trilinear = 0, sharp = 0;
    for (int f = 0; f < FIELD_COUNT; f++) {
        const struct errors *b = &e[f][EMULATED];
        print_row(FIELDS[f], e[f]);
        one = worse(one, b->bilinear.worst);
        chained = worse(worse(chained, b->trilinear.worst), e[f][SHARP].trilinear.worst);
        bilinear = worse(bilinear, spread_most(&b->bilinear));
        trilinear = worse(trilinear, spread_most(&b->trilinear));
        sharp = worse(sharp, spread_most(&e[f][SHARP].trilinear));
    }
    double level = worse(e[FIELD_COUNT - 1][EMULATED].trilinear.worst,
                         e[FIELD_COUNT - 1][SHARP].trilinear.worst);
    printf("\n%d cases a row\n\n", runs * CASES);
    int broken = bar_at_most("bilinear, 99.9 % of the heights, ulp", bilinear, 1);
    broken += bar_at_most("trilinear, 99.9 % of the heights, ulp", trilinear, 1.25);
    broken += bar_at_most("every height of one window, ulp", one, 2);
    broken += bar_at_most("every height of up to three, ulp", chained, 3);
    broken += bar_at_most("sharp, 99.9 % of the heights, ulp", sharp, 1.25);
    broken += bar_at_most("level ground, ulp", level, 1e-6);
    broken +=
        bar_at_most("place in the window from map coordinates, texels", place.place_texel, 1e-3);
    printf("\n%d bars broken\n", broken);
    return broken ? EXIT_FAILURE : EXIT_SUCCESS;
}

int main(int argc, char **argv)
{
    bool dense = argc == 2 && !strcmp(argv[1], "--dense");
    if (argc > 2 || (argc == 2 && !dense)) {
        fprintf(stderr, "accuracy_fetch: \"%s\" is not an option; there is --dense\n", argv[1]);
        return EXIT_FAILURE;
    }
    int rc = gpu_fixture_open();
    return rc ? rc : gpu_fixture_close(measure(dense));
}
