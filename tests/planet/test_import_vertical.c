// Rasters placed in unusual ways: vertical datums, axis orders, units, masks, the Moon, VRT and
// patterns. Oracle of the geoid: EGM96's published values (NGA's F477 test points and its 15'
// grid), not PROJ.
#include "test_import_common.h"

#include <gdal_utils.h>
#include <gdal_vrt.h>
#include <cpl_string.h>

static double level_500(int band, double x, double y)
{
    (void)band;
    (void)x;
    (void)y;
    return 500;
}

static double slope(int band, double lon, double lat)
{
    (void)band;
    return 100 * lat + 10 * lon;
}

static raster_spec patch(const char *name, double west, double north,
                         double (*value)(int, double, double))
{
    return (raster_spec){.name = name,
                         .width = 100,
                         .height = 100,
                         .bands = 1,
                         .type = GDT_Float32,
                         .crs = "EPSG:4326",
                         .transform = {west, 0.02, 0, north, 0, -0.02},
                         .value = value};
}

static status import_above(const char *name, const char *vertical, geo_ellipsoid body)
{
    static char path[512], out[512];
    snprintf(path, sizeof path, "%s", in_dir(name));
    snprintf(out, sizeof out, "%s", in_dir("v.planet"));
    import_source source = {.layer = LAYER_HEIGHT, .path = path, .vertical = vertical};
    import_params p = {.sources = &source,
                       .source_count = 1,
                       .output = out,
                       .ellipsoid = body,
                       .threads = 2,
                       .force = true};
    logged[0] = 0;
    return import_run(&p);
}

// Geoid heights of NGA's test points for EGM96 (OUTPUT.DAT of its program F477), metres.
static const struct {
    double lat, lon, metres;
} known[] = {
    {38.6281550, 269.7791550 - 360, -31.628}, {-14.6212170, 305.0211140 - 360, -2.969},
    {46.8743190, 102.4487290, -43.575},       {-23.6174460, 133.8747120, 15.871},
    {38.6254730, 359.9995000 - 360, 50.066},  {-0.4667440, 0.0023000, 17.329},
};

static void check_geoid(const char *crs, const char *said, bool shifted)
{
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        raster_spec s = patch("geoid.tif", known[i].lon - 1, known[i].lat + 1, level_500);
        s.crs = crs;
        write_raster(&s);
        status made = import_above("geoid.tif", said, GEO_WGS84);
        if (made) fail_msg("%s", logged);
        struct planet_file *f = open_planet("v.planet");
        int zoom = planet_file_meta(f)->max_zoom[LAYER_HEIGHT], index;
        tile_id id = tile_at(LAYER_HEIGHT, zoom, known[i].lat * RAD, known[i].lon * RAD, &index);
        double lat, lon, got = height_near(f, zoom, known[i].lat, known[i].lon) - 500;
        sample_place(id, index, &lat, &lon);
        print_message("%.3f %.3f: %.3f m, published %.3f m\n", known[i].lat, known[i].lon, got,
                      known[i].metres);
        // Half a sample of 0.02 degrees at a slope of up to 1e-4, and the 15' grid against the
        // harmonics.
        check_near(got, shifted ? known[i].metres : 0, shifted ? 0.35 : 1e-3);
        planet_file_close(&f);
    }
}

static void test_vertical(void **state)
{
    (void)state;
    check_geoid("EPSG:4326", "egm96", true);
    check_geoid("EPSG:4326+5773", NULL, true);
    check_geoid("EPSG:4326", NULL, false);
    check_geoid("EPSG:4326+5773", "ellipsoid", false);
}

// NGA's own grid at every sample of an Alpine tile of the finest zoom, where the lattice is coarse.
static void test_geoid_grid(void **state)
{
    (void)state;
    GDALDatasetH d = GDALOpen(SHARED_DATA "/geoid_egm96_15min_1440x721_f32.tif", GA_ReadOnly);
    if (!d) {
        print_message("skipped: " SHARED_DATA " has no geoid_egm96_15min_1440x721_f32.tif\n");
        skip();
    }
    float *n = malloc(1440 * 721 * sizeof *n);
    double g[6];
    GDALGetGeoTransform(d, g);
    assert_int_equal(GDALRasterIO(GDALGetRasterBand(d, 1), GF_Read, 0, 0, 1440, 721, n, 1440, 721,
                                  GDT_Float32, 0, 0),
                     CE_None);
    GDALClose(d);
    raster_spec s = patch("alps.tif", 9.9, 47.1, level_500);
    s.transform[1] = 0.002;
    s.transform[5] = -0.002;
    write_raster(&s);
    assert_int_equal(import_above("alps.tif", "egm96", GEO_WGS84), OK);
    struct planet_file *f = open_planet("v.planet");
    int zoom = planet_file_meta(f)->max_zoom[LAYER_HEIGHT];
    double most = 0;
    for (double lat = 46.91; lat < 47.09; lat += 0.0021)
        for (double lon = 9.91; lon < 10.09; lon += 0.0021) {
            int index;
            double at, on;
            tile_id id = tile_at(LAYER_HEIGHT, zoom, lat * RAD, lon * RAD, &index);
            sample_place(id, index, &at, &on);
            double x = (on / RAD - g[0]) / g[1] - 0.5, y = (at / RAD - g[3]) / g[5] - 0.5;
            int c = (int)floor(x), r = (int)floor(y);
            double u = x - c, v = y - r;
            const float *p = n + r * 1440 + c;
            double want = (1 - v) * ((1 - u) * (double)p[0] + u * (double)p[1]) +
                          v * ((1 - u) * (double)p[1440] + u * (double)p[1441]);
            most = fmax(most, fabs(height_near(f, zoom, lat, lon) - 500 - want));
        }
    print_message("zoom %d, greatest difference from NGA's grid %.4f m\n", zoom, most);
    check_near(most, 0, 0.02);
    planet_file_close(&f);
    free(n);
}

static void test_vertical_faults(void **state)
{
    (void)state;
    raster_spec s = patch("f.tif", 10, 50, level_500);
    write_raster(&s);
    assert_int_equal(import_above("f.tif", "sea", GEO_WGS84), ERR_ARGUMENT);
    assert_non_null(strstr(logged, "\"sea\""));
    assert_int_equal(import_above("f.tif", "EPSG:4326", GEO_WGS84), ERR_UNSUPPORTED);
    assert_int_equal(import_above("f.tif", "egm96", (geo_ellipsoid){.a = 1737400, .b = 1737400}),
                     ERR_ARGUMENT);
    assert_non_null(strstr(logged, "the planet is another"));
    status s2008 = import_above("f.tif", "egm2008", GEO_WGS84);
    if (s2008) assert_non_null(strstr(logged, "its grid is not installed"));
}

static void check_slope(const char *name, double west, double north, double tol)
{
    struct planet_file *f = open_planet(name);
    int zoom = planet_file_meta(f)->max_zoom[LAYER_HEIGHT];
    double most = 0;
    for (double y = 0.2; y < 1.8; y += 0.13)
        for (double x = 0.2; x < 1.8; x += 0.13) {
            int index;
            double lat, lon;
            tile_id id = tile_at(LAYER_HEIGHT, zoom, (north - y) * RAD, (west + x) * RAD, &index);
            sample_place(id, index, &lat, &lon);
            double got = height_near(f, zoom, north - y, west + x);
            most = fmax(most, fabs(got - slope(1, lon / RAD, lat / RAD)));
            if (isnan(got)) fail_msg("%s: no data at %g %g", name, north - y, west + x);
        }
    print_message("%s: zoom %d, worst %.4f m\n", name, zoom, most);
    check_near(most, 0, tol);
    planet_file_close(&f);
}

// x runs along latitude and y along longitude: EPSG:4326 as its authority orders it.
static double slope_turned(int band, double lat, double lon)
{
    return slope(band, lon, lat);
}

static void write_text(const char *name, const char *text)
{
    FILE *f = fopen(in_dir(name), "w");
    assert_non_null(f);
    fputs(text, f);
    fclose(f);
}

static void test_axes(void **state)
{
    (void)state;
    raster_spec s = patch("turned.tif", 48, 12, slope_turned);
    s.crs = NULL;
    write_raster(&s); // x: 48 to 50 of latitude, y: 12 down to 10 of longitude
    char vrt[2048];
    snprintf(vrt, sizeof vrt,
             "<VRTDataset rasterXSize=\"100\" rasterYSize=\"100\">"
             "<SRS dataAxisToSRSAxisMapping=\"1,2\">EPSG:4326</SRS>"
             "<GeoTransform>48, 0.02, 0, 12, 0, -0.02</GeoTransform>"
             "<VRTRasterBand dataType=\"Float32\" band=\"1\"><SimpleSource>"
             "<SourceFilename relativeToVRT=\"1\">turned.tif</SourceFilename>"
             "<SourceBand>1</SourceBand></SimpleSource></VRTRasterBand></VRTDataset>");
    write_text("latlon.vrt", vrt);
    assert_int_equal(import_heights("a.planet", "latlon.vrt"), OK);
    check_slope("a.planet", 10, 50, 0.02);
    raster_spec plain = patch("plain.tif", 10, 50, slope);
    write_raster(&plain);
    assert_int_equal(import_heights("a.planet", "plain.tif"), OK);
    check_slope("a.planet", 10, 50, 0.02);
    raster_spec back = patch("back.tif", 12, 50, slope);
    back.transform[1] = -0.02;
    write_raster(&back);
    assert_int_equal(import_heights("a.planet", "back.tif"), OK);
    check_slope("a.planet", 10, 50, 0.02);
    raster_spec turned = patch("rotated.tif", 12, 50, slope);
    turned.crs = "EPSG:4258"; // ETRS89
    turned.transform[0] = 10;
    write_raster(&turned);
    assert_int_equal(import_heights("a.planet", "rotated.tif"), OK);
    check_slope("a.planet", 10, 50, 0.02);
}

static double in_feet(int band, double lon, double lat)
{
    return slope(band, lon, lat) / 0.3048;
}

static void test_units(void **state)
{
    (void)state;
    raster_spec s = patch("feet.tif", 10, 50, in_feet);
    GDALDatasetH d = create_raster(&s);
    fill_band(d, &s, 1);
    GDALSetRasterUnitType(GDALGetRasterBand(d, 1), "ft");
    GDALClose(d);
    assert_int_equal(import_heights("u.planet", "feet.tif"), OK);
    check_slope("u.planet", 10, 50, 0.02);
}

// A mask of the dataset, without a no-data value.
static void test_mask(void **state)
{
    (void)state;
    raster_spec s = patch("masked.tif", 10, 50, slope);
    GDALDatasetH d = create_raster(&s);
    fill_band(d, &s, 1);
    assert_int_equal(GDALCreateDatasetMaskBand(d, GMF_PER_DATASET), CE_None);
    GDALRasterBandH mask = GDALGetMaskBand(GDALGetRasterBand(d, 1));
    unsigned char line[100];
    for (int x = 0; x < 100; x++) line[x] = x < 50 ? 255 : 0;
    for (int y = 0; y < 100; y++)
        assert_int_equal(GDALRasterIO(mask, GF_Write, 0, y, 100, 1, line, 100, 1, GDT_Byte, 0, 0),
                         CE_None);
    GDALClose(d);
    assert_int_equal(import_heights("m.planet", "masked.tif"), OK);
    struct planet_file *f = open_planet("m.planet");
    int zoom = planet_file_meta(f)->max_zoom[LAYER_HEIGHT];
    check_near(height_near(f, zoom, 49, 10.5), slope(1, 10.5, 49), 2);
    assert_true(isnan(height_near(f, zoom, 49, 11.5)));
    planet_file_close(&f);
}

static void test_moon(void **state)
{
    (void)state;
    raster_spec s = patch("moon.tif", 10, 50, slope);
    s.crs = "+proj=longlat +R=1737400 +no_defs";
    write_raster(&s);
    assert_int_equal(import_above("moon.tif", NULL, (geo_ellipsoid){.a = 1737400, .b = 1737400}),
                     OK);
    check_slope("v.planet", 10, 50, 0.02);
    raster_spec polar = patch("lunar-pole.tif", 0, 0, level_500);
    polar.crs = "+proj=stere +lat_0=90 +lon_0=0 +R=1737400 +no_defs";
    memcpy(polar.transform, (double[6]){-1e5, 2e3, 0, 1e5, 0, -2e3}, sizeof polar.transform);
    write_raster(&polar);
    assert_int_equal(
        import_above("lunar-pole.tif", NULL, (geo_ellipsoid){.a = 1737400, .b = 1737400}), OK);
    struct planet_file *f = open_planet("v.planet");
    int zoom = planet_file_meta(f)->max_zoom[LAYER_HEIGHT];
    for (double lon = -180; lon < 180; lon += 30) {
        check_near(height_near(f, zoom, 89.99, lon), 500, 1e-3);
        check_near(height_near(f, zoom, 88, lon), 500, 1e-3);
    }
    assert_true(isnan(height_near(f, zoom, 84, 0)));
    planet_file_close(&f);
}

static void test_patterns(void **state)
{
    (void)state;
    raster_spec west = patch("cell-a.tif", 10, 50, slope),
                east = patch("cell-b.tif", 12, 50, slope);
    write_raster(&west);
    write_raster(&east);
    assert_int_equal(import_heights("g.planet", "cell-?.tif"), OK);
    check_slope("g.planet", 10, 50, 0.02);
    // At the border of two files that do not overlap, the half sample on each side is the nearest
    // sample: 0.01 degrees at 10 m a degree of longitude.
    check_slope("g.planet", 11, 50, 0.1);
    check_slope("g.planet", 12, 50, 0.02);
    assert_int_equal(import_heights("g2.planet", "nothing-*.tif"), ERR_NOT_FOUND);
    assert_non_null(strstr(logged, "matches no file"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_vertical),
        cmocka_unit_test(test_geoid_grid),
        cmocka_unit_test(test_vertical_faults),
        cmocka_unit_test(test_axes),
        cmocka_unit_test(test_units),
        cmocka_unit_test(test_mask),
        cmocka_unit_test(test_moon),
        cmocka_unit_test(test_patterns),
    };
    return cmocka_run_group_tests(tests, make_test_dir, remove_test_dir);
}
