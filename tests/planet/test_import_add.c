// Rasters put on top of a finished planet: the same planet as if all had been imported together,
// by making the tiles they touch and no others. Fails when the planet's own tiles are not laid
// below; when what it has finer is not looked at (a coarser raster); when the filter's reach is
// left out of the plan (CARRIED_ROWS 0); when what the planet does not have counts as height 0
// (leave_out_nothing); when tiles under a new parent keep their bodies (bounded: unreadable), or
// ancestors are coded within the bound again (twice the bound).
#include "test_import_common.h"

#include <signal.h>
#include <sys/wait.h>
#include <utime.h>

#include "planet/planet_part.h"

enum { SAMPLES = TILE_SIZE * TILE_SIZE };

static double hills(int band, double x, double y)
{
    (void)band;
    return 900 * sin(x * 0.11) * cos(y * 0.13) + 60 * sin(x * 0.7 + y * 0.9);
}

static double higher(int band, double x, double y)
{
    return hills(band, x, y) + 300;
}

static double lower(int band, double x, double y)
{
    return hills(band, x, y) - 150;
}

static double bands(int band, double x, double y)
{
    return 100 + 40 * band + 20 * sin(x * 0.5) * cos(y * 0.5);
}

static double red(int band, double x, double y)
{
    (void)x;
    (void)y;
    return band == 1 ? 250 : 5;
}

#define GLOBE(wide)                                                                                \
    .width = (wide), .height = (wide) / 2, .crs = "EPSG:4326",                                     \
    .transform = {-180, 360.0 / (wide), 0, 90, 0, -180.0 / ((wide) / 2)}
#define PIECE(columns, rows, west, north, step)                                                    \
    .width = (columns), .height = (rows), .crs = "EPSG:4326",                                      \
    .transform = {(west), (step), 0, (north), 0, -(step)}

static const raster_spec rasters[] = {
    {.name = "globe.tif", .bands = 1, .type = GDT_Float32, .value = hills, GLOBE(1024)},
    // At zoom 4, over a tile's corner; at zoom 3; at zoom 2.
    {.name = "inset.tif",
     .bands = 1,
     .type = GDT_Float32,
     .value = higher,
     PIECE(300, 260, 40.5, 38, 0.045)},
    {.name = "middle.tif",
     .bands = 1,
     .type = GDT_Float32,
     .value = lower,
     PIECE(400, 300, 38, 42, 0.09)},
    {.name = "region.tif",
     .bands = 1,
     .type = GDT_Float32,
     .value = lower,
     PIECE(200, 160, 20, 60, 0.18)},
    // At zoom 4, up to where four tiles of every zoom meet.
    {.name = "corner.tif",
     .bands = 1,
     .type = GDT_Float32,
     .value = higher,
     PIECE(200, 200, 0, 0, 0.045)},
    {.name = "colour.tif", .bands = 3, .type = GDT_Byte, .value = bands, GLOBE(512)},
    {.name = "red.tif", .bands = 3, .type = GDT_Byte, .value = red, PIECE(300, 300, -60, 20, 0.09)},
};

static int make_rasters(void **state)
{
    int failed = make_test_dir(state);
    for (size_t i = 0; !failed && i < sizeof rasters / sizeof *rasters; i++)
        write_raster(&rasters[i]);
    return failed;
}

// One import; names end with NULL.
static status run(const char *output, const import_params *params, const char *const *names)
{
    import_source sources[5];
    char paths[5][512], out[512];
    import_params p = *params;
    logged[0] = 0;
    for (p.source_count = 0; names[p.source_count]; p.source_count++) {
        const char *name = names[p.source_count];
        bool pixels = !strcmp(name, "colour.tif") || !strcmp(name, "red.tif");
        snprintf(paths[p.source_count], sizeof *paths, "%s", in_dir(name));
        sources[p.source_count] = (import_source){.layer = pixels ? LAYER_COLOR : LAYER_HEIGHT,
                                                  .path = paths[p.source_count]};
    }
    snprintf(out, sizeof out, "%s", in_dir(output));
    p.sources = sources;
    p.output = out;
    p.threads = 2;
    if (!p.add) p.force = true;
    return import_run(&p);
}

static void import(const char *output, const import_params *params, const char *const *names)
{
    if (run(output, params, names)) fail_msg("%s", logged);
}

#define NAMES(...) ((const char *const[]){__VA_ARGS__, NULL})

static struct planet_part *open_part(const char *name)
{
    struct planet_part *part;
    if (planet_part_open(in_dir(name), &part)) fail_msg("%s", logged);
    return part;
}

// Tiles of b that a has not, or not with the same body and range.
static int differing(const char *a, const char *b, int *all)
{
    struct planet_part *pa = open_part(a), *pb = open_part(b);
    planet_row row;
    int count = 0;
    *all = 0;
    while (!planet_part_next(pb, &row)) {
        codec_blob body = {0};
        float min, max;
        bool same = planet_part_get(pa, row.id, &body, &min, &max) == OK &&
                    body.size == row.body.size && !memcmp(body.data, row.body.data, body.size) &&
                    min == row.min && max == row.max;
        codec_blob_deinit(&body);
        count += !same;
        ++*all;
    }
    planet_part_close(&pa);
    planet_part_close(&pb);
    return count;
}

static void assert_same(const char *a, const char *b)
{
    int in_b, in_a;
    assert_int_equal(differing(a, b, &in_b), 0);
    assert_int_equal(differing(b, a, &in_a), 0);
    assert_int_equal(in_a, in_b);
}

// By longitudes and latitudes: the tiles of a zoom on which a raster lies, grown by so many rows.
static int touched(const raster_spec *r, int zoom, int rows)
{
    const double *t = r->transform;
    double reach = rows * grid_step_lat(zoom) / RAD;
    double north = t[3] + reach, south = t[3] + r->height * t[5] - reach;
    double across = reach / cos(fmax(fabs(north), fabs(south)) * RAD);
    double west = t[0] - across, east = t[0] + r->width * t[1] + across;
    int count = 0;
    for (int row = 0; row < grid_rows(zoom); row++)
        for (int col = 0; col < grid_cols(zoom, row); col++) {
            double w, s, e, n;
            grid_bounds((tile_id){LAYER_HEIGHT, zoom, row, col}, &w, &s, &e, &n);
            count += w < east * RAD && e > west * RAD && s < north * RAD && n > south * RAD;
        }
    return count;
}

static void only_what_is_touched_is_made(void **state)
{
    (void)state;
    import_report report;
    const import_params exact = {0}, add = {.add = true, .report = &report};
    import("before.planet", &exact, NAMES("globe.tif", "middle.tif"));
    import("after.planet", &exact, NAMES("globe.tif", "middle.tif"));
    import("after.planet", &add, NAMES("inset.tif"));
    int all, changed = differing("before.planet", "after.planet", &all), least = 0, most = 0;
    for (int zoom = 0; zoom <= 4; zoom++) {
        least += touched(&rasters[1], zoom, 0);
        most += touched(&rasters[1], zoom, zoom < 4 ? 3 : 0);
    }
    print_message("%d tiles, %llu made, %d of them changed; the raster lies on %d, with the "
                  "filter's reach %d\n",
                  all, (unsigned long long)report.made, changed, least, most);
    assert_true(changed >= least && changed <= (int)report.made);
    assert_true((int)report.made <= most && most < all / 2);
}

struct difference {
    struct planet_file *a, *b;
    int zoom;
    double beside; // not looked at so near 31.2 N, degrees
    double most;   // between the two
    double edge;   // between b and the inset's raster
};

static void add_difference(void *user, tile_id id)
{
    struct difference *d = user;
    static float a[SAMPLES], b[SAMPLES];
    if (id.zoom != d->zoom) return;
    assert_int_equal(planet_file_read_height(d->a, id, a), OK);
    assert_int_equal(planet_file_read_height(d->b, id, b), OK);
    for (int i = 0; i < SAMPLES; i++) {
        double lat, lon;
        sample_place(id, i, &lat, &lon);
        assert_true(isnan(a[i]) == isnan(b[i]));
        if (isnan(a[i]) || fabs(lat / RAD - 31.2) < d->beside) continue;
        d->most = fmax(d->most, fabs((double)a[i] - (double)b[i]));
        d->edge = fmax(d->edge, fabs((double)b[i] - higher(1, lon / RAD, lat / RAD)));
    }
}

static struct difference difference_of(const char *a, const char *b, int zoom, double beside)
{
    struct difference d = {open_planet(a), open_planet(b), zoom, beside, 0, 0};
    assert_int_equal(planet_file_list(d.a, LAYER_HEIGHT, add_difference, &d), OK);
    planet_file_close(&d.a);
    planet_file_close(&d.b);
    return d;
}

// Heights as floats, sharp seams: whatever the order, the same planet, bit by bit.
static void added_is_imported_together(void **state)
{
    (void)state;
    static const import_params exact = {0}, add = {.add = true};
    import("joint.planet", &exact, NAMES("globe.tif", "middle.tif", "inset.tif", "corner.tif"));
    import("added.planet", &exact, NAMES("globe.tif"));
    import("added.planet", &add, NAMES("inset.tif", "middle.tif", "corner.tif"));
    assert_same("joint.planet", "added.planet");
    // What is coarser does not hide what the planet has finer.
    import("added.planet", &exact, NAMES("globe.tif", "inset.tif", "corner.tif"));
    import("added.planet", &add, NAMES("middle.tif"));
    for (int zoom = 0; zoom <= 4; zoom++) // what finer tiles made is taken off in floats
        assert_true(difference_of("joint.planet", "added.planet", zoom, 0).most < 0.002);
    import("joint.planet", &exact, NAMES("region.tif", "inset.tif"));
    import("added.planet", &exact, NAMES("region.tif"));
    import("added.planet", &add, NAMES("inset.tif"));
    assert_same("joint.planet", "added.planet");
}

// Blended over 40 rows into what lies 300 m lower: as if imported together, but that what lies
// below is upsampled from the planet's samples.
static void seams_are_blended(void **state)
{
    (void)state;
    static const import_params feather = {.feather_rows = 40, .quantum = QUANTUM_AUTO};
    static const import_params add = {.feather_rows = 40, .add = true};
    import("joint.planet", &feather, NAMES("globe.tif", "inset.tif"));
    import("added.planet", &feather, NAMES("globe.tif"));
    import("added.planet", &add, NAMES("inset.tif"));
    struct difference d = difference_of("joint.planet", "added.planet", 4, 0);
    print_message("at most %.3f m from the joint import, %.1f m from the raster at its edge\n",
                  d.most, d.edge);
    assert_true(d.edge > 200); // it is blended
    assert_true(d.most < 3);
    // Over a planet that ends inside the inset, at 31.2 N: blended into what it has, and not into
    // what it has not. Within two of its samples of its end nothing is taken from it, and what is
    // shown there is a spline that reaches two further.
    import("joint.planet", &feather, NAMES("region.tif", "inset.tif"));
    import("added.planet", &feather, NAMES("region.tif"));
    import("added.planet", &add, NAMES("inset.tif"));
    d = difference_of("joint.planet", "added.planet", 4, 4.5 * grid_step_lat(2) / RAD);
    print_message("over a region's end at most %.3f m\n", d.most);
    assert_true(d.most < 3);
}

struct check {
    struct planet_file *exact, *base, *added;
    double worst_old, worst_new;
    int old, fresh, beyond; // tiles; samples of old ones beyond the bound
};

static void check_tile(void *user, tile_id id)
{
    struct check *c = user;
    static float want[SAMPLES], got[SAMPLES], before[SAMPLES];
    assert_int_equal(planet_file_read_height(c->exact, id, want), OK);
    assert_int_equal(planet_file_read_height(c->added, id, got), OK);
    bool old = planet_file_read_height(c->base, id, before) == OK;
    float min, max;
    assert_int_equal(planet_file_read_range(c->added, id, &min, &max), OK);
    double *worst = old ? &c->worst_old : &c->worst_new;
    for (int i = 0; i < SAMPLES; i++) {
        assert_true(isnan(want[i]) == isnan(got[i]));
        if (isnan(want[i])) continue;
        double off = fabs((double)want[i] - (double)got[i]);
        *worst = fmax(*worst, off);
        c->beyond += old && off > 4 * 1.15;
        assert_true(got[i] >= min && got[i] <= max);
    }
    c->old += old;
    c->fresh += !old;
}

// A planet within a bound stays within it, old tiles and new ones; every tile can be read. The
// exception is a sample at the border of finer data, whose two parts are both off.
static void the_bound_is_kept(void **state)
{
    (void)state;
    static const import_params bounded = {.max_error = 4}, exact = {0}, add = {.add = true};
    import("exact.planet", &exact, NAMES("globe.tif", "middle.tif", "inset.tif"));
    import("base.planet", &bounded, NAMES("globe.tif", "middle.tif"));
    import("added.planet", &bounded, NAMES("globe.tif", "middle.tif"));
    import("added.planet", &add, NAMES("inset.tif"));
    struct check c = {.exact = open_planet("exact.planet"),
                      .base = open_planet("base.planet"),
                      .added = open_planet("added.planet")};
    assert_true(planet_file_meta(c.added)->max_error == 4);
    assert_int_equal(planet_file_list(c.exact, LAYER_HEIGHT, check_tile, &c), OK);
    print_message("%d old tiles within %.3f m, but %d samples, %d new ones within %.3f m\n", c.old,
                  c.worst_old, c.beyond, c.fresh, c.worst_new);
    // The grid's half steps of four zooms beside the bound.
    assert_true(c.worst_old < 2 * 4 && c.worst_new < 4 * 1.15 && c.beyond < 10);
    assert_true(c.worst_old > 2 && c.worst_new > 1 && c.fresh >= 4);
    planet_file_close(&c.exact);
    planet_file_close(&c.base);
    planet_file_close(&c.added);
}

static void colour_is_painted_over(void **state)
{
    (void)state;
    static const import_params first = {0}, add = {.add = true};
    static unsigned char before[3 * SAMPLES], after[3 * SAMPLES];
    import("paint.planet", &first, NAMES("globe.tif", "colour.tif"));
    import("painted.planet", &first, NAMES("globe.tif", "colour.tif"));
    import("painted.planet", &add, NAMES("red.tif"));
    struct planet_file *a = open_planet("paint.planet"), *b = open_planet("painted.planet");
    int index;
    tile_id inside = tile_at(LAYER_COLOR, 3, 10 * RAD, -50 * RAD, &index);
    assert_int_equal(planet_file_read_pixels(b, inside, after), OK);
    assert_true(after[3 * index] > 240 && after[3 * index + 1] < 16);
    // In a tile of the raster's zoom, beside it: what the planet shows there, upsampled.
    tile_id beside = tile_at(LAYER_COLOR, 3, 10 * RAD, -60.8 * RAD, &index);
    assert_int_equal(planet_file_read_pixels(b, beside, after), OK);
    for (int c = 0; c < 3; c++)
        assert_true(fabs(after[3 * index + c] - bands(c + 1, -60.8, 10)) < 8);
    // Far away nothing has changed.
    tile_id far = tile_at(LAYER_COLOR, 0, 10 * RAD, 120 * RAD, &index);
    assert_int_equal(planet_file_read_pixels(a, far, before), OK);
    assert_int_equal(planet_file_read_pixels(b, far, after), OK);
    assert_memory_equal(before, after, sizeof before);
    planet_file_close(&a);
    planet_file_close(&b);
}

static bool stop_soon(void *user, const char *stage, double done)
{
    (void)done;
    int *calls = user;
    return strcmp(stage, "joining") == 0 || ++*calls > 1;
}

// Stopped, it leaves the planet as it was; gone on with, it is the same as in one go.
static void stopped_and_gone_on_with(void **state)
{
    (void)state;
    int calls = 0, all;
    const import_params first = {.quantum = QUANTUM_AUTO}, add = {.add = true};
    const import_params stopped = {.add = true, .progress = stop_soon, .user = &calls};
    const import_params resumed = {.add = true, .resume = true};
    import("once.planet", &first, NAMES("globe.tif"));
    import("twice.planet", &first, NAMES("globe.tif"));
    import("was.planet", &first, NAMES("globe.tif"));
    import("once.planet", &add, NAMES("inset.tif"));
    assert_int_equal(run("twice.planet", &stopped, NAMES("inset.tif")), ERR_CANCELLED);
    assert_int_equal(differing("was.planet", "twice.planet", &all), 0);
    import("twice.planet", &resumed, NAMES("inset.tif"));
    assert_same("once.planet", "twice.planet");
}

static bool kill_in(void *user, const char *stage, double done)
{
    (void)done;
    if (strcmp(stage, user) == 0) kill(getpid(), SIGKILL);
    return false;
}

// Killed as tiles are made, and as the parts are joined: the planet is as it was until the last
// moment; gone on with, it is the same as in one go. Fails when what is joined is written over the
// planet.
static void killed_and_gone_on_with(void **state)
{
    (void)state;
    static char *const stages[] = {"heights", "joining"};
    static const char *const bases[] = {"once.planet", "was.planet", "killed.planet"};
    const import_params first = {.quantum = QUANTUM_AUTO, .name = "Same"}, add = {.add = true};
    const import_params resumed = {.add = true, .resume = true};
    for (int i = 0; i < 3; i++) {
        import(bases[i], &first, NAMES("globe.tif"));
        // A planet says what it was added to, and of when that is.
        assert_int_equal(utime(in_dir(bases[i]), &(struct utimbuf){1000000000, 1000000000}), 0);
    }
    import("once.planet", &add, NAMES("inset.tif"));
    for (int i = 0; i < 2; i++) {
        const import_params killed = {
            .add = true, .resume = i > 0, .progress = kill_in, .user = stages[i]};
        pid_t child = fork();
        if (child == 0) _exit(run("killed.planet", &killed, NAMES("inset.tif")) != OK);
        int ended = 0;
        assert_int_equal(waitpid(child, &ended, 0), child);
        assert_true(WIFSIGNALED(ended) && WTERMSIG(ended) == SIGKILL);
        check_same_files(in_dir("was.planet"), in_dir("killed.planet"));
    }
    import("killed.planet", &resumed, NAMES("inset.tif"));
    check_same_files(in_dir("once.planet"), in_dir("killed.planet"));
}

static void bad_bases_are_named(void **state)
{
    (void)state;
    static const import_params add = {.add = true};
    assert_int_equal(run("absent.planet", &add, NAMES("inset.tif")), ERR_NOT_FOUND);
    assert_non_null(strstr(logged, "absent.planet"));
    assert_int_equal(run("globe.tif", &add, NAMES("inset.tif")), ERR_FORMAT);
    assert_non_null(strstr(logged, "globe.tif"));
    assert_int_equal(access(in_dir("absent.planet.part"), F_OK), -1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(added_is_imported_together),
        cmocka_unit_test(only_what_is_touched_is_made),
        cmocka_unit_test(seams_are_blended),
        cmocka_unit_test(the_bound_is_kept),
        cmocka_unit_test(colour_is_painted_over),
        cmocka_unit_test(stopped_and_gone_on_with),
        cmocka_unit_test(killed_and_gone_on_with),
        cmocka_unit_test(bad_bases_are_named),
    };
    return cmocka_run_group_tests(tests, make_rasters, remove_test_dir);
}
