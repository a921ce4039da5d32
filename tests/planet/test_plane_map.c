// Rasters in a projected reference system as a plane: sample by sample, to scale, at their
// geographic place; rasters of other systems over them; and what cannot be laid flat.
//
// Fails when broken: the origin half a sample off, no unit conversion (samples); the map cut to
// reach as far to both sides (odd); the map's axes exchanged, feet for metres (places); a layer not
// warped (layers); gaps taken for final (metres: corners); the border's samples not carried on
// (metres); a world not turned before it is closed (352 m, the world over a pole); gaps of imagery
// filled, imagery not laid on the map, or that without a system taken for metres (colour).
#include "check.h"

#include <cpl_conv.h>
#include <dirent.h>
#include <gdal.h>
#include <gdalwarper.h>
#include <ogr_srs_api.h>
#include <unistd.h>

#include "base/log.h"
#include "planet/source_set.h"
#include "planet_fixture.h"
#include "utm_raster.h"

// Of an even number of samples the map's origin is its middle, of an odd one half a sample off.
static int width = 300, height = 202;

static float height_of(int row, int col)
{
    return (float)(500 + 3 * row - 2 * col + 40 * sin(0.3 * row) * cos(0.2 * col));
}

// `system`: EPSG code, or WKT. West and north edge and the step in its units.
static void write_raster(const char *path, const char *system, double west, double north,
                         double step)
{
    double g[6] = {west, step, 0, north, 0, -step};
    float *samples = calloc((size_t)(width * height), sizeof *samples);
    GDALAllRegister();
    GDALDatasetH d =
        GDALCreate(GDALGetDriverByName("GTiff"), path, width, height, 1, GDT_Float32, NULL);
    assert_non_null(samples);
    assert_non_null(d);
    for (int i = 0; i < width * height; i++) samples[i] = height_of(i / width, i % width);
    GDALSetGeoTransform(d, g);
    if (system) {
        OGRSpatialReferenceH srs = OSRNewSpatialReference(NULL);
        assert_int_equal(OSRSetFromUserInput(srs, system), OGRERR_NONE);
        GDALSetSpatialRef(d, srs);
        OSRDestroySpatialReference(srs);
    }
    assert_int_equal(GDALRasterIO(GDALGetRasterBand(d, 1), GF_Write, 0, 0, width, height, samples,
                                  width, height, GDT_Float32, 0, 0),
                     CE_None);
    GDALClose(d);
    free(samples);
}

struct laid {
    struct source_set *set;
    struct pyramid *pyramid;
};

static struct laid lay(const char *path, const char *over)
{
    const source_set_params flat = {.flat = true};
    const pyramid_params plain = {.synthesis = SYNTHESIS_NONE};
    struct laid l = {source_set_create(&flat), NULL};
    assert_int_equal(source_set_add(l.set, path, LAYER_COUNT, 1), OK);
    if (over) assert_int_equal(source_set_add(l.set, over, LAYER_COUNT, 1), OK);
    assert_int_equal(source_set_pyramid(l.set, &plain, &l.pyramid), OK);
    return l;
}

static void put_away(struct laid *l)
{
    pyramid_destroy(&l->pyramid);
    source_set_destroy(&l->set);
}

// Height at metres from the map's origin.
static double height_at(const struct laid *l, double east, double north)
{
    const struct planet_meta *m = pyramid_meta(l->pyramid);
    double h;
    assert_int_equal(pyramid_height_at(l->pyramid, m->max_zoom[LAYER_HEIGHT],
                                       north / m->ellipsoid.a, east / m->ellipsoid.a, &h),
                     OK);
    return h;
}

// Every sample but those of the border lies in the store as it is in the file.
static void check_samples(const struct laid *l, double step_m)
{
    const struct planet_meta *m = pyramid_meta(l->pyramid);
    geo_ellipsoid e = m->ellipsoid;
    assert_true(geo_is_plane(e) && e.north < 0.11 && e.east < 0.11);
    check_near((e.east - e.west) * e.a, (width - 1) * step_m, 1e-6 * step_m);
    check_near((e.north - e.south) * e.a, (height - 1) * step_m, 1e-6 * step_m);
    check_near(e.west * e.a, (0.5 - width / 2) * step_m, 1e-6 * step_m);
    check_near(e.north * e.a, (height / 2 - 0.5) * step_m, 1e-6 * step_m);
    check_near(grid_step_lat(m->max_zoom[LAYER_HEIGHT]) * e.a, step_m, 1e-9 * step_m);
    for (int row = 1; row < height - 1; row += 7)
        for (int col = 1; col < width - 1; col += 5)
            check_near(
                height_at(l, (col + 0.5 - width / 2) * step_m, (height / 2 - row - 0.5) * step_m),
                height_of(row, col), 2e-3);
}

// Seen coarsely the ground goes on to the map's very corners, without a step to nothing.
static void check_corners(const struct laid *l)
{
    const struct planet_meta *m = pyramid_meta(l->pyramid);
    geo_ellipsoid e = m->ellipsoid;
    for (int i = 0; i < 4; i++) {
        double h;
        bool north = i / 2, east = i % 2;
        assert_int_equal(pyramid_height_at(l->pyramid, m->max_zoom[LAYER_HEIGHT] - 1,
                                           north ? e.north : e.south, east ? e.east : e.west, &h),
                         OK);
        check_near(h, height_of(north ? 0 : height - 1, east ? width - 1 : 0), 60);
    }
}

// Beyond its edges the last sample goes on, so that triangles over an edge lie where the ground is.
static void check_beyond(const struct laid *l, double step_m)
{
    for (int i = 20; i < height - 20; i += 40)
        for (int past = 1; past <= 3; past++) {
            double left = -width / 2 * step_m, top = height / 2 * step_m, at = (i + 0.5) * step_m,
                   first = (0.5 - past) * step_m, last_x = (width - 0.5 + past) * step_m,
                   last_y = (height - 0.5 + past) * step_m;
            check_near(height_at(l, left + last_x, top - at), height_of(i, width - 1), 2e-3);
            check_near(height_at(l, left + first, top - at), height_of(i, 0), 2e-3);
            check_near(height_at(l, left + at, top - first), height_of(0, i), 2e-3);
            check_near(height_at(l, left + at, top - last_y), height_of(height - 1, i), 2e-3);
        }
}

// On the central meridian of a zone of UTM: easting 500 km; northing 4,982,950.400 m at 45 degrees.
static void test_metres(void **state)
{
    (void)state;
    write_raster("utm.tif", "EPSG:32632", 500000 - 30 * 100, 4982950.4 + 30 * 40, 30);
    struct laid l = lay("utm.tif", NULL);
    check_samples(&l, 30);
    check_corners(&l);
    check_beyond(&l, 30);
    double radius = pyramid_meta(l.pyramid)->ellipsoid.a, lat[2] = {45, 45.01}, lon[2] = {9, 9};
    struct plane_map *map = source_set_map(l.set);
    plane_map_from_geographic(map, 2, lat, lon);
    double metres = radius * M_PI / 180;
    check_near(lon[0] * metres, 30 * (100 - width / 2), 2e-3);
    check_near(lat[0] * metres, 30 * (height / 2 - 40), 2e-3);
    check_near(lon[1] * metres, lon[0] * metres, 2e-3);
    check_near((lat[1] - lat[0]) * metres, 0.9996 * 1111.31,
               0.1); // a degree is 111,131 m long at 45
    plane_map_to_geographic(map, 2, lat, lon);
    check_near(lat[0], 45, 1e-9);
    check_near(lon[0], 9, 1e-9);
    check_near(lat[1], 45.01, 1e-9);
    put_away(&l);
}

// No row and no column is lost.
static void test_odd(void **state)
{
    (void)state;
    for (int i = 1; i < 4; i++) {
        width = 300 + i % 2;
        height = 202 + i / 2;
        write_raster("odd.tif", "EPSG:32632", 500000, 4982950.4, 30);
        struct laid l = lay("odd.tif", NULL);
        check_samples(&l, 30);
        check_corners(&l);
        check_beyond(&l, 30);
        put_away(&l);
    }
    width = 300;
    height = 202;
}

// California zone 3 in US survey feet.
static void test_feet(void **state)
{
    (void)state;
    write_raster("feet.tif", "EPSG:2227", 6000000, 2100000, 10);
    struct laid l = lay("feet.tif", NULL);
    check_samples(&l, 10 * 1200.0 / 3937);
    put_away(&l);
}

// The same ground by longitude and latitude and by another zone's metres, over the map.
static void test_layers(void **state)
{
    (void)state;
    write_raster("utm.tif", "EPSG:32632", 500000, 5000000, 30);
    struct laid alone = lay("utm.tif", NULL);
    // Into the neighbour zone and back: by GDAL's warper, bilinear twice.
    GDALDatasetH d = GDALOpen("utm.tif", GA_ReadOnly);
    OGRSpatialReferenceH other = OSRNewSpatialReference(NULL);
    char *wkt = NULL;
    OSRImportFromEPSG(other, 32633);
    OSRExportToWkt(other, &wkt);
    GDALDatasetH warped = GDALAutoCreateWarpedVRT(d, NULL, wkt, GRA_Bilinear, 0, NULL);
    GDALDatasetH copy =
        GDALCreateCopy(GDALGetDriverByName("GTiff"), "zone33.tif", warped, FALSE, NULL, NULL, NULL);
    GDALClose(copy);
    GDALClose(warped);
    GDALClose(d);
    OSRDestroySpatialReference(other);
    CPLFree(wkt);
    struct laid over = lay("utm.tif", "zone33.tif");
    double worst = 0;
    for (int i = -5; i <= 5; i++)
        for (int k = -3; k <= 3; k++)
            worst = fmax(worst, fabs(height_at(&over, 500.0 * i, 500.0 * k) -
                                     height_at(&alone, 500.0 * i, 500.0 * k)));
    print_message("a layer from another zone: %.2f m off, where a sample is %.0f m from the next\n",
                  worst, 40 * 0.3);
    assert_true(worst > 0 && worst < 4);
    put_away(&alone);
    put_away(&over);
}

// From the south pole on the map of EPSG:3031, m (Snyder 1987, 21-33 to 21-40; scale 1 at 71 S).
static double polar_distance(double lat_deg)
{
    double e = 0.0818191908426215, at[2] = {lat_deg, -71}, t[2];
    for (int i = 0; i < 2; i++) {
        double f = -at[i] * M_PI / 180, s = e * sin(f);
        t[i] = tan(M_PI / 4 - f / 2) / pow((1 - s) / (1 + s), e / 2);
    }
    double f = 71 * M_PI / 180, m = cos(f) / sqrt(1 - pow(e * sin(f), 2));
    return 6378137 * m * t[0] / t[1];
}

// All the world by longitude and latitude, from the antimeridian or from Greenwich on, over the map
// of a pole, which knows no place for the other one: what GDAL makes of all of it has one sample of
// 1e20 m.
static void test_the_world_over_a_pole(void **state)
{
    (void)state;
    write_raster("pole.tif", "EPSG:3031", -3000000, 2020000, 20000);
    for (int west = -180; west <= 0; west += 180) {
        width = 360, height = 180;
        write_raster("world.tif", "EPSG:4326", west, 90, 1);
        width = 300, height = 202;
        struct laid l = lay("pole.tif", "world.tif");
        double worst = 0, seam = 0;
        for (int row = 160; row < 174; row += 3) {
            double r = polar_distance(89.5 - row),
                   middle = 0.5 * ((double)height_of(row, 0) + (double)height_of(row, 359));
            for (int col = 15; col < 345; col += 15) {
                double lon = (west + col + 0.5) * M_PI / 180;
                worst = fmax(worst, fabs(height_at(&l, r * sin(lon), r * cos(lon)) -
                                         (double)height_of(row, col)));
            }
            seam = fmax(seam, fabs(height_at(&l, 0, west ? -r : r) - middle));
        }
        print_message("the world from %d over a pole: %.2f m off, %.2f where it closes\n", west,
                      worst, seam);
        assert_true(worst < 6);
        assert_true(seam < 30); // of a step of 718 m
        put_away(&l);
    }
}

// Colours that tell longitude and latitude, opaque, in a part of the world or around it.
static unsigned char colour_of(int channel, double lat_deg, double lon_deg)
{
    double turn = lon_deg * M_PI / 180;
    double value = channel == 0   ? 128 + 100 * sin(turn)
                   : channel == 1 ? 128 + 100 * cos(turn)
                                  : 128 + lat_deg;
    return (unsigned char)lrint(value);
}

// Stretches degrees so that a small raster has all colours.
static double stretch = 1;

static void write_colours(const char *path, const char *system, double west, double north,
                          double step, int columns, int rows)
{
    unsigned char *rgb = malloc((size_t)(columns * rows) * 3);
    assert_non_null(rgb);
    for (int i = 0; i < columns * rows; i++)
        for (int c = 0; c < 3; c++)
            rgb[3 * i + c] = colour_of(c, stretch * (north - (i / columns + 0.5) * step),
                                       stretch * (west + (i % columns + 0.5) * step));
    GDALDatasetH d =
        GDALCreate(GDALGetDriverByName("GTiff"), path, columns, rows, 3, GDT_Byte, NULL);
    OGRSpatialReferenceH srs = OSRNewSpatialReference(NULL);
    assert_non_null(d);
    if (system && OSRSetFromUserInput(srs, system) == OGRERR_NONE) GDALSetSpatialRef(d, srs);
    OSRDestroySpatialReference(srs);
    GDALSetGeoTransform(d, (double[6]){west, step, 0, north, 0, -step});
    assert_int_equal(GDALDatasetRasterIO(d, GF_Write, 0, 0, columns, rows, rgb, columns, rows,
                                         GDT_Byte, 3, NULL, 3, 3 * columns, 1),
                     CE_None);
    GDALClose(d);
    free(rgb);
}

// The sample of colour at metres from the map's origin, and the place of its centre.
static void read_colour(const struct laid *l, double *east, double *north, unsigned char rgb[3])
{
    const struct planet_meta *m = pyramid_meta(l->pyramid);
    const pyramid_tile *tile;
    int zoom = m->max_zoom[LAYER_COLOR];
    double step = grid_step_lat(zoom), a = m->ellipsoid.a;
    int64_t row = (int64_t)floor((M_PI / 2 - *north / a) / step),
            col = (int64_t)floor((M_PI + *east / a) / step);
    tile_id id = {LAYER_COLOR, zoom, (int)(row / TILE_SIZE), (int)(col / TILE_SIZE)};
    assert_int_equal(pyramid_acquire(l->pyramid, id, &tile), OK);
    memcpy(rgb, tile->rgba + 4 * (row % TILE_SIZE * TILE_SIZE + col % TILE_SIZE), 3);
    pyramid_release(l->pyramid, &tile);
    *north = (M_PI / 2 - ((double)row + 0.5) * step) * a;
    *east = (((double)col + 0.5) * step - M_PI) * a;
}

// Greatest difference from the colours of the place, by the system's own transformation.
static double colours_off(const struct laid *l, int epsg, double x, double y, const double at[][2],
                          int count)
{
    OGRSpatialReferenceH from = OSRNewSpatialReference(NULL), to = OSRNewSpatialReference(NULL);
    OSRImportFromEPSG(from, epsg);
    OSRSetWellKnownGeogCS(to, "WGS84");
    OSRSetAxisMappingStrategy(from, OAMS_TRADITIONAL_GIS_ORDER);
    OSRSetAxisMappingStrategy(to, OAMS_TRADITIONAL_GIS_ORDER);
    OGRCoordinateTransformationH way = OCTNewCoordinateTransformation(from, to);
    double worst = 0;
    for (int i = 0; i < count; i++) {
        unsigned char rgb[3];
        double east = at[i][0], north = at[i][1];
        read_colour(l, &east, &north, rgb);
        double lon = x + east, lat = y + north;
        assert_true(OCTTransform(way, 1, &lon, &lat, NULL));
        for (int c = 0; c < 3; c++)
            worst = fmax(worst, fabs((double)rgb[c] - colour_of(c, stretch * lat, stretch * lon)));
    }
    OCTDestroyCoordinateTransformation(way);
    OSRDestroySpatialReference(from);
    OSRDestroySpatialReference(to);
    return worst;
}

// Imagery by longitude and latitude over heights in metres: each colour at its place, nothing
// beside it, and the heights as they are without it.
static void test_colour_over_heights(void **state)
{
    (void)state;
    static const double inside[][2] = {
        {-3000, 1500}, {-1000, -2000}, {0, 0}, {1700, 2200}, {3100, -900}};
    write_raster("utm.tif", "EPSG:32632", 500000 - 4500, 4982950.4 + 3030, 30);
    stretch = 1000;
    write_colours("imagery.tif", "EPSG:4326", 9 - 0.05, 45 + 0.021, 0.0005, 200, 84);
    struct laid l = lay("utm.tif", "imagery.tif");
    double off = colours_off(&l, 32632, 500000, 4982950.4, inside, 5);
    print_message("colours over UTM: %.0f of 255 off\n", off);
    assert_true(off <= 6);
    unsigned char rgb[3];
    read_colour(&l, &(double){0}, &(double){2900}, rgb);
    static const unsigned char bare[3] = {156, 150, 140};
    assert_memory_equal(rgb, bare, 3);
    check_samples(&l, 30);
    put_away(&l);
}

static void test_colour_over_a_pole(void **state)
{
    (void)state;
    double at[24][2];
    write_raster("pole.tif", "EPSG:3031", -3000000, 2020000, 20000);
    stretch = 1;
    for (int i = 0; i < 24; i++) { // Greenwich and the antimeridian among them
        double r = polar_distance(-75 - i % 3 * 4), lon = i * M_PI / 12;
        at[i][0] = r * sin(lon);
        at[i][1] = r * cos(lon);
    }
    for (int west = -180; west <= 0; west += 180) {
        // Without a word about its system, degrees are taken for what they are.
        write_colours("imagery.tif", west ? "EPSG:4326" : NULL, west, 90, 1, 360, 180);
        struct laid l = lay("pole.tif", "imagery.tif");
        double off = colours_off(&l, 3031, 0, 0, at, 24);
        print_message("colours over a pole: %.0f of 255 off\n", off);
        assert_true(off <= 4);
        put_away(&l);
    }
}

static void check_refused(const char *path, const char *what)
{
    const source_set_params flat = {.flat = true};
    struct source_set *set = source_set_create(&flat);
    assert_int_not_equal(source_set_add(set, path, LAYER_COUNT, 1), OK);
    if (!strstr(log_last_error(), what)) fail_msg("\"%s\", not \"%s\"", log_last_error(), what);
    assert_non_null(strstr(log_last_error(), path));
    source_set_destroy(&set);
}

static void test_what_cannot_be(void **state)
{
    (void)state;
    write_raster("local.tif", "LOCAL_CS[\"site\",UNIT[\"metre\",1]]", 0, 0, 1);
    check_refused("local.tif", "in a local reference system");
    write_raster("none.tif", NULL, 500000, 5000000, 30);
    check_refused("none.tif", "no georeference");
    static const int few[][2] = {{1, 1}, {1, 7}, {5, 1}};
    for (int i = 0; i < 3; i++) {
        assert_int_equal(utm_raster_write("few.tif", few[i][0], few[i][1]), OK);
        check_refused("few.tif", "not a map: it has less than 2 x 2 samples");
    }
    // GeoTIFF has no reference system without a unit.
    GDALDatasetH d = GDALOpen("none.tif", GA_ReadOnly);
    GDALDatasetH unitless =
        GDALCreateCopy(GDALGetDriverByName("VRT"), "unitless.vrt", d, FALSE, NULL, NULL, NULL);
    GDALSetProjection(unitless,
                      "PROJCS[\"no unit\",GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS 84\","
                      "6378137,298.257223563]],PRIMEM[\"Greenwich\",0],UNIT[\"degree\","
                      "0.0174532925199433]],PROJECTION[\"Transverse_Mercator\"],"
                      "PARAMETER[\"central_meridian\",9],PARAMETER[\"scale_factor\",0.9996],"
                      "UNIT[\"unknown\",1]]");
    GDALClose(unitless);
    GDALClose(d);
    check_refused("unitless.vrt", "its reference system has no unit of length");
}

static void test_only_rasters_lie_over(void **state)
{
    (void)state;
    const source_set_params flat = {.flat = true};
    struct source_set *set = source_set_create(&flat);
    fixture f;
    fixture_init(&f, "flat");
    fixture_write(&f, 1, 0, fixture_smooth_height, NULL);
    write_raster("utm.tif", "EPSG:32632", 500000, 5000000, 30);
    assert_int_equal(source_set_add(set, "utm.tif", LAYER_COUNT, 1), OK);
    assert_int_equal(source_set_add(set, f.path, LAYER_COUNT, 1), ERR_ARGUMENT);
    assert_non_null(strstr(log_last_error(), "only rasters can"));
    source_set_destroy(&set);
    fixture_deinit(&f);
}

// Of longitude and latitude: the whole map.
static void test_degrees(void **state)
{
    (void)state;
    write_raster("degrees.tif", "EPSG:4326", 8, 47, 0.001);
    struct laid l = lay("degrees.tif", NULL);
    geo_ellipsoid e = pyramid_meta(l.pyramid)->ellipsoid;
    assert_null(source_set_map(l.set));
    check_near(e.a, 6378137, 1e-6);
    check_near(e.north, M_PI / 2, 0);
    check_near(e.south, -M_PI / 2, 0);
    check_near(e.east, M_PI, 0);
    check_near(e.west, -M_PI, 0);
    put_away(&l);
}

static char folder[] = P_tmpdir "/perigee-plane-XXXXXX";

static int enter_folder(void **state)
{
    (void)state;
    return mkdtemp(folder) && !chdir(folder) ? 0 : -1;
}

static int remove_folder(void **state)
{
    (void)state;
    DIR *d = opendir(".");
    for (struct dirent *e; d && (e = readdir(d));) unlinkat(dirfd(d), e->d_name, 0);
    if (d) closedir(d);
    return chdir("/") || rmdir(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_metres),
        cmocka_unit_test(test_odd),
        cmocka_unit_test(test_feet),
        cmocka_unit_test(test_layers),
        cmocka_unit_test(test_the_world_over_a_pole),
        cmocka_unit_test(test_colour_over_heights),
        cmocka_unit_test(test_colour_over_a_pole),
        cmocka_unit_test(test_degrees),
        cmocka_unit_test(test_what_cannot_be),
        cmocka_unit_test(test_only_rasters_lie_over),
    };
    return cmocka_run_group_tests(tests, enter_folder, remove_folder);
}
