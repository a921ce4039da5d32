// A raster shown without an import: what it says, of what it reads no more than the tile needs.
// Fails when overviews are passed over (`-ovr NONE`: the mark is not seen), or when anything
// outside a tile's window is read (the broken blocks are met).
#include "test_import_common.h"

#include <cpl_string.h>

#include "planet/source_raster.h"
#include "planet/want.h"

enum { SAMPLES = TILE_SIZE * TILE_SIZE, SIZE = 2048, BLOCK = 256 };

static double slope(int band, double x, double y)
{
    (void)band;
    return 100 + 10 * x + 7 * y;
}

// 30 degrees at the equator, in blocks of 256, with overviews.
static const raster_spec spec = {.name = "blocks.tif",
                                 .width = SIZE,
                                 .height = SIZE,
                                 .bands = 1,
                                 .type = GDT_Float32,
                                 .crs = "EPSG:4326",
                                 .transform = {0, 30.0 / SIZE, 0, 15, 0, -30.0 / SIZE},
                                 .value = slope};

static int make_raster(void **state)
{
    if (make_test_dir(state)) return -1;
    char **options = NULL;
    for (int i = 0; i < 4; i++) {
        static const char *const text[] = {"TILED=YES", "COMPRESS=DEFLATE", "BLOCKXSIZE=256",
                                           "BLOCKYSIZE=256"};
        options = CSLAddString(options, text[i]);
    }
    GDALDatasetH d = GDALCreate(GDALGetDriverByName("GTiff"), in_dir(spec.name), SIZE, SIZE, 1,
                                spec.type, options);
    CSLDestroy(options);
    assert_non_null(d);
    GDALSetGeoTransform(d, (double *)spec.transform);
    OGRSpatialReferenceH srs = OSRNewSpatialReference(NULL);
    OSRSetFromUserInput(srs, spec.crs);
    GDALSetSpatialRef(d, srs);
    OSRDestroySpatialReference(srs);
    fill_band(d, &spec, 1);
    int levels[] = {2, 4, 8};
    assert_int_equal(GDALBuildOverviews(d, "AVERAGE", 3, levels, 0, NULL, NULL, NULL), CE_None);
    GDALClose(d);
    return 0;
}

static struct source *open_raster(void)
{
    struct source *source;
    if (source_raster_open(in_dir(spec.name), LAYER_HEIGHT, &source)) fail_msg("%s", logged);
    return source;
}

static status read_tile(struct source *source, tile_id id, float *heights)
{
    double until_s;
    struct want *want = want_create(0);
    status s = source_read(source, id, want, heights, &until_s);
    want_release(&want);
    return s;
}

// Inside by two samples of the tile, beyond which interpolation meets the raster's end.
static double worst_error(tile_id id, const float *heights)
{
    double worst = 0, margin = 2 * grid_step_lat(id.zoom) / RAD;
    for (int i = 0; i < SAMPLES; i++) {
        double lat, lon;
        sample_place(id, i, &lat, &lon);
        lat /= RAD, lon /= RAD;
        if (lon < margin || lon > 30 - margin || fabs(lat) > 15 - margin) continue;
        worst = fmax(worst, fabs((double)heights[i] - slope(1, lon, lat)));
    }
    return worst;
}

static void samples_are_the_raster(void **state)
{
    (void)state;
    static float heights[SAMPLES];
    struct source *source = open_raster();
    for (int zoom = 1; zoom <= source->meta.max_zoom[LAYER_HEIGHT]; zoom++) {
        int index;
        tile_id id = tile_at(LAYER_HEIGHT, zoom, 8 * RAD, 11 * RAD, &index);
        assert_int_equal(read_tile(source, id, heights), OK);
        double worst = worst_error(id, heights), step = grid_step_lat(zoom) / RAD;
        print_message("zoom %d: off by %.3f m, %.3f samples of the tile\n", zoom, worst,
                      worst / (17 * step));
        assert_true(worst < 0.1 * 17 * step);
    }
    source_close(&source);
}

// The coarsest overview says another height: coarse tiles show that, fine ones do not.
static void overviews_are_used(void **state)
{
    (void)state;
    static float heights[SAMPLES];
    GDALDatasetH d =
        GDALOpenEx(in_dir(spec.name), GDAL_OF_RASTER | GDAL_OF_UPDATE, NULL, NULL, NULL);
    GDALRasterBandH overview = GDALGetOverview(GDALGetRasterBand(d, 1), 2);
    assert_non_null(overview);
    assert_int_equal(GDALFillRaster(overview, 5555, 0), CE_None);
    GDALClose(d);
    struct source *source = open_raster();
    int index, finest = source->meta.max_zoom[LAYER_HEIGHT];
    tile_id coarse = tile_at(LAYER_HEIGHT, finest - 4, 8 * RAD, 11 * RAD, &index);
    assert_int_equal(read_tile(source, coarse, heights), OK);
    check_near(heights[index], 5555, 0.01);
    tile_id fine = tile_at(LAYER_HEIGHT, finest, 8 * RAD, 11 * RAD, &index);
    assert_int_equal(read_tile(source, fine, heights), OK);
    assert_true(worst_error(fine, heights) < 1);
    source_close(&source);
}

// Every block but those around one place is made unreadable.
static void only_the_window_is_read(void **state)
{
    (void)state;
    static float heights[SAMPLES];
    static unsigned char file[64 << 20];
    struct source *source = open_raster();
    int index, finest = source->meta.max_zoom[LAYER_HEIGHT];
    tile_id id = tile_at(LAYER_HEIGHT, finest, 8 * RAD, 11 * RAD, &index);
    tile_id far = tile_at(LAYER_HEIGHT, finest, -12 * RAD, 26 * RAD, &index);
    double west, south, east, north;
    grid_bounds(id, &west, &south, &east, &north);
    source_close(&source);

    FILE *f = fopen(in_dir(spec.name), "rb");
    size_t size = fread(file, 1, sizeof file, f);
    fclose(f);
    GDALDatasetH d =
        GDALOpenEx(in_dir(spec.name), GDAL_OF_RASTER | GDAL_OF_READONLY, NULL, NULL, NULL);
    int broken = 0, kept = 0;
    const double wide = BLOCK * 30.0 / SIZE;
    for (int y = 0; y < SIZE / BLOCK; y++)
        for (int x = 0; x < SIZE / BLOCK; x++) {
            char key[64];
            double left = x * wide, top = 15 - y * wide, room = 4 * 30.0 / SIZE;
            bool near = left < east / RAD + room && left + wide > west / RAD - room &&
                        top > south / RAD - room && top - wide < north / RAD + room;
            snprintf(key, sizeof key, "BLOCK_OFFSET_%d_%d", x, y);
            const char *offset = GDALGetMetadataItem(GDALGetRasterBand(d, 1), key, "TIFF");
            assert_non_null(offset);
            kept += near;
            if (near) continue;
            memset(file + atoll(offset), 0xFF, 64);
            broken++;
        }
    GDALClose(d);
    f = fopen(in_dir(spec.name), "wb");
    assert_int_equal(fwrite(file, 1, size, f), size);
    fclose(f);
    source = open_raster();
    assert_int_equal(read_tile(source, id, heights), OK);
    assert_true(worst_error(id, heights) < 1);
    assert_int_not_equal(read_tile(source, far, heights), OK); // the blocks are broken
    print_message("%d blocks read or left whole, %d unreadable\n", kept, broken);
    assert_true(broken > 3 * kept);
    source_close(&source);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_are_the_raster),
        cmocka_unit_test(overviews_are_used),
        cmocka_unit_test(only_the_window_is_read),
    };
    return cmocka_run_group_tests(tests, make_raster, remove_test_dir);
}
