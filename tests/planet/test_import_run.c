// The import as a whole: overlays, bounds, bad input, stopping and going on, threads.
#include "test_import_common.h"

#include <signal.h>
#include <sys/wait.h>

static double level_500(int band, double x, double y)
{
    (void)band;
    (void)x;
    (void)y;
    return 500;
}

static double level_900(int band, double x, double y)
{
    return level_500(band, x, y) + 400;
}

static double rough(int band, double x, double y)
{
    (void)band;
    return 800 * sin(x * 0.9) * cos(y * 1.3) + 300 * sin(x * 7.1 + y * 5.3);
}

static const raster_spec globe = {.name = "globe.tif",
                                  .width = 720,
                                  .height = 360,
                                  .bands = 1,
                                  .type = GDT_Float32,
                                  .crs = "EPSG:4326",
                                  .transform = {-180, 0.5, 0, 90, 0, -0.5},
                                  .value = level_500};

static raster_spec inset_at(const char *name, double west, double north, double step,
                            double (*value)(int, double, double))
{
    return (raster_spec){.name = name,
                         .width = 100,
                         .height = 100,
                         .bands = 1,
                         .type = GDT_Float32,
                         .crs = "EPSG:4326",
                         .transform = {west, step, 0, north, 0, -step},
                         .value = value};
}

static const enum tile_layer two_heights[] = {LAYER_HEIGHT, LAYER_HEIGHT};

// A finer inset over a base: its own zooms hold it alone, coarser ones hold both; the later of two
// equals wins. (More: test_import_blend.c.)
static void test_overlay(void **state)
{
    (void)state;
    raster_spec fine = inset_at("fine.tif", 10, 50, 0.05, level_900);
    write_raster(&globe);
    write_raster(&fine);
    assert_int_equal(
        import_files("o.planet", 2, two_heights, (const char *[]){"globe.tif", "fine.tif"}), OK);
    struct planet_file *f = open_planet("o.planet");
    int top = planet_file_meta(f)->max_zoom[LAYER_HEIGHT];
    assert_int_equal(top, 4);
    for (int zoom = 0; zoom <= top; zoom++)
        check_near(height_near(f, zoom, 47.5, 12.5), 900, zoom ? 1e-3 : 400);
    check_near(height_near(f, 1, 47.5, 30), 500, 1e-3);
    assert_true(isnan(height_near(f, top, 47.5, 9.5)));
    assert_true(isnan(height_near(f, top, -30, 100)));
    planet_file_close(&f);
    raster_spec beside = inset_at("beside.tif", 12, 50, 0.05, level_500);
    write_raster(&beside);
    for (int order = 0; order < 2; order++) {
        const char *names[] = {order ? "beside.tif" : "fine.tif",
                               order ? "fine.tif" : "beside.tif"};
        assert_int_equal(import_files("o.planet", 2, two_heights, names), OK);
        f = open_planet("o.planet");
        check_near(height_near(f, top, 47.5, 11), 900, 1e-3);
        check_near(height_near(f, top, 47.5, 14), order ? 900 : 500, 1e-3);
        check_near(height_near(f, top, 47.5, 16), 500, 1e-3);
        planet_file_close(&f);
    }
}

static void test_bounds(void **state)
{
    (void)state;
    write_raster(&globe);
    import_source source = {.layer = LAYER_HEIGHT, .path = in_dir("globe.tif")};
    char out[512];
    snprintf(out, sizeof out, "%s", in_dir("b.planet"));
    import_params p = {.sources = &source,
                       .source_count = 1,
                       .output = out,
                       .bounds_deg = {170, -10, -160, 20},
                       .force = true};
    assert_int_equal(import_run(&p), OK);
    struct planet_file *f = open_planet("b.planet");
    check_near(height_near(f, 1, 5, 175), 500, 1e-3);
    check_near(height_near(f, 1, 5, -165), 500, 1e-3);
    assert_true(isnan(height_near(f, 1, 5, -155)));
    assert_true(isnan(height_near(f, 1, 25, 175)));
    planet_file_close(&f);
    static const double bad[][4] = {
        {0, 10, 20, 5}, {0, -95, 20, 5}, {0, 0, 0, NAN}, {1e9, 0, 2, 5}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        memcpy(p.bounds_deg, bad[i], sizeof bad[i]);
        assert_int_equal(import_run(&p), ERR_ARGUMENT);
    }
}

static void expect(status want, const char *name, const char *said)
{
    assert_int_equal(import_heights("x.planet", name), want);
    if (!strstr(logged, name) || !strstr(logged, said)) fail_msg("logged: %s", logged);
    assert_ptr_equal(strchr(logged, '\n'), logged + strlen(logged) - 1); // one line
    assert_true(access(in_dir("x.planet"), F_OK) != 0);
}

static void test_bad_rasters(void **state)
{
    (void)state;
    expect(ERR_NOT_FOUND, "none.tif", "cannot be opened");
    FILE *text = fopen(in_dir("text.tif"), "w");
    fputs("not a raster\n", text);
    fclose(text);
    expect(ERR_FORMAT, "text.tif", "cannot be opened");
    raster_spec s = inset_at("one.tif", 10, 50, 0.05, level_500);
    s.width = s.height = 1;
    write_raster(&s);
    expect(ERR_FORMAT, "one.tif", "1 x 1");
    s = inset_at("nowhere.tif", 0, 0, 0, level_500);
    write_raster(&s);
    expect(ERR_ARGUMENT, "nowhere.tif", "georeference");
    s = inset_at("nocrs.tif", 10, 50, 0.05, level_500);
    s.crs = NULL;
    write_raster(&s);
    expect(ERR_ARGUMENT, "nocrs.tif", "reference system");
    s = inset_at("off.tif", 10, 500, 0.05, level_500);
    write_raster(&s);
    expect(ERR_ARGUMENT, "off.tif", "not on the globe");
    s = inset_at("complex.tif", 10, 50, 0.05, level_500);
    s.type = GDT_CFloat32;
    write_raster(&s);
    expect(ERR_FORMAT, "complex.tif", "CFloat32");
    s = inset_at("cut.tif", 10, 50, 0.05, rough);
    write_raster(&s);
    assert_int_equal(truncate(in_dir("cut.tif"), 20000), 0);
    expect(ERR_FORMAT, "cut.tif", "cannot read rows");
    s = inset_at("floatcolour.tif", 10, 50, 0.05, level_500);
    write_raster(&s);
    assert_int_equal(import_files("x.planet", 1, (enum tile_layer[]){LAYER_COLOR},
                                  (const char *[]){"floatcolour.tif"}),
                     ERR_FORMAT);
    assert_int_equal(import_files("x.planet", 0, NULL, NULL), ERR_ARGUMENT);
}

static void test_output(void **state)
{
    (void)state;
    write_raster(&globe);
    import_source source = {.layer = LAYER_HEIGHT, .path = in_dir("globe.tif")};
    import_params p = {.sources = &source, .source_count = 1, .output = "there/is/none/x.planet"};
    assert_int_equal(import_run(&p), ERR_IO);
    p.output = test_dir;
    assert_int_equal(import_run(&p), ERR_ARGUMENT);
    char out[512];
    snprintf(out, sizeof out, "%s", in_dir("out.planet"));
    p.output = out;
    assert_int_equal(import_run(&p), OK);
    logged[0] = 0;
    assert_int_equal(import_run(&p), ERR_ARGUMENT);
    assert_non_null(strstr(logged, "exists already"));
    p.force = true;
    assert_int_equal(import_run(&p), OK);
    assert_true(access(in_dir("out.planet.part"), F_OK) != 0);
    struct planet_file *f = open_planet("out.planet");
    assert_string_equal(planet_file_meta(f)->name, "out");
    assert_true(planet_file_meta(f)->complete);
    planet_file_close(&f);
}

// All tiles of both files are the same.
static void compare_planets(const char *a, const char *b)
{
    struct planet_file *fa = open_planet(a), *fb = open_planet(b);
    const struct planet_meta *ma = planet_file_meta(fa), *mb = planet_file_meta(fb);
    assert_memory_equal(ma->max_zoom, mb->max_zoom, sizeof ma->max_zoom);
    check_near(ma->height_min, mb->height_min, 0);
    check_near(ma->height_max, mb->height_max, 0);
    check_near(ma->synthesis_gain, mb->synthesis_gain, 0);
    static float ha[TILE_SIZE * TILE_SIZE], hb[TILE_SIZE * TILE_SIZE];
    static unsigned char pa[TILE_SIZE * TILE_SIZE * 3], pb[TILE_SIZE * TILE_SIZE * 3];
    int tiles = 0;
    for (int layer = LAYER_HEIGHT; layer <= LAYER_COLOR; layer++)
        for (int zoom = 0; zoom <= ma->max_zoom[layer]; zoom++)
            for (int row = 0; row < grid_rows(zoom); row++)
                for (int col = 0; col < grid_cols(zoom, row); col++) {
                    tile_id id = {(enum tile_layer)layer, zoom, row, col};
                    status sa, sb;
                    if (layer == LAYER_HEIGHT) {
                        sa = planet_file_read_height(fa, id, ha);
                        sb = planet_file_read_height(fb, id, hb);
                        if (!sa) assert_memory_equal(ha, hb, sizeof ha);
                    } else {
                        sa = planet_file_read_pixels(fa, id, pa);
                        sb = planet_file_read_pixels(fb, id, pb);
                        if (!sa) assert_memory_equal(pa, pb, sizeof pa);
                    }
                    assert_int_equal(sa, sb);
                    tiles += !sa;
                }
    assert_true(tiles > 100);
    planet_file_close(&fa);
    planet_file_close(&fb);
}

struct stopper {
    int calls, stop_at;
};

static bool stop_later(void *user, const char *stage, double done)
{
    struct stopper *s = user;
    assert_true(strlen(stage) > 0 && done >= 0 && done <= 1);
    return ++s->calls >= s->stop_at;
}

static void set_up_large(import_params *p, import_source sources[2], const char *out)
{
    raster_spec s = globe;
    s.width = 4096;
    s.height = 2048;
    s.value = rough;
    s.transform[1] = 360.0 / 4096;
    s.transform[5] = -180.0 / 2048;
    s.name = "large.tif";
    if (access(in_dir("large.tif"), F_OK)) write_raster(&s);
    raster_spec c = globe;
    c.type = GDT_Byte;
    c.name = "grey.tif";
    c.width = 1440;
    c.height = 720;
    c.transform[1] = 0.25;
    c.transform[5] = -0.25;
    c.value = rough;
    if (access(in_dir("grey.tif"), F_OK)) write_raster(&c);
    static char paths[2][512];
    snprintf(paths[0], sizeof paths[0], "%s", in_dir("large.tif"));
    snprintf(paths[1], sizeof paths[1], "%s", in_dir("grey.tif"));
    sources[0] = (import_source){.layer = LAYER_HEIGHT, .path = paths[0]};
    sources[1] = (import_source){.layer = LAYER_COLOR, .path = paths[1]};
    *p = (import_params){
        .sources = sources, .source_count = 2, .output = out, .name = "Rough", .threads = 2};
}

// Goes on with an import in another process and kills it after a while. True when it was done
// before.
static bool resume_and_kill(import_params p, int after_ms)
{
    pid_t child = fork();
    if (child == 0) {
        p.resume = true;
        p.progress = NULL;
        _exit(import_run(&p) == OK ? 0 : 1);
    }
    usleep((useconds_t)after_ms * 1000);
    kill(child, SIGKILL);
    int result = 0;
    waitpid(child, &result, 0);
    return WIFEXITED(result) && WEXITSTATUS(result) == 0;
}

// Stopped by the caller, then gone on with; and killed outright, again and again, then gone on
// with: the same file, byte by byte, as in one go, with any number of threads.
static void test_resume(void **state)
{
    (void)state;
    import_params p;
    import_source sources[2];
    char whole[512], halves[512];
    snprintf(whole, sizeof whole, "%s", in_dir("whole.planet"));
    snprintf(halves, sizeof halves, "%s", in_dir("halves.planet"));
    set_up_large(&p, sources, whole);
    import_report report;
    p.report = &report;
    assert_int_equal(import_run(&p), OK);
    assert_int_equal(report.tiles, report.made);
    struct stopper stop = {0, 2};
    p.output = halves;
    p.progress = stop_later;
    p.user = &stop;
    p.threads = 1;
    assert_int_equal(import_run(&p), ERR_CANCELLED);
    assert_true(access(halves, F_OK) != 0);
    assert_int_equal(access(in_dir("halves.planet.part"), F_OK), 0);
    bool done = false;
    int kills = 0;
    for (int ms = 60; ms < 1000 && !done; ms = ms * 3 / 2, kills += !done)
        done = resume_and_kill(p, ms);
    print_message("killed %d times\n", kills);
    assert_true(kills > 2);
    p.resume = true;
    p.threads = 3;
    p.progress = NULL;
    if (!done) assert_int_equal(import_run(&p), OK);
    if (!done) assert_true(report.made < report.tiles);
    compare_planets("whole.planet", "halves.planet");
    check_same_files(in_dir("whole.planet"), in_dir("halves.planet"));
    assert_true(access(in_dir("halves.planet.part"), F_OK) != 0);
    assert_true(access(in_dir("halves.planet.joining"), F_OK) != 0);
}

struct killer {
    const char *stage;
    double share;
    bool asks; // to stop, instead
};

static bool kill_at(void *user, const char *stage, double done)
{
    const struct killer *k = user;
    bool now = !strcmp(stage, k->stage) && done >= k->share;
    if (now && !k->asks) kill(getpid(), SIGKILL);
    return now;
}

// Heights within a bound hang together from coarse to fine and are coded as the parts are joined.
// Killed or stopped there too, whatever was written of the file counts for nothing: the same file.
static void test_resume_bounded(void **state)
{
    (void)state;
    import_params p;
    import_source sources[2];
    char whole[512], halves[512];
    snprintf(whole, sizeof whole, "%s", in_dir("bounded.planet"));
    snprintf(halves, sizeof halves, "%s", in_dir("killed.planet"));
    set_up_large(&p, sources, whole);
    p.max_error = 8;
    assert_int_equal(import_run(&p), OK);
    p.output = halves;
    p.threads = 1;
    bool done = resume_and_kill(p, 150);
    static const double shares[] = {0, 0.3, 0.8};
    for (int i = 0; i < 3 && !done; i++) {
        struct killer killer = {"joining", shares[i], false};
        pid_t child = fork();
        if (child == 0) {
            p.resume = true;
            p.progress = kill_at;
            p.user = &killer;
            _exit(import_run(&p) == OK ? 0 : 1);
        }
        int result = 0;
        waitpid(child, &result, 0);
        assert_true(WIFSIGNALED(result) && WTERMSIG(result) == SIGKILL);
        assert_true(access(halves, F_OK) != 0);
        assert_int_equal(access(in_dir("killed.planet.joining"), F_OK), 0);
    }
    p.resume = true;
    p.progress = kill_at;
    p.user = &(struct killer){"joining", 0.5, true};
    if (!done) assert_int_equal(import_run(&p), ERR_CANCELLED);
    assert_true(access(in_dir("killed.planet.joining"), F_OK) != 0);
    p.progress = NULL;
    p.threads = 3;
    if (!done) assert_int_equal(import_run(&p), OK);
    compare_planets("bounded.planet", "killed.planet");
    check_same_files(in_dir("bounded.planet"), in_dir("killed.planet"));
    assert_true(access(in_dir("killed.planet.joining"), F_OK) != 0);
}

static void check_estimate(double quantum)
{
    import_params p;
    import_source sources[2];
    char out[512];
    snprintf(out, sizeof out, "%s", in_dir("estimated.planet"));
    set_up_large(&p, sources, out);
    p.quantum = quantum;
    p.force = true;
    import_estimate e;
    import_report r;
    unlink(out);
    assert_int_equal(import_estimate_run(&p, &e), OK);
    assert_true(access(out, F_OK) != 0);
    p.report = &r;
    assert_int_equal(import_run(&p), OK);
    print_message("tiles %.0f, made %.0f; bytes %.0f, file %.0f; %.2f core-seconds\n",
                  (double)e.tiles, (double)r.made, e.bytes, (double)r.bytes, e.core_seconds);
    check_near((double)e.tiles / (double)r.made, 1, 1e-9);
    check_near(e.bytes / (double)r.bytes, 1, 0.15);
    assert_true(e.core_seconds > 0.01);
}

// The estimate is near what the import then makes, as floats and on the grid.
static void test_estimate(void **state)
{
    (void)state;
    check_estimate(0);
    check_estimate(QUANTUM_AUTO);
}

static double fractal(int band, double x, double y)
{
    double sum = 0;
    (void)band;
    for (int i = 0; i < 9; i++) {
        double f = ldexp(1, i), a = 0.7 * i + 1;
        sum +=
            900 / f * sin(f * (x * cos(a) + y * sin(a)) + i) * cos(f * (y * cos(a) - x * sin(a)));
    }
    return sum;
}

// Each zoom counts by its own roughness, which matters where much of the file is coarse: heights
// within a bound, small rasters, and rasters of several zooms. Fails when the finest zoom stands
// for all (33 % less), and when the zoom above is the mean of four (moon, 21 % less).
static void test_estimate_of_zooms(void **state)
{
    (void)state;
    raster_spec wide = globe, fine = inset_at("fractal.tif", 10, 50, 0.01, fractal);
    wide.name = "wide.tif";
    wide.value = fractal;
    fine.width = fine.height = 900;
    write_raster(&wide);
    write_raster(&fine);
    static const struct {
        const char *names[2];
        double max_error;
        bool shared, moon;
    } cases[] = {
        {{"fractal.tif"}, 3, false, false},
        {{"wide.tif", "fractal.tif"}, 20, false, false},
        {{"wide.tif", "fractal.tif"}, 0, false, false},
        {{"srtm3_alps_oetztal_582x444_i16.tif"}, 2, true, false},
        {{"craterlake_bathymetry_30m_429x279_i16.tif"}, 2, true, false},
        {{"srtm3_rainier_N46W122_1201_i16.tif"}, 3, true, false},
        {{"srtm3_rainier_N46W122_1201_i16.tif"}, 0, true, false},
        {{"earth_elev_etopo1_15min_1440x720_i16.tif"}, 20, true, false},
        {{"moon_patch_gld100_256ppd_apennines_0E-14E_16N-30N_3584_i16.tif"}, 4, true, true},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        import_source sources[2];
        char paths[2][512], out[512];
        int count = cases[i].names[1] ? 2 : 1;
        for (int k = 0; k < count; k++) {
            snprintf(paths[k], sizeof paths[k], "%s/%s", cases[i].shared ? SHARED_DATA : test_dir,
                     cases[i].names[k]);
            sources[k] = (import_source){.layer = LAYER_HEIGHT, .path = paths[k]};
        }
        if (access(paths[0], F_OK)) {
            print_message("%s: is not there\n", paths[0]);
            continue;
        }
        snprintf(out, sizeof out, "%s", in_dir("zooms.planet"));
        import_estimate e;
        import_report r;
        import_params p = {.sources = sources,
                           .source_count = count,
                           .output = out,
                           .ellipsoid = {cases[i].moon ? 1737400 : 0, cases[i].moon ? 1737400 : 0},
                           .quantum = QUANTUM_AUTO,
                           .max_error = cases[i].max_error,
                           .threads = 2,
                           .force = true,
                           .report = &r};
        assert_int_equal(import_estimate_run(&p, &e), OK);
        assert_int_equal(import_run(&p), OK);
        print_message("%s within %g m: tiles %.0f, made %.0f; bytes %.0f, file %.0f: %+.1f %%\n",
                      cases[i].names[0], cases[i].max_error, (double)e.tiles, (double)r.tiles,
                      e.bytes, (double)r.bytes, 100 * (e.bytes / (double)r.bytes - 1));
        check_near(e.bytes / (double)r.bytes, 1, 0.15);
        check_near((double)e.tiles / (double)r.tiles, 1, 0.25);
    }
}

// A part begun from other sources is not gone on with, and is not lost.
static void test_resume_of_another(void **state)
{
    (void)state;
    import_params p;
    import_source sources[2];
    char out[512];
    snprintf(out, sizeof out, "%s", in_dir("another.planet"));
    set_up_large(&p, sources, out);
    struct stopper stop = {0, 1};
    p.progress = stop_later;
    p.user = &stop;
    assert_int_equal(import_run(&p), ERR_CANCELLED);
    p.source_count = 1;
    p.resume = true;
    assert_int_equal(import_run(&p), ERR_ARGUMENT);
    assert_int_equal(access(in_dir("another.planet.part"), F_OK), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_overlay),
        cmocka_unit_test(test_bounds),
        cmocka_unit_test(test_bad_rasters),
        cmocka_unit_test(test_output),
        cmocka_unit_test(test_resume),
        cmocka_unit_test(test_resume_bounded),
        cmocka_unit_test(test_estimate),
        cmocka_unit_test(test_estimate_of_zooms),
        cmocka_unit_test(test_resume_of_another),
    };
    return cmocka_run_group_tests(tests, make_test_dir, remove_test_dir);
}
