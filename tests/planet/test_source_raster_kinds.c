// Rasters of every kind shown without an import: where their samples lie, what they say of units,
// scales and gaps, and their colours. Oracle of heights: the function that was written, at each
// sample's own place.
// Fails when broken: feet for metres; scales passed over; globes not closed (1.8 m, half a
// sample), or their masks left out (globes); no data taken for heights; a palette's
// numbers for grey; colour not multiplied by its coverage; 16 bits cut to 8 instead of scaled.
#include "test_import_common.h"

#include "planet/source_raster.h"
#include "planet/want.h"

enum { SAMPLES = TILE_SIZE * TILE_SIZE };

static double by_degrees(int band, double lon, double lat)
{
    (void)band;
    return 1000 + 700 * sin(lon * RAD * 2) * cos(lat * RAD) + 10 * lat;
}

static struct source *open_raster(const char *name, enum tile_layer layer)
{
    struct source *source;
    logged[0] = '\0';
    if (source_raster_open(in_dir(name), layer, &source)) fail_msg("%s", logged);
    return source;
}

static void read_tile(struct source *source, tile_id id, void *samples)
{
    double until_s;
    struct want *want = want_create(0);
    assert_int_equal(source_read(source, id, want, samples, &until_s), OK);
    want_release(&want);
}

typedef struct box {
    double west, south, east, north;
} box;

// Greatest error at places in a box, at the finest zoom; and that none of them has a gap.
static double worst_in(const char *name, box b)
{
    static float heights[SAMPLES];
    struct source *source = open_raster(name, LAYER_HEIGHT);
    int zoom = source->meta.max_zoom[LAYER_HEIGHT];
    double worst = 0;
    for (int i = 0; i <= 6; i++)
        for (int k = 0; k <= 6; k++) {
            double lat = b.south + (b.north - b.south) * i / 6, at, on,
                   lon = geo_wrap_lon((b.west + (b.east - b.west) * k / 6) * RAD);
            int index;
            tile_id id = tile_at(LAYER_HEIGHT, zoom, lat * RAD, lon, &index);
            read_tile(source, id, heights);
            sample_place(id, index, &at, &on);
            double off = fabs((double)heights[index] - by_degrees(1, on / RAD, at / RAD));
            if (isnan(off)) fail_msg("%s: nothing at %g N %g E", name, lat, lon / RAD);
            worst = fmax(worst, off);
        }
    source_close(&source);
    return worst;
}

static const raster_spec inset = {.name = "inset.tif",
                                  .width = 200,
                                  .height = 100,
                                  .bands = 1,
                                  .type = GDT_Float32,
                                  .crs = "EPSG:4326",
                                  .transform = {10, 0.1, 0, 50, 0, -0.1},
                                  .value = by_degrees};
static const box inner = {10.5, 40.5, 29.5, 49.5};

static void check_placed(const raster_spec *s, box b, double tolerance)
{
    write_raster(s);
    double worst = worst_in(s->name, b);
    print_message("%s: off by %.3f m\n", s->name, worst);
    check_near(worst, 0, tolerance);
}

static double by_degrees_in_feet(int band, double lon, double lat)
{
    return by_degrees(band, lon, lat) / 0.3048;
}

static void test_geographic(void **state)
{
    (void)state;
    check_placed(&inset, inner, 0.2);
    raster_spec s = inset;
    s.name = "southup.tif";
    s.transform[3] = 40;
    s.transform[5] = 0.1;
    check_placed(&s, inner, 0.2);
    s = inset;
    s.name = "scaled.tif";
    s.type = GDT_Int16;
    s.scale = 0.1;
    s.offset = 500;
    check_placed(&s, inner, 0.3);
    s = inset;
    s.name = "dateline.tif";
    s.transform[0] = 172;
    check_placed(&s, (box){172.5, 40.5, 191.5, 49.5}, 0.2);
    s = inset;
    s.name = "feet.tif";
    s.value = by_degrees_in_feet;
    GDALDatasetH d = create_raster(&s);
    fill_band(d, &s, 1);
    GDALSetRasterUnitType(GDALGetRasterBand(d, 1), "ft");
    GDALClose(d);
    check_near(worst_in("feet.tif", inner), 0, 0.2);
}

// All the way round from Greenwich, from the antimeridian, and from half a sample beside it: all of
// it is there, and between the last sample and the first it is what it is between any others.
static void test_globes(void **state)
{
    (void)state;
    static const struct {
        double west;
        const char *crs;
    } cases[] = {{0, "EPSG:4326"},
                 {0, "EPSG:4258"},
                 {0, "+proj=longlat +datum=WGS84 +no_defs"},
                 {-180, "EPSG:4326"},
                 {-180.25, "EPSG:4326"}};
    raster_spec globe = inset;
    globe.name = "globe.tif";
    globe.width = 720;
    globe.height = 360;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        globe.crs = cases[i].crs;
        memcpy(globe.transform, (double[6]){cases[i].west, 0.5, 0, 90, 0, -0.5},
               sizeof globe.transform);
        check_placed(&globe, (box){-179.9, -88, 179.9, 88}, 0.2);
        for (int seam = 0; seam <= 180; seam += 180)
            check_near(worst_in("globe.tif", (box){seam - 0.5, -60, seam + 0.5, 60}), 0, 0.2);
    }
}

static OGRCoordinateTransformationH to_degrees;

static double by_projected(int band, double x, double y)
{
    assert_true(OCTTransform(to_degrees, 1, &x, &y, NULL));
    return by_degrees(band, x, y);
}

static void check_projected(const char *name, const char *crs, int size, double west, double north,
                            double step, box b, double tolerance)
{
    OGRSpatialReferenceH from = OSRNewSpatialReference(NULL), to = OSRNewSpatialReference(NULL);
    OSRSetFromUserInput(from, crs);
    OSRSetWellKnownGeogCS(to, "WGS84");
    OSRSetAxisMappingStrategy(from, OAMS_TRADITIONAL_GIS_ORDER);
    OSRSetAxisMappingStrategy(to, OAMS_TRADITIONAL_GIS_ORDER);
    to_degrees = OCTNewCoordinateTransformation(from, to);
    raster_spec s = {.name = name,
                     .width = size,
                     .height = size,
                     .bands = 1,
                     .type = GDT_Float32,
                     .crs = crs,
                     .transform = {west, step, 0, north, 0, -step},
                     .value = by_projected};
    check_placed(&s, b, tolerance);
    OCTDestroyCoordinateTransformation(to_degrees);
    OSRDestroySpatialReference(from);
    OSRDestroySpatialReference(to);
}

static void test_projected(void **state)
{
    (void)state;
    check_projected("utm.tif", "EPSG:32632", 200, 400000, 5300000, 500,
                    (box){7.8, 47.05, 8.9, 47.75}, 0.5);
    check_projected("fiji.tif", "EPSG:32760", 300, 700000, 8100000, 1000,
                    (box){179.2, -18.7, 181.2, -17.4}, 1);
    check_projected("arctic.tif", "EPSG:3413", 400, -2e6, 2e6, 1e4, (box){-180, 75, 180, 89.9}, 6);
    check_projected("antarctic.tif", "EPSG:3031", 400, -2e6, 2e6, 1e4, (box){-180, -89.9, 180, -75},
                    6);
    double edge = 20037508.342789244;
    check_projected("mercator.tif", "EPSG:3857", 512, -edge, edge, edge / 256,
                    (box){-179, -80, 179, 80}, 12);
}

static double with_holes(int band, double lon, double lat)
{
    return lon > 14 && lon < 16 ? -9999 : by_degrees(band, lon, lat);
}

static void test_gaps(void **state)
{
    (void)state;
    static float heights[SAMPLES];
    static const double none = -9999;
    raster_spec s = inset;
    s.name = "holes.tif";
    s.value = with_holes;
    s.nodata = &none;
    write_raster(&s);
    struct source *source = open_raster(s.name, LAYER_HEIGHT);
    static const struct {
        double lon;
        bool there;
    } places[] = {{13.5, true}, {15, false}, {16.5, true}, {9.7, false}, {-120, false}};
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        int index, zoom = source->meta.max_zoom[LAYER_HEIGHT];
        tile_id id = tile_at(LAYER_HEIGHT, zoom, 45 * RAD, places[i].lon * RAD, &index);
        read_tile(source, id, heights);
        if (isnan(heights[index]) == places[i].there) fail_msg("at %g E", places[i].lon);
        if (places[i].there) check_near(heights[index], by_degrees(1, places[i].lon, 45), 4);
    }
    source_close(&source);
}

static const unsigned char colours[2][4] = {{200, 100, 50, 255}, {20, 60, 180, 128}};

static double two_colours(int band, double lon, double lat)
{
    (void)lat;
    return colours[lon > 20][band - 1];
}

static double deep_colours(int band, double lon, double lat)
{
    return 257 * two_colours(band, lon, lat);
}

// R, G, B times coverage, and coverage.
static void check_pixel(struct source *source, double lat, double lon, const unsigned char want[4],
                        double tolerance)
{
    static unsigned char rgba[SAMPLES * 4];
    int index;
    tile_id id =
        tile_at(LAYER_COLOR, source->meta.max_zoom[LAYER_COLOR], lat * RAD, lon * RAD, &index);
    read_tile(source, id, rgba);
    for (int c = 0; c < 4; c++) {
        double shown = c < 3 ? want[c] * want[3] / 255.0 : want[3];
        check_near(rgba[4 * index + c], shown, tolerance);
    }
}

static void test_colour(void **state)
{
    (void)state;
    static const unsigned char none[4] = {0}, dark[4] = {90, 90, 90, 255},
                               light[4] = {240, 240, 240, 255};
    raster_spec rgb = inset, rgba, grey, deep, palette;
    rgb.name = "rgb.tif";
    rgb.bands = 3;
    rgb.type = GDT_Byte;
    rgb.value = two_colours;
    rgba = rgb, rgba.name = "rgba.tif", rgba.bands = 4;
    deep = rgb, deep.name = "deep.tif", deep.type = GDT_UInt16, deep.value = deep_colours;
    grey = rgb, grey.name = "grey.tif", grey.bands = 1, grey.value = half_grey;
    palette = grey, palette.name = "palette.tif";
    write_raster(&rgb);
    write_raster(&deep);
    write_raster(&grey);
    GDALDatasetH d = create_raster(&rgba);
    for (int b = 1; b <= 4; b++) fill_band(d, &rgba, b);
    GDALSetRasterColorInterpretation(GDALGetRasterBand(d, 4), GCI_AlphaBand);
    GDALClose(d);
    write_palette(palette);
    static const char *const names[] = {"rgb.tif", "deep.tif", "palette.tif", "rgba.tif",
                                        "grey.tif"};
    for (int i = 0; i < 5; i++) {
        bool is_grey = i == 4;
        unsigned char east[4];
        memcpy(east, is_grey ? light : colours[1], 4);
        if (i != 3) east[3] = 255;
        // By its bands: no name of a layer is needed.
        struct source *source = open_raster(names[i], LAYER_COUNT);
        assert_int_equal(source->meta.max_zoom[LAYER_HEIGHT], -1);
        print_message("%s\n", names[i]);
        check_pixel(source, 45, 13, is_grey ? dark : colours[0], 1);
        check_pixel(source, 45, 27, east, 1);
        check_pixel(source, 45, 8, none, 1);
        check_pixel(source, 45, -100, none, 1);
        source_close(&source);
    }
}

static double waves_of_colour(int band, double lon, double lat)
{
    return band == 4 ? (lat > 0 ? 255 : 0) : 120 + 30 * band * sin(lon * RAD);
}

// All the way round with coverage, and with a mask, which both end at the equator: closed where its
// ends meet, and there is nothing in the south.
static void test_globes_of_colour(void **state)
{
    (void)state;
    static const double wests[] = {0, -180};
    raster_spec globe = inset;
    globe.name = "colours.tif";
    globe.width = 360;
    globe.height = 180;
    globe.type = GDT_Byte;
    globe.value = waves_of_colour;
    for (int i = 0; i < 4; i++) {
        bool masked = i % 2;
        globe.bands = masked ? 3 : 4;
        memcpy(globe.transform, (double[6]){wests[i / 2], 1, 0, 90, 0, -1}, sizeof globe.transform);
        GDALDatasetH d = create_raster(&globe);
        for (int b = 1; b <= globe.bands; b++) fill_band(d, &globe, b);
        if (!masked) GDALSetRasterColorInterpretation(GDALGetRasterBand(d, 4), GCI_AlphaBand);
        else assert_int_equal(GDALCreateDatasetMaskBand(d, GMF_PER_DATASET), CE_None);
        unsigned char line[360];
        for (int y = 0; masked && y < 180; y++) {
            memset(line, y < 90 ? 255 : 0, sizeof line);
            assert_int_equal(GDALRasterIO(GDALGetMaskBand(GDALGetRasterBand(d, 1)), GF_Write, 0, y,
                                          360, 1, line, 360, 1, GDT_Byte, 0, 0),
                             CE_None);
        }
        GDALClose(d);
        struct source *source = open_raster("colours.tif", LAYER_COLOR);
        static const double lons[] = {-179.9, -90, -0.1, 0.1, 90, 179.9};
        for (int k = 0; k < 6; k++) {
            unsigned char want[4] = {0, 0, 0, 255};
            for (int c = 0; c < 3; c++)
                want[c] = (unsigned char)waves_of_colour(c + 1, lons[k], 45);
            check_pixel(source, 45, lons[k], want, 3);
            check_pixel(source, -45, lons[k], (unsigned char[4]){0}, 0);
        }
        source_close(&source);
    }
}

static void test_refused(void **state)
{
    (void)state;
    struct source *source;
    raster_spec s = inset;
    s.name = "nowhere.tif";
    memset(s.transform, 0, sizeof s.transform);
    s.crs = NULL;
    s.width = s.height = 8;
    write_raster(&s);
    static const struct {
        const char *name, *said;
        status want;
    } cases[] = {{"nowhere.tif", "no georeference", ERR_ARGUMENT},
                 {"absent.tif", "No such file", ERR_NOT_FOUND},
                 {"text.tif", "neither a planet file nor a raster", ERR_FORMAT}};
    FILE *f = fopen(in_dir("text.tif"), "w");
    fputs("not a raster\n", f);
    fclose(f);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        logged[0] = '\0';
        assert_int_equal(source_raster_open(in_dir(cases[i].name), LAYER_COUNT, &source),
                         cases[i].want);
        assert_null(source);
        if (!strstr(logged, cases[i].said) || !strstr(logged, cases[i].name))
            fail_msg("%s: said %s", cases[i].name, logged);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_geographic), cmocka_unit_test(test_globes),
        cmocka_unit_test(test_projected),  cmocka_unit_test(test_gaps),
        cmocka_unit_test(test_colour),     cmocka_unit_test(test_globes_of_colour),
        cmocka_unit_test(test_refused),
    };
    return cmocka_run_group_tests(tests, make_test_dir, remove_test_dir);
}
