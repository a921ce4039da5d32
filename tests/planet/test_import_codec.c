// How an import stores heights: how far off they are, their ranges, and what a file says of it.
#include "test_import_common.h"

#include <pthread.h>
#include <sqlite3.h>

enum { SAMPLES = TILE_SIZE * TILE_SIZE };

static double hills(int band, double x, double y)
{
    (void)band;
    return 900 * sin(x * 0.11) * cos(y * 0.13) + 60 * sin(x * 2.7 + y * 1.9);
}

// No data in a corner; a plain that takes up whole tiles.
static double hills_and_plain(int band, double x, double y)
{
    if (x > 100 && y > 40) return -9999;
    return x < -90 && y < 0 ? 12 : hills(band, x, y);
}

static const double no_data = -9999;

static const raster_spec globe = {.name = "hills.tif",
                                  .width = 1024,
                                  .height = 512,
                                  .bands = 1,
                                  .type = GDT_Float32,
                                  .crs = "EPSG:4326",
                                  .transform = {-180, 360.0 / 1024, 0, 90, 0, -180.0 / 512},
                                  .value = hills_and_plain,
                                  .nodata = &no_data};

static import_params params_of(const char *output, import_source *source)
{
    static char paths[4][512];
    static int turn;
    char *out = paths[turn++ % 4], *in = paths[turn++ % 4];
    snprintf(out, sizeof paths[0], "%s", in_dir(output));
    snprintf(in, sizeof paths[0], "%s", in_dir(globe.name));
    if (access(in, F_OK)) write_raster(&globe);
    *source = (import_source){.layer = LAYER_HEIGHT, .path = in};
    return (import_params){.sources = source,
                           .source_count = 1,
                           .output = out,
                           .name = "Hills",
                           .threads = 2,
                           .force = true};
}

static void make(const char *output, double quantum)
{
    import_source source;
    import_params p = params_of(output, &source);
    p.quantum = quantum;
    assert_int_equal(import_run(&p), OK);
}

// Calls `each` for every tile of `a`, with its samples and those of the same tile of `b`.
struct pair {
    struct planet_file *a, *b;
    void (*each)(struct pair *pair, tile_id id, const float *a, const float *b);
    double step, worst;            // what `each` needs and finds
    double (*step_of)(tile_id id); // NULL: `step` everywhere
    int tiles;
};

static void visit(void *user, tile_id id)
{
    static float a[SAMPLES], b[SAMPLES];
    struct pair *p = user;
    assert_int_equal(planet_file_read_height(p->a, id, a), OK);
    assert_int_equal(planet_file_read_height(p->b, id, b), OK);
    p->each(p, id, a, b);
    p->tiles++;
}

static void compare(struct pair *p, const char *a, const char *b)
{
    p->a = open_planet(a);
    p->b = open_planet(b);
    assert_int_equal(planet_file_list(p->a, LAYER_HEIGHT, visit, p), OK);
    assert_true(p->tiles > 7);
    planet_file_close(&p->a);
    planet_file_close(&p->b);
}

// a: as floats; b: on the grid. Below the finest zoom each level's filter adds half a step.
static void check_grid(struct pair *p, tile_id id, const float *a, const float *b)
{
    int finest = planet_file_meta(p->a)->max_zoom[LAYER_HEIGHT];
    double bound = p->step / 2 * (1 + finest - id.zoom);
    float min, max;
    assert_int_equal(planet_file_read_range(p->b, id, &min, &max), OK);
    for (int i = 0; i < SAMPLES; i++) {
        assert_int_equal(isnan(a[i]) != 0, isnan(b[i]) != 0);
        if (isnan(a[i])) continue;
        check_near(b[i], a[i], bound * (1 + 1e-6));
        double step = p->step_of ? p->step_of(id) : p->step;
        check_near(b[i], step * nearbyint(b[i] / step), 0);
        assert_true(b[i] >= min && b[i] <= max);
        p->worst = fmax(p->worst, fabs(b[i] - a[i]) / bound);
    }
}

// Fails when heights are cut off instead of rounded, when the range is taken before rounding, and
// when holes move.
static void test_grid(void **state)
{
    (void)state;
    make("exact.planet", 0);
    static const double quanta[] = {0x1p-12, 0.25, 8, 10}; // 10: as 8
    for (size_t i = 0; i < sizeof quanta / sizeof *quanta; i++) {
        make("grid.planet", quanta[i]);
        struct pair p = {.each = check_grid, .step = fmin(quanta[i], 8)};
        compare(&p, "exact.planet", "grid.planet");
        print_message("quantum %g: at most %.3f of the bound off\n", quanta[i], p.worst);
        assert_true(p.worst > 0.5);
        struct planet_file *f = open_planet("grid.planet");
        check_near(planet_file_meta(f)->quantum, p.step, 0);
        check_near(planet_file_meta(f)->quantum_finest, p.step, 0);
        planet_file_close(&f);
    }
}

static double step_by_itself(tile_id id)
{
    return id.row == 0 || id.row == grid_rows(id.zoom) - 1 ? 1.0 / 64 : 1;
}

// The step by itself: 1/2048 of the distance of samples, at every zoom, and 1 m at most.
// Fails when one step is taken for all zooms, or when it is not held within its limits.
static void test_auto(void **state)
{
    (void)state;
    const double a = 6378137;
    for (int zoom = 0; zoom <= GRID_MAX_ZOOM; zoom++) {
        double step = ldexp(1, quantum_exponent(QUANTUM_AUTO, zoom, a));
        double asked = a * M_PI / 256 / ldexp(1, zoom) / 2048;
        assert_true(step >= 1.0 / 64 && step <= 1);
        if (asked > 1.0 / 64) assert_true(step <= asked);
        if (asked < 1) assert_true(step > asked / 2);
    }
    make("exact.planet", 0);
    make("grid.planet", QUANTUM_AUTO);
    struct pair p = {.each = check_grid, .step = 1, .step_of = step_by_itself};
    compare(&p, "exact.planet", "grid.planet");
}

static void check_at_poles(struct pair *p, tile_id id, const float *a, const float *b)
{
    if (id.zoom < planet_file_meta(p->a)->max_zoom[LAYER_HEIGHT]) return;
    if (id.row > 0 && id.row < grid_rows(id.zoom) - 1) return;
    for (int i = 0; i < SAMPLES; i++) {
        if (isnan(a[i])) continue;
        check_near(b[i], a[i], (1 + 1e-6) / 128);
        p->worst = fmax(p->worst, fabs(b[i] - a[i]) * 128);
    }
}

// In the tiles at a pole, whose samples come ever closer along their rows, the step is the least.
// Fails when it is that of their zoom.
static void test_auto_at_poles(void **state)
{
    (void)state;
    make("exact.planet", 0);
    make("grid.planet", QUANTUM_AUTO);
    struct pair p = {.each = check_at_poles};
    compare(&p, "exact.planet", "grid.planet");
    print_message("at the poles at most %.3f of 1/128 m off\n", p.worst);
    assert_true(p.worst > 0.5);
}

static void test_bad_quanta(void **state)
{
    (void)state;
    static const double bad[] = {-2, -0.5, 1e-9, 512, 1e30, INFINITY, NAN};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        import_source source;
        import_params p = params_of("bad.planet", &source);
        p.quantum = bad[i];
        logged[0] = 0;
        assert_int_equal(import_run(&p), ERR_ARGUMENT);
        assert_non_null(strstr(logged, "quantum"));
        assert_true(access(in_dir("bad.planet"), F_OK) != 0);
    }
}

// Fails when the fingerprint leaves out the quantum.
static bool stop(void *user, const char *stage, double done)
{
    (void)user;
    (void)stage;
    (void)done;
    return true;
}

static void test_resume_with_another_quantum(void **state)
{
    (void)state;
    import_source source;
    import_params p = params_of("resumed.planet", &source);
    p.quantum = 0.5;
    p.progress = stop;
    status s = import_run(&p);
    if (s == OK) skip(); // done before it was first asked
    assert_int_equal(s, ERR_CANCELLED);
    p.progress = NULL;
    p.resume = true;
    p.quantum = 0.25;
    assert_int_equal(import_run(&p), ERR_ARGUMENT);
    p.quantum = 0.5;
    assert_int_equal(import_run(&p), OK);
}

// a: as floats; b: within a bound. The grid of the parts adds half a step a zoom.
static void check_bound(struct pair *p, tile_id id, const float *a, const float *b)
{
    const struct planet_meta *m = planet_file_meta(p->b);
    double bound = m->max_error + p->step / 2 * (m->max_zoom[LAYER_HEIGHT] - id.zoom);
    float min, max;
    assert_int_equal(planet_file_read_range(p->b, id, &min, &max), OK);
    for (int i = 0; i < SAMPLES; i++) {
        assert_int_equal(isnan(a[i]) != 0, isnan(b[i]) != 0);
        if (isnan(a[i])) continue;
        check_near(b[i], a[i], bound * (1 + 1e-6));
        assert_true(b[i] >= min && b[i] <= max);
        p->worst = fmax(p->worst, fabs(b[i] - a[i]) / bound);
    }
}

static void make_bounded(const char *output, double max_error, int threads)
{
    import_source source;
    import_params p = params_of(output, &source);
    p.max_error = max_error;
    p.threads = threads;
    assert_int_equal(import_run(&p), OK);
}

// Fails when a tile is coded against its parent as it was instead of as it is decoded, when the
// range is not widened, when the reader takes another parent.
static void test_bounded(void **state)
{
    (void)state;
    make("exact.planet", 0);
    static const double bounds[] = {0.05, 2, 30};
    for (size_t i = 0; i < sizeof bounds / sizeof *bounds; i++) {
        make_bounded("bounded.planet", bounds[i], 2);
        struct planet_file *f = open_planet("bounded.planet");
        check_near(planet_file_meta(f)->max_error, bounds[i], 0);
        planet_file_close(&f);
        struct pair p = {.each = check_bound, .step = ldexp(1, ilogb(bounds[i] / 16))};
        compare(&p, "exact.planet", "bounded.planet");
        print_message("within %g m: at most %.3f of it off\n", bounds[i], p.worst);
        assert_true(p.worst > 0.5);
    }
}

// Fails when tiles are written in the order in which workers finish.
static void test_bounded_bytes(void **state)
{
    (void)state;
    make_bounded("one.planet", 2, 1);
    make_bounded("four.planet", 2, 4);
    check_same_files(in_dir("one.planet"), in_dir("four.planet"));
}

struct order {
    tile_id ids[64];
    int count;
};

static void list_tile(void *user, tile_id id)
{
    struct order *o = user;
    if (o->count < 64) o->ids[o->count++] = id;
}

struct reading {
    struct planet_file *file;
    const struct order *order;
    float (*want)[SAMPLES];
    int first;
};

static void *read_all(void *arg)
{
    struct reading *r = arg;
    float *heights = malloc(SAMPLES * sizeof *heights);
    long bad = 0;
    for (int k = 0; k < r->order->count; k++) {
        int i = (r->first + k * 7) % r->order->count;
        bad += planet_file_read_height(r->file, r->order->ids[i], heights) != OK;
        bad += memcmp(heights, r->want[i], SAMPLES * sizeof *heights) != 0;
    }
    free(heights);
    return (void *)bad;
}

// Every order and any number of readers: the same samples. Fails when a tile is decoded over a
// parent that another thread is still making.
static void test_bounded_reading(void **state)
{
    (void)state;
    static float want[64][SAMPLES];
    struct order order = {.count = 0};
    make_bounded("bounded.planet", 2, 2);
    struct planet_file *f = open_planet("bounded.planet");
    assert_int_equal(planet_file_list(f, LAYER_HEIGHT, list_tile, &order), OK);
    for (int i = 0; i < order.count; i++)
        assert_int_equal(planet_file_read_height(f, order.ids[i], want[i]), OK);
    planet_file_close(&f);
    f = open_planet("bounded.planet");
    struct reading readings[4];
    pthread_t threads[4];
    for (int i = 0; i < 4; i++) {
        readings[i] = (struct reading){f, &order, want, order.count - 1 - i};
        pthread_create(&threads[i], NULL, read_all, &readings[i]);
    }
    for (int i = 0; i < 4; i++) {
        void *bad;
        pthread_join(threads[i], &bad);
        assert_null(bad);
    }
    planet_file_close(&f);
}

// A tile whose parent is broken cannot be read; one line names the parent, and the others are
// unharmed. Fails when the child is decoded over nothing, or complains too, or the parent is named
// again.
static void test_broken_parent(void **state)
{
    (void)state;
    make_bounded("broken.planet", 2, 2);
    sqlite3 *db;
    assert_int_equal(sqlite3_open(in_dir("broken.planet"), &db), SQLITE_OK);
    assert_int_equal(
        sqlite3_exec(db,
                     "UPDATE body SET hash = hash + 1 WHERE id = (SELECT body FROM tile"
                     " WHERE layer = 0 AND zoom = 0 AND col = 1)",
                     NULL, NULL, NULL),
        SQLITE_OK);
    sqlite3_close(db);
    struct planet_file *f = open_planet("broken.planet");
    static float heights[SAMPLES];
    logged[0] = 0;
    tile_id under = {LAYER_HEIGHT, 1, 1, 3}, beside = {LAYER_HEIGHT, 1, 1, 1};
    assert_int_equal(planet_file_read_height(f, under, heights), ERR_FORMAT);
    assert_non_null(strstr(logged, "height/0/0/1"));
    assert_ptr_equal(strchr(logged, '\n'), logged + strlen(logged) - 1);
    assert_int_equal(planet_file_read_height(f, beside, heights), OK);
    // Its other child is refused without another word.
    under.col = 2;
    logged[0] = 0;
    assert_int_equal(planet_file_read_height(f, under, heights), ERR_FORMAT);
    assert_string_equal(logged, "");
    planet_file_close(&f);
}

// The estimate is near what the import then makes, though it has no parents to code against.
// Fails when it takes the tiles of the parts for those of the finished file.
static void test_estimate(void **state)
{
    (void)state;
    import_source source;
    import_params p = params_of("estimated.planet", &source);
    import_estimate e;
    import_report r;
    p.max_error = 2;
    p.report = &r;
    assert_int_equal(import_estimate_run(&p, &e), OK);
    assert_int_equal(import_run(&p), OK);
    print_message("%.0f bytes estimated, %.0f made\n", e.bytes, (double)r.bytes);
    check_near(e.bytes / (double)r.bytes, 1, 0.5);
}

static void test_bad_bounds(void **state)
{
    (void)state;
    static const double bad[] = {-1, 1e-9, 1e6, INFINITY, NAN};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        import_source source;
        import_params p = params_of("bad.planet", &source);
        p.max_error = bad[i];
        logged[0] = 0;
        assert_int_equal(import_run(&p), ERR_ARGUMENT);
        assert_non_null(strstr(logged, "greatest error"));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_grid),
        cmocka_unit_test(test_auto),
        cmocka_unit_test(test_auto_at_poles),
        cmocka_unit_test(test_bad_quanta),
        cmocka_unit_test(test_resume_with_another_quantum),
        cmocka_unit_test(test_bounded),
        cmocka_unit_test(test_bounded_bytes),
        cmocka_unit_test(test_bounded_reading),
        cmocka_unit_test(test_broken_parent),
        cmocka_unit_test(test_estimate),
        cmocka_unit_test(test_bad_bounds),
    };
    return cmocka_run_group_tests(tests, make_test_dir, remove_test_dir);
}
