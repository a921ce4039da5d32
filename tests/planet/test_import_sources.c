// Every kind of raster: placed, read and marked as it says, against the function it was written
// from.
#include "test_import_common.h"

#include "planet/import_light.h"

// Heights that tell place: metres, smooth in degrees.
static double by_degrees(int band, double lon, double lat)
{
    (void)band;
    return 1000 + 700 * sin(lon * RAD * 2) * cos(lat * RAD) + 10 * lat;
}

// Largest difference to by_degrees over points inside a box, at least `inset` degrees from its
// edges.
static double worst(struct planet_file *f, int zoom, double west, double south, double east,
                    double north)
{
    struct check_random r = {5};
    double most = 0;
    for (int i = 0; i < 300; i++) {
        double lon = check_random_range(&r, west, east), lat = check_random_range(&r, south, north);
        int index;
        double lon_in = geo_wrap_lon(lon * RAD), at, on;
        tile_id id = tile_at(LAYER_HEIGHT, zoom, lat * RAD, lon_in, &index);
        sample_place(id, index, &at, &on);
        double got = height_near(f, zoom, lat, lon_in / RAD);
        if (isnan(got)) return NAN;
        most = fmax(most, fabs(got - by_degrees(1, on / RAD, at / RAD)));
    }
    return most;
}

static void check_placed(const raster_spec *spec, double west, double south, double east,
                         double north, double tol)
{
    write_raster(spec);
    assert_int_equal(import_heights("a.planet", spec->name), OK);
    struct planet_file *f = open_planet("a.planet");
    int zoom = planet_file_meta(f)->max_zoom[LAYER_HEIGHT];
    double most = worst(f, zoom, west, south, east, north);
    print_message("%s: zoom %d, worst error %.3f m\n", spec->name, zoom, most);
    check_near(most, 0, tol);
    planet_file_close(&f);
}

static void test_geographic(void **state)
{
    (void)state;
    raster_spec inset = {.name = "inset.tif",
                         .width = 200,
                         .height = 100,
                         .bands = 1,
                         .type = GDT_Float32,
                         .crs = "EPSG:4326",
                         .transform = {10, 0.1, 0, 50, 0, -0.1},
                         .value = by_degrees};
    check_placed(&inset, 10.2, 40.2, 29.8, 49.8, 0.05);
    raster_spec south_up = inset;
    south_up.name = "southup.tif";
    south_up.transform[3] = 40;
    south_up.transform[5] = 0.1;
    check_placed(&south_up, 10.2, 40.2, 29.8, 49.8, 0.05);
    raster_spec scaled = inset;
    scaled.name = "scaled.tif";
    scaled.type = GDT_Int16;
    scaled.scale = 0.1;
    scaled.offset = 500;
    check_placed(&scaled, 10.2, 40.2, 29.8, 49.8, 0.11);
    raster_spec east = inset;
    east.name = "antimeridian.tif";
    east.transform[0] = 172;
    check_placed(&east, 172.2, 40.2, 191.8, 49.8, 0.05);
}

// The globe from 0 to 360: seamless at Greenwich and at the antimeridian, up to the poles.
static void test_globe_from_greenwich(void **state)
{
    (void)state;
    raster_spec globe = {.name = "globe.tif",
                         .width = 720,
                         .height = 360,
                         .bands = 1,
                         .type = GDT_Float32,
                         .crs = "EPSG:4326",
                         .transform = {0, 0.5, 0, 90, 0, -0.5},
                         .value = by_degrees};
    // The field itself has a kink at the poles.
    check_placed(&globe, -180, -88, 180, 88, 0.3);
    struct planet_file *f = open_planet("a.planet");
    int zoom = planet_file_meta(f)->max_zoom[LAYER_HEIGHT];
    for (int z = 0; z <= zoom; z++)
        for (double lat = -89; lat < 90; lat += 7)
            for (double seam = 0; seam <= 180; seam += 180) {
                double left = height_near(f, z, lat, seam - 1e-6),
                       right = height_near(f, z, lat, seam == 0 ? 1e-6 : -180);
                // Neighbours differ by a slope of at most 25 m / degree times a step.
                check_near(left, right, 26 * grid_step_lat(z) / RAD / cos(lat * RAD));
            }
    planet_file_close(&f);
}

static OGRCoordinateTransformationH to_degrees;

static double by_projected(int band, double x, double y)
{
    assert_true(OCTTransform(to_degrees, 1, &x, &y, NULL));
    return by_degrees(band, x, y);
}

static void check_projected(const raster_spec *spec, double west, double south, double east,
                            double north, double tol)
{
    OGRSpatialReferenceH from = OSRNewSpatialReference(NULL), to = OSRNewSpatialReference(NULL);
    OSRSetFromUserInput(from, spec->crs);
    OSRSetWellKnownGeogCS(to, "WGS84");
    OSRSetAxisMappingStrategy(from, OAMS_TRADITIONAL_GIS_ORDER);
    OSRSetAxisMappingStrategy(to, OAMS_TRADITIONAL_GIS_ORDER);
    to_degrees = OCTNewCoordinateTransformation(from, to);
    check_placed(spec, west, south, east, north, tol);
    OCTDestroyCoordinateTransformation(to_degrees);
    OSRDestroySpatialReference(from);
    OSRDestroySpatialReference(to);
}

static void test_projected(void **state)
{
    (void)state;
    raster_spec arctic = {.name = "arctic.tif",
                          .width = 400,
                          .height = 400,
                          .bands = 1,
                          .type = GDT_Float32,
                          .crs = "EPSG:3413",
                          .transform = {-2e6, 1e4, 0, 2e6, 0, -1e4},
                          .value = by_projected};
    check_projected(&arctic, -180, 75, 180, 89.95, 1);
    raster_spec antarctic = arctic;
    antarctic.name = "antarctic.tif";
    antarctic.crs = "EPSG:3031";
    check_projected(&antarctic, -180, -89.95, 180, -75, 1);
    raster_spec utm = arctic;
    utm.name = "utm.tif";
    utm.crs = "EPSG:32632";
    utm.width = utm.height = 200;
    memcpy(utm.transform, (double[6]){400000, 500, 0, 5300000, 0, -500}, sizeof utm.transform);
    check_projected(&utm, 7.8, 47.05, 8.9, 47.75, 0.05);
    raster_spec date_line = utm;
    date_line.name = "fiji.tif";
    date_line.crs = "EPSG:32760";
    memcpy(date_line.transform, (double[6]){700000, 1000, 0, 8100000, 0, -1000},
           sizeof utm.transform);
    date_line.width = 300;
    check_projected(&date_line, 179.2, -18.7, 181.2, -17.4, 0.05);
    raster_spec mercator = arctic;
    mercator.name = "mercator.tif";
    mercator.crs = "EPSG:3857";
    mercator.width = mercator.height = 512;
    double edge = 20037508.342789244;
    memcpy(mercator.transform, (double[6]){-edge, edge / 256, 0, edge, 0, -edge / 256},
           sizeof utm.transform);
    check_projected(&mercator, -180, -84, 180, 84, 3);
}

static double with_holes(int band, double lon, double lat)
{
    if (lon > 14 && lon < 16) return -9999;
    return by_degrees(band, lon, lat);
}

static double with_bad_floats(int band, double lon, double lat)
{
    if (lon > 14 && lon < 15) return NAN;
    if (lon >= 15 && lon < 16) return lat > 45 ? INFINITY : -INFINITY;
    return by_degrees(band, lon, lat);
}

// Finite, but the height of nothing on this planet.
static double with_absurd_floats(int band, double lon, double lat)
{
    if (lon > 14 && lon < 15) return lat > 45 ? 1e30 : 4e6;
    if (lon >= 15 && lon < 16) return lat > 45 ? -3.4e38 : -9e6;
    return by_degrees(band, lon, lat);
}

static void check_holes(const raster_spec *spec)
{
    write_raster(spec);
    assert_int_equal(import_heights("h.planet", spec->name), OK);
    struct planet_file *f = open_planet("h.planet");
    int zoom = planet_file_meta(f)->max_zoom[LAYER_HEIGHT];
    for (double lat = 41; lat < 49; lat += 0.37) {
        assert_true(isnan(height_near(f, zoom, lat, 15.03)));
        check_near(height_near(f, zoom, lat, 13.5), by_degrees(1, 13.5, lat), 5);
        check_near(height_near(f, zoom, lat, 16.5), by_degrees(1, 16.5, lat), 5);
        assert_true(isnan(height_near(f, zoom, lat, 9.8)));
    }
    const struct planet_meta *m = planet_file_meta(f);
    assert_true(m->height_min > 0 && m->height_max < 3000);
    planet_file_close(&f);
}

static void test_no_data(void **state)
{
    (void)state;
    double nodata = -9999;
    raster_spec marked = {.name = "marked.tif",
                          .width = 200,
                          .height = 100,
                          .bands = 1,
                          .type = GDT_Int16,
                          .crs = "EPSG:4326",
                          .transform = {10, 0.1, 0, 50, 0, -0.1},
                          .value = with_holes,
                          .nodata = &nodata};
    check_holes(&marked);
    raster_spec floats = marked;
    floats.name = "floats.tif";
    floats.type = GDT_Float32;
    floats.value = with_bad_floats;
    floats.nodata = NULL;
    check_holes(&floats);
    floats.name = "absurd.tif";
    floats.value = with_absurd_floats;
    check_holes(&floats);
    raster_spec all = marked;
    all.name = "empty.tif";
    double every = 7;
    all.nodata = &every;
    all.type = GDT_Byte;
    GDALDatasetH d = create_raster(&all);
    GDALSetRasterNoDataValue(GDALGetRasterBand(d, 1), 7);
    GDALFillRaster(GDALGetRasterBand(d, 1), 7, 0);
    GDALClose(d);
    assert_int_equal(import_heights("e.planet", "empty.tif"), ERR_ARGUMENT);
    assert_non_null(strstr(logged, "hold no data"));
    assert_true(access(in_dir("e.planet"), F_OK) != 0);
}

// Pixels

static void read_pixel(struct planet_file *f, enum tile_layer layer, double lat_deg, double lon_deg,
                       unsigned char *out)
{
    static unsigned char pixels[TILE_SIZE * TILE_SIZE * 3];
    int index, channels = layer == LAYER_COLOR ? 3 : 1;
    tile_id id =
        tile_at(layer, planet_file_meta(f)->max_zoom[layer], lat_deg * RAD, lon_deg * RAD, &index);
    assert_int_equal(planet_file_read_pixels(f, id, pixels), OK);
    memcpy(out, pixels + index * channels, (size_t)channels);
}

static void check_pixel(struct planet_file *f, double lat, double lon, int r, int g, int b)
{
    unsigned char p[3];
    read_pixel(f, LAYER_COLOR, lat, lon, p);
    // JPEG at quality 90 with halved chroma, flat areas.
    check_near(p[0], r, 4);
    check_near(p[1], g, 4);
    check_near(p[2], b, 4);
}

static double quarters(int band, double lon, double lat)
{
    (void)lat;
    static const double colours[2][4] = {{200, 100, 50, 255}, {20, 60, 180, 255}};
    return colours[lon > 20][band - 1];
}

static void test_colour(void **state)
{
    (void)state;
    raster_spec rgb = {.name = "rgb.tif",
                       .width = 200,
                       .height = 100,
                       .bands = 3,
                       .type = GDT_Byte,
                       .crs = "EPSG:4326",
                       .transform = {10, 0.1, 0, 50, 0, -0.1},
                       .value = quarters};
    write_raster(&rgb);
    raster_spec rgba = rgb;
    rgba.name = "rgba.tif";
    rgba.bands = 4;
    write_raster(&rgba);
    raster_spec grey = rgb;
    grey.name = "grey.tif";
    grey.bands = 1;
    grey.value = half_grey;
    write_raster(&grey);
    raster_spec palette = grey;
    palette.name = "palette.tif";
    write_palette(palette);
    static const char *const names[] = {"rgb.tif", "rgba.tif", "palette.tif"};
    for (int i = 0; i < 3; i++) {
        assert_int_equal(import_files("c.planet", 1, (enum tile_layer[]){LAYER_COLOR}, &names[i]),
                         OK);
        struct planet_file *f = open_planet("c.planet");
        assert_int_equal(planet_file_meta(f)->max_zoom[LAYER_HEIGHT], -1);
        check_pixel(f, 45, 13, 200, 100, 50);
        check_pixel(f, 45, 27, 20, 60, 180);
        check_pixel(f, 45, 5, 0, 0, 0);
        planet_file_close(&f);
    }
    const char *name = "grey.tif";
    assert_int_equal(import_files("g.planet", 2, (enum tile_layer[]){LAYER_COLOR, LAYER_NIGHT},
                                  (const char *[]){name, name}),
                     OK);
    struct planet_file *f = open_planet("g.planet");
    check_pixel(f, 45, 13, 90, 90, 90);
    check_pixel(f, 45, 27, 240, 240, 240);
    unsigned char light;
    read_pixel(f, LAYER_NIGHT, 45, 27, &light);
    check_near(light, 240, 2);
    planet_file_close(&f);
}

static void test_alpha(void **state)
{
    (void)state;
    raster_spec base = {.name = "base.tif",
                        .width = 200,
                        .height = 100,
                        .bands = 1,
                        .type = GDT_Byte,
                        .crs = "EPSG:4326",
                        .transform = {-180, 1.8, 0, 90, 0, -1.8},
                        .value = half_grey};
    write_raster(&base);
    raster_spec top = {.name = "top.tif",
                       .width = 200,
                       .height = 100,
                       .bands = 4,
                       .type = GDT_Byte,
                       .crs = "EPSG:4326",
                       .transform = {10, 0.1, 0, 50, 0, -0.1},
                       .value = quarters};
    GDALDatasetH d = create_raster(&top);
    for (int b = 1; b <= 3; b++) fill_band(d, &top, b);
    GDALSetRasterColorInterpretation(GDALGetRasterBand(d, 4), GCI_AlphaBand);
    unsigned char alpha[200];
    for (int x = 0; x < 200; x++) alpha[x] = x < 100 ? 255 : 0;
    for (int y = 0; y < 100; y++)
        assert_int_equal(GDALRasterIO(GDALGetRasterBand(d, 4), GF_Write, 0, y, 200, 1, alpha, 200,
                                      1, GDT_Byte, 0, 0),
                         CE_None);
    GDALClose(d);
    assert_int_equal(import_files("o.planet", 2, (enum tile_layer[]){LAYER_COLOR, LAYER_COLOR},
                                  (const char *[]){"base.tif", "top.tif"}),
                     OK);
    struct planet_file *f = open_planet("o.planet");
    check_pixel(f, 45, 13, 200, 100, 50);
    check_pixel(f, 44, 22, 240, 240, 240); // transparent: the base
    check_pixel(f, 45, 8, 90, 90, 90);     // beside the inset, in its tiles: the base
    planet_file_close(&f);
}

static void test_light(void **state)
{
    (void)state;
    for (int c = 0; c < 256; c++) {
        float v = (float)c;
        light_decode(&v, 1);
        assert_int_equal(light_encode(v), c);
    }
    float half[] = {188, NAN};
    light_decode(half, 2);
    check_near(half[0], 0.502886, 1e-5); // IEC 61966-2-1: ((188 / 255 + 0.055) / 1.055)^2.4
    assert_true(isnan(half[1]));
    assert_int_equal(light_encode(NAN), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_light),
        cmocka_unit_test(test_geographic),
        cmocka_unit_test(test_globe_from_greenwich),
        cmocka_unit_test(test_projected),
        cmocka_unit_test(test_no_data),
        cmocka_unit_test(test_colour),
        cmocka_unit_test(test_alpha),
    };
    return cmocka_run_group_tests(tests, make_test_dir, remove_test_dir);
}
