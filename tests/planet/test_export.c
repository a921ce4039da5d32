// A planet as a folder of tiles: every tile of heights, colour and lights is what the planet holds,
// the document says where each one is and names no other, and what fails leaves no document.
// Fails when broken: heights cut off instead of rounded; no data written as a height; lights read
// as three channels; tiles of one colour written as the planet stores them (so it was); a run of
// neighbours in the document that goes on over a gap; a document in spite of a failure; a failing
// fwrite passed over.
#include "test_import_common.h"

#include <ftw.h>
#include <signal.h>
#include <sys/resource.h>

#include "planet/export.h"
#include "planet/image_decode.h"
#include "planet/source_spec.h"

enum { SAMPLES = TILE_SIZE * TILE_SIZE };

// Rough land, a plain that fills whole tiles, and a hole.
static double land(int band, double lon, double lat)
{
    (void)band;
    if (lon > 100 && lat > 40) return -9999;
    if (lon < -90 && lat < 0) return 12;
    return 900 * sin(lon * 0.11) * cos(lat * 0.13) + 60 * sin(lon * 2.7 + lat * 1.9) + 0.003;
}

static double waves(int band, double lon, double lat)
{
    return lon < -90 ? 60 * band : 128 + 20 * band * sin(lon * 0.05) * cos(lat * 0.04);
}

static double lights(int band, double lon, double lat)
{
    (void)band;
    return lon > 0 && lat > 0 ? 100 + 90 * sin(lon * 0.1) : 0;
}

static const double none = -9999;

static const raster_spec rasters[] = {
    {.name = "heights.tif", .bands = 1, .type = GDT_Float32, .value = land, .nodata = &none},
    {.name = "colour.tif", .bands = 3, .type = GDT_Byte, .value = waves},
    {.name = "night.tif", .bands = 1, .type = GDT_Byte, .value = lights},
    // Finer, and not everywhere: a row of its tiles has a gap.
    {.name = "west.tif", .bands = 1, .type = GDT_Float32, .value = land, .nodata = &none},
    {.name = "east.tif", .bands = 1, .type = GDT_Float32, .value = land, .nodata = &none},
};

static void make_planet(const char *name, double quantum, double max_error)
{
    static const enum tile_layer layers[] = {LAYER_HEIGHT, LAYER_COLOR, LAYER_NIGHT, LAYER_HEIGHT,
                                             LAYER_HEIGHT};
    import_source sources[5];
    char paths[5][512], out[512];
    for (int i = 0; i < 5; i++) {
        snprintf(paths[i], sizeof paths[i], "%s", in_dir(rasters[i].name));
        sources[i] = (import_source){.layer = layers[i], .path = paths[i]};
    }
    snprintf(out, sizeof out, "%s", in_dir(name));
    import_params p = {.sources = sources,
                       .source_count = 5,
                       .output = out,
                       .name = "Exported",
                       .attribution = "Nobody",
                       .quantum = quantum,
                       .max_error = max_error,
                       .threads = 2};
    if (import_run(&p)) fail_msg("%s", logged);
}

static int set_up(void **state)
{
    if (make_test_dir(state)) return -1;
    for (int i = 0; i < 5; i++) {
        raster_spec s = rasters[i];
        s.crs = "EPSG:4326";
        s.width = i < 3 ? 1024 : 200;
        s.height = s.width / 2;
        double step = i < 3 ? 360.0 / 1024 : 0.1, west = i < 3 ? -180 : i == 3 ? 3 : 95;
        memcpy(s.transform, (double[6]){west, step, 0, i < 3 ? 90 : 30, 0, -step},
               sizeof s.transform);
        write_raster(&s);
    }
    make_planet("exact.planet", 0, 0);
    return 0;
}

static int remove_one(const char *path, const struct stat *info, int kind, struct FTW *at)
{
    (void)info, (void)kind, (void)at;
    return remove(path);
}

static int remove_all(void **state)
{
    (void)state;
    return nftw(test_dir, remove_one, 16, FTW_DEPTH | FTW_PHYS);
}

static size_t read_file(const char *path, unsigned char *out, size_t room)
{
    FILE *f = fopen(path, "rb");
    if (!f) return 0;
    size_t size = fread(out, 1, room, f);
    fclose(f);
    return size;
}

struct check {
    struct planet_file *file;
    const char *folder;
    const source_spec *spec;
    int tiles, holes;
    double worst[LAYER_COUNT];
};

static const spec_layer *layer_of(const source_spec *spec, enum tile_layer layer)
{
    for (int i = 0; i < spec->count; i++)
        if (spec->layers[i].layer == layer) return &spec->layers[i];
    fail_msg("the document has no %s", tile_layer_name(layer));
    return NULL;
}

// The tile's picture, at the place that the document says.
static void read_picture(const struct check *c, tile_id id, uint8_t *rgba)
{
    static unsigned char body[SAMPLES * 5];
    static const char base[] = "http://host/folder/";
    char url[SPEC_URL_SIZE], why[IMAGE_WHY_SIZE], path[SPEC_URL_SIZE + 512];
    source_spec_url(layer_of(c->spec, id.layer), id.zoom, id.col, id.row, url);
    assert_int_equal(strncmp(url, base, sizeof base - 1), 0);
    snprintf(path, sizeof path, "%s/%s", c->folder, url + sizeof base - 1);
    size_t size = read_file(path, body, sizeof body);
    if (size == 0) fail_msg("%s: is not there", path);
    if (image_decode(body, size, TILE_SIZE, rgba, why)) fail_msg("%s: %s", path, why);
}

static void check_tile(void *user, tile_id id)
{
    struct check *c = user;
    static uint8_t rgba[SAMPLES * 4];
    static float heights[SAMPLES];
    static unsigned char pixels[SAMPLES * 3];
    read_picture(c, id, rgba);
    if (id.layer == LAYER_HEIGHT)
        assert_int_equal(planet_file_read_height(c->file, id, heights), OK);
    else assert_int_equal(planet_file_read_pixels(c->file, id, pixels), OK);
    for (int i = 0; i < SAMPLES; i++) {
        const uint8_t *p = rgba + 4 * i;
        double off = 0;
        if (id.layer == LAYER_HEIGHT) {
            assert_int_equal(p[3] == 0, isnan(heights[i]) != 0);
            c->holes += p[3] == 0;
            double coded = p[0] * 256.0 + p[1] + p[2] / 256.0 - 32768;
            off = p[3] ? fabs(coded - (double)heights[i]) : 0;
        } else if (id.layer == LAYER_COLOR) {
            for (int k = 0; k < 3; k++) off = fmax(off, abs(p[k] - pixels[3 * i + k]));
        } else off = abs(p[0] - pixels[i]);
        c->worst[id.layer] = fmax(c->worst[id.layer], off);
    }
    c->tiles++;
}

static int tiles_named(const source_spec *spec)
{
    int count = 0;
    for (int i = 0; i < spec->count; i++)
        for (size_t k = 0; k < spec->layers[i].range_count; k++)
            count += spec->layers[i].ranges[k].last - spec->layers[i].ranges[k].first + 1;
    return count;
}

static void check_named(void *user, tile_id id)
{
    struct check *c = user;
    const spec_layer *l = layer_of(c->spec, id.layer);
    int named = 0;
    for (size_t k = 0; k < l->range_count; k++) {
        const spec_range *r = &l->ranges[k];
        named += r->zoom == id.zoom && r->row == id.row && r->first <= id.col && id.col <= r->last;
    }
    assert_int_equal(named, 1);
}

static void check_export(const char *planet, const char *folder)
{
    static unsigned char text[1 << 20];
    char out[512], in[512], path[600];
    source_spec spec;
    export_result result;
    snprintf(in, sizeof in, "%s", in_dir(planet));
    snprintf(out, sizeof out, "%s", in_dir(folder));
    const export_params p = {.input = in, .output = out, .threads = 2};
    assert_int_equal(export_run(&p, &result), OK);
    snprintf(path, sizeof path, "%s/planet.json", out);
    size_t size = read_file(path, text, sizeof text);
    assert_int_equal(
        source_spec_parse((const char *)text, size, "http://host/folder/planet.json", &spec), OK);
    struct check c = {.file = open_planet(planet), .folder = out, .spec = &spec};
    const struct planet_meta *m = planet_file_meta(c.file);
    assert_string_equal(spec.meta.name, "Exported");
    assert_string_equal(spec.meta.attribution, "Nobody");
    assert_memory_equal(spec.meta.max_zoom, m->max_zoom, sizeof m->max_zoom);
    check_near(spec.meta.ellipsoid.b, m->ellipsoid.b, 1e-6);
    check_near(spec.meta.height_max, m->height_max, 1e-3);
    check_near(spec.meta.synthesis_gain, m->synthesis_gain, 1e-9);
    assert_int_equal(layer_of(&spec, LAYER_HEIGHT)->encoding, ENCODING_TERRARIUM);
    for (int layer = 0; layer < LAYER_COUNT; layer++) {
        assert_int_equal(planet_file_list(c.file, (enum tile_layer)layer, check_tile, &c), OK);
        assert_int_equal(planet_file_list(c.file, (enum tile_layer)layer, check_named, &c), OK);
    }
    print_message("%s: %d tiles, heights within %.5f m, colours within %.0f, lights within %.0f\n",
                  planet, c.tiles, c.worst[LAYER_HEIGHT], c.worst[LAYER_COLOR],
                  c.worst[LAYER_NIGHT]);
    assert_int_equal(c.tiles, result.tiles);
    assert_int_equal(c.tiles, tiles_named(&spec));
    assert_true(c.holes > 1000);
    check_near(c.worst[LAYER_HEIGHT], 0, 1.0 / 512);
    check_near(c.worst[LAYER_COLOR], 0, 3); // those stored as one value, and two decoders
    check_near(c.worst[LAYER_NIGHT], 0, 3);
    planet_file_close(&c.file);
    source_spec_deinit(&spec);
}

static void test_exact(void **state)
{
    (void)state;
    check_export("exact.planet", "exact");
}

// Heights that hang on their parents are written as they are decoded.
static void test_bounded(void **state)
{
    (void)state;
    make_planet("bounded.planet", QUANTUM_AUTO, 2);
    check_export("bounded.planet", "bounded");
}

static bool stop_at_once(void *user, const char *stage, double done)
{
    (void)user, (void)stage, (void)done;
    return true;
}

// Stopped, or without room, there is no document; a folder that has one is left alone unless asked.
static void test_faults(void **state)
{
    (void)state;
    char in[512], out[512], path[600];
    export_result result;
    snprintf(in, sizeof in, "%s", in_dir("exact.planet"));
    snprintf(out, sizeof out, "%s", in_dir("faults"));
    snprintf(path, sizeof path, "%s/planet.json", out);
    export_params p = {.input = in, .output = out, .threads = 2, .progress = stop_at_once};
    assert_int_equal(export_run(&p, &result), ERR_CANCELLED);
    assert_int_equal(access(path, F_OK), -1);
    p.progress = NULL;
    logged[0] = '\0';
    signal(SIGXFSZ, SIG_IGN);
    struct rlimit was, limit;
    getrlimit(RLIMIT_FSIZE, &was);
    limit = was;
    limit.rlim_cur = 4000;
    setrlimit(RLIMIT_FSIZE, &limit);
    status s = export_run(&p, &result);
    setrlimit(RLIMIT_FSIZE, &was);
    assert_int_equal(s, ERR_IO);
    assert_non_null(strstr(logged, "faults/"));
    assert_int_equal(access(path, F_OK), -1);
    assert_int_equal(export_run(&p, &result), OK);
    assert_int_equal(access(path, F_OK), 0);
    logged[0] = '\0';
    assert_int_equal(export_run(&p, &result), ERR_ARGUMENT);
    assert_non_null(strstr(logged, "planet.json: exists"));
    p.force = true;
    assert_int_equal(export_run(&p, &result), OK);
    p.input = out; // no planet file
    assert_int_not_equal(export_run(&p, &result), OK);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact),
        cmocka_unit_test(test_bounded),
        cmocka_unit_test(test_faults),
    };
    return cmocka_run_group_tests(tests, set_up, remove_all);
}
