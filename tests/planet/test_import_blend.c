// Sources that overlap: which one shows, and how their seams are blended. The oracle of a seam is
// the smoothstep of the distance to the data's edge, worked out here from longitudes and latitudes;
// of a border, between the inset and what the coarser zoom, of the globe, shows.
#include "test_import_common.h"

#include <float.h>

enum { FEATHER = 10 };

static double at_0(int band, double x, double y)
{
    (void)band;
    (void)x;
    (void)y;
    return 0;
}

static double at_900(int band, double x, double y)
{
    return at_0(band, x, y) + 900;
}

static double at_500(int band, double x, double y)
{
    return at_0(band, x, y) + 500;
}

static double with_hole(int band, double x, double y)
{
    return x > 12 && x < 13 && y > 46 && y < 48 ? NAN : at_900(band, x, y);
}

static const raster_spec globe = {.name = "globe.tif",
                                  .width = 720,
                                  .height = 360,
                                  .bands = 1,
                                  .type = GDT_Float32,
                                  .crs = "EPSG:4326",
                                  .transform = {-180, 0.5, 0, 90, 0, -0.5},
                                  .value = at_0};

// 5 degrees a side.
static raster_spec inset(const char *name, double west, double north,
                         double (*value)(int, double, double))
{
    return (raster_spec){.name = name,
                         .width = 100,
                         .height = 100,
                         .bands = 1,
                         .type = GDT_Float32,
                         .crs = "EPSG:4326",
                         .transform = {west, 0.05, 0, north, 0, -0.05},
                         .value = value};
}

struct piece {
    const char *name;
    int priority;
};

static struct planet_file *import_seams(int count, const struct piece *pieces, int feather,
                                        double feather_m, enum tile_layer layer)
{
    import_source sources[10];
    char paths[10][512], out[512];
    logged[0] = 0;
    for (int i = 0; i < count; i++) {
        snprintf(paths[i], sizeof paths[i], "%s", in_dir(pieces[i].name));
        sources[i] =
            (import_source){.layer = layer, .path = paths[i], .priority = pieces[i].priority};
    }
    snprintf(out, sizeof out, "%s", in_dir("o.planet"));
    import_params p = {.sources = sources,
                       .source_count = count,
                       .output = out,
                       .feather_rows = feather,
                       .feather_m = feather_m,
                       .threads = 2,
                       .force = true};
    if (import_run(&p)) fail_msg("%s", logged);
    return open_planet("o.planet");
}

static struct planet_file *import_pieces(int count, const struct piece *pieces, int feather,
                                         enum tile_layer layer)
{
    return import_seams(count, pieces, feather, 0, layer);
}

static double smooth(double t)
{
    t = fmin(1, fmax(0, t));
    return t * t * (3 - 2 * t);
}

// The sphere of the grid, and the distance on it to a meridian and to a parallel.
#define GROUND_M 6378137.0

static double to_meridian_m(double lat_deg, double lon_deg)
{
    return GROUND_M * asin(cos(lat_deg * RAD) * sin(lon_deg * RAD));
}

static double globe_sample_m(void)
{
    return 0.5 * RAD * GROUND_M;
}

static double spline(const double v[4], double t)
{
    double bend = 2 * v[0] - 5 * v[1] + 4 * v[2] - v[3] + t * (3 * (v[1] - v[2]) + v[3] - v[0]);
    return v[1] + 0.5 * t * (v[2] - v[0] + t * bend);
}

// What the samples of a zoom show at a place (degrees): Catmull and Rom's spline through sixteen.
static double shown_at(struct planet_file *f, int zoom, double lat, double lon)
{
    double step = grid_step_lat(zoom) / RAD, x = (lon + 180) / step - 0.5;
    double y = (90 - lat) / step - 0.5, t = x - floor(x), rows[4];
    for (int i = 0; i < 4; i++) {
        double row[4];
        for (int k = 0; k < 4; k++)
            row[k] = height_near(f, zoom, 90 - (floor(y) - 1 + i + 0.5) * step,
                                 (floor(x) - 1 + k + 0.5) * step - 180);
        rows[i] = spline(row, t);
    }
    return spline(rows, y - floor(y));
}

// The globe's zoom; 900 m above it, by the weight of a seam.
enum { GLOBE_ZOOM = 1 };

static double over_shown(struct planet_file *f, double lat, double lon, double weight)
{
    return 900 * weight + (1 - weight) * shown_at(f, GLOBE_ZOOM, lat, lon);
}

// Along a parallel and a meridian through the inset 10..15 E, 45..50 N of 900 m over what the
// coarser zoom shows there.
static void test_ramp(void **state)
{
    (void)state;
    raster_spec fine = inset("fine.tif", 10, 50, at_900);
    write_raster(&globe);
    write_raster(&fine);
    struct planet_file *f = import_pieces(2, (struct piece[]){{"fine.tif", 0}, {"globe.tif", 0}},
                                          FEATHER, LAYER_HEIGHT);
    int zoom = planet_file_meta(f)->max_zoom[LAYER_HEIGHT];
    double step = grid_step_lat(zoom) / RAD, most = 0;
    for (double d = step; d < 2.5; d += step / 3)
        for (int way = 0; way < 2; way++) {
            double lat = way ? 50 - d : 47.5, lon = way ? 12.5 : 10 + d, at, on;
            int index;
            tile_id id = tile_at(LAYER_HEIGHT, zoom, lat * RAD, lon * RAD, &index);
            sample_place(id, index, &at, &on);
            double rows = way ? (50 - at / RAD) / step : (on / RAD - 10) * cos(at) / step;
            // The edge of the samples is within half a sample of the data's.
            double slack = 900 * 1.5 * 0.6 / FEATHER;
            double got = height_near(f, zoom, lat, lon);
            double want = over_shown(f, at / RAD, on / RAD, smooth(rows / FEATHER));
            most = fmax(most, fabs(got - want));
            check_near(got, want, slack);
        }
    print_message("greatest difference from the smoothstep %.2f of 900 m\n", most);
    check_near(height_near(f, zoom, 47.5, 10 + step), over_shown(f, 47.5, 10 + step, 0), 90);
    check_near(height_near(f, zoom, 47.5, 12.5), 900, 1e-3);
    assert_true(isnan(height_near(f, zoom, 47.5, 9.9)));
    planet_file_close(&f);
}

static double step_between(double most, float a, float b)
{
    return isnan(a) || isnan(b) ? most : fmax(most, fabs((double)a - (double)b));
}

static double with_wide_hole(int band, double x, double y)
{
    return x > 29.2 && x < 30.8 && y > 47 && y < 51 ? NAN : at_900(band, x, y);
}

// In rows of a zoom: from a place to the hole above.
static double rows_to_hole(int zoom, double lat, double lon)
{
    double east = fmax(0, fmax(29.2 - lon, lon - 30.8)) * cos(lat * RAD);
    return hypot(east, fmax(0, fmax(47 - lat, lat - 51))) * RAD / grid_step_lat(zoom);
}

// About a hole over a coarser raster, which ends farther than the feather from it and from the
// border, and across tiles: by the widest feather the data's own over what the coarser zoom shows.
static void test_hole(void **state)
{
    (void)state;
    raster_spec wide = inset("wide.tif", 20, 60, with_wide_hole);
    wide.width = wide.height = 400; // 20 degrees: several tiles
    raster_spec patch = inset("patch.tif", 24.6, 54, at_0);
    patch.width = 43;
    patch.height = 40;
    patch.transform[1] = 0.25;
    patch.transform[5] = -0.25;
    write_raster(&wide);
    write_raster(&patch);
    const int rows = 60, patch_zoom = 2;
    struct planet_file *f =
        import_pieces(2, (struct piece[]){{"patch.tif", 0}, {"wide.tif", 0}}, rows, LAYER_HEIGHT);
    int zoom = planet_file_meta(f)->max_zoom[LAYER_HEIGHT], looked = 0;
    // Away from a corner of the hole, from the middle of a side, and south over the tiles' border.
    static const double ways[][4] = {
        {51, 30.8, 0.7, 1}, {49, 30.8, 0, 1}, {49, 29.2, 0, -1}, {47, 30, -1, 0.05}};
    double most = 0;
    for (int k = 0; k < 4; k++)
        for (double far = 0; far < 3; far += 0.07) {
            int index;
            double lat, lon;
            tile_id id = tile_at(LAYER_HEIGHT, zoom, (ways[k][0] + far * ways[k][2]) * RAD,
                                 (ways[k][1] + far * ways[k][3]) * RAD, &index);
            sample_place(id, index, &lat, &lon);
            double got = height_near(f, zoom, lat / RAD, lon / RAD);
            if (isnan(got)) continue;
            double own = smooth((rows_to_hole(zoom, lat / RAD, lon / RAD) - 0.5) / (rows - 0.5));
            double want = 900 * own + (1 - own) * shown_at(f, patch_zoom, lat / RAD, lon / RAD);
            most = fmax(most, fabs(got - want));
            looked++;
        }
    print_message("greatest difference from the smoothstep %.2f of 900 m\n", most);
    check_near(most, 0, 900 * 1.5 / rows); // a sample of the edge's place
    assert_true(looked > 120);
    planet_file_close(&f);
}

// Cells that stand side by side are one: no dip between them. A hole inside is an edge.
static void test_mosaic(void **state)
{
    (void)state;
    raster_spec west = inset("west.tif", 10, 50, with_hole),
                east = inset("east.tif", 15, 50, at_900);
    write_raster(&west);
    write_raster(&east);
    write_raster(&globe);
    struct planet_file *f =
        import_pieces(3, (struct piece[]){{"globe.tif", 0}, {"west.tif", 0}, {"east.tif", 0}},
                      FEATHER, LAYER_HEIGHT);
    int zoom = planet_file_meta(f)->max_zoom[LAYER_HEIGHT];
    for (double lon = 14; lon < 16; lon += 0.01)
        check_near(height_near(f, zoom, 47.5, lon), 900, 1e-3);
    check_near(height_near(f, zoom, 47.5, 11.97), over_shown(f, 47.5, 11.97, 0), 90);
    check_near(height_near(f, zoom, 47.5, 13.03), over_shown(f, 47.5, 13.03, 0), 90);
    assert_true(isnan(height_near(f, zoom, 47.5, 12.5)));
    check_near(height_near(f, zoom, 45.8, 12.5),
               over_shown(f, 45.8, 12.5, smooth((46 - 45.8) / 0.44)), 90);
    planet_file_close(&f);
}

// Two of one zoom: the later lies on top and is blended into the earlier over the feather.
static void test_overlap(void **state)
{
    (void)state;
    raster_spec left = inset("left.tif", 10, 50, at_900),
                right = inset("right.tif", 13, 50, at_500);
    write_raster(&left);
    write_raster(&right);
    struct planet_file *f = import_pieces(2, (struct piece[]){{"left.tif", 0}, {"right.tif", 0}},
                                          FEATHER, LAYER_HEIGHT);
    int zoom = planet_file_meta(f)->max_zoom[LAYER_HEIGHT];
    check_near(height_near(f, zoom, 47.5, 11), 900, 1e-3);
    check_near(height_near(f, zoom, 47.5, 13.07), 900, 40);
    check_near(height_near(f, zoom, 47.5, 14.9), 500, 1e-3);
    double before = 900;
    for (double lon = 13.05; lon < 14.5; lon += 0.02) {
        double here = height_near(f, zoom, 47.5, lon);
        assert_true(here <= before + 1e-3 && here >= 499.9);
        before = here;
    }
    planet_file_close(&f);
    f = import_pieces(2, (struct piece[]){{"left.tif", 1}, {"right.tif", 0}}, 0, LAYER_HEIGHT);
    check_near(height_near(f, zoom, 47.5, 14.9), 900, 1e-3); // a higher priority lies on top
    planet_file_close(&f);
}

// The finest wins whatever the order; a higher priority wins whatever the zoom.
static void test_priority(void **state)
{
    (void)state;
    raster_spec fine = inset("fine.tif", 10, 50, at_900);
    write_raster(&globe);
    write_raster(&fine);
    for (int order = 0; order < 2; order++) {
        const struct piece pieces[] = {{order ? "fine.tif" : "globe.tif", 0},
                                       {order ? "globe.tif" : "fine.tif", 0}};
        struct planet_file *f = import_pieces(2, pieces, 0, LAYER_HEIGHT);
        int zoom = planet_file_meta(f)->max_zoom[LAYER_HEIGHT];
        for (int z = 2; z <= zoom; z++) check_near(height_near(f, z, 47.5, 12.5), 900, 1e-3);
        planet_file_close(&f);
    }
    for (int order = 0; order < 2; order++) {
        const struct piece pieces[] = {{order ? "fine.tif" : "globe.tif", !order},
                                       {order ? "globe.tif" : "fine.tif", order}};
        struct planet_file *f = import_pieces(2, pieces, 0, LAYER_HEIGHT);
        for (int z = 0; z <= 1; z++) check_near(height_near(f, z, 47.5, 12.5), 0, 1e-3);
        assert_true(isnan(height_near(f, 4, 47.5, 12.5)));
        planet_file_close(&f);
    }
}

static double black(int band, double x, double y)
{
    return at_0(band, x, y) + 20;
}

static double white(int band, double x, double y)
{
    return at_0(band, x, y) + 220;
}

static double light_of(double code)
{
    double v = code / 255;
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

// Colours are mixed as light: half of 20 and 220 is 163, not 120.
static void test_colour(void **state)
{
    (void)state;
    raster_spec base = globe, top = inset("top.tif", 10, 50, white);
    base.name = "base.tif";
    base.type = top.type = GDT_Byte;
    base.value = black;
    write_raster(&base);
    write_raster(&top);
    const int rows = 30;
    struct planet_file *f =
        import_pieces(2, (struct piece[]){{"base.tif", 0}, {"top.tif", 0}}, rows, LAYER_COLOR);
    int zoom = planet_file_meta(f)->max_zoom[LAYER_COLOR];
    double step = grid_step_lat(zoom) / RAD;
    static unsigned char pixels[TILE_SIZE * TILE_SIZE * 3];
    for (double d = step; d < 2.4; d += step) {
        int index;
        double lat, lon;
        tile_id id = tile_at(LAYER_COLOR, zoom, (50 - d) * RAD, 12.5 * RAD, &index);
        sample_place(id, index, &lat, &lon);
        assert_int_equal(planet_file_read_pixels(f, id, pixels), OK);
        double t = smooth((50 - lat / RAD) / step / rows);
        double want = light_of(20) + t * (light_of(220) - light_of(20));
        check_near(light_of(pixels[3 * index]), want, 0.05);
    }
    planet_file_close(&f);
}

// Every tile's range holds all heights of the tile and of the tiles below it.
static void test_ranges(void **state)
{
    (void)state;
    raster_spec fine = inset("fine.tif", 10, 50, at_900);
    write_raster(&globe);
    write_raster(&fine);
    struct planet_file *f = import_pieces(2, (struct piece[]){{"globe.tif", 0}, {"fine.tif", 0}},
                                          FEATHER, LAYER_HEIGHT);
    static float heights[TILE_SIZE * TILE_SIZE];
    int top = planet_file_meta(f)->max_zoom[LAYER_HEIGHT], looked = 0;
    for (int zoom = top; zoom >= 0; zoom--)
        for (int row = 0; row < grid_rows(zoom); row++)
            for (int col = 0; col < grid_cols(zoom, row); col++) {
                tile_id id = {LAYER_HEIGHT, zoom, row, col};
                if (planet_file_read_height(f, id, heights)) continue;
                float low = FLT_MAX, high = -FLT_MAX;
                for (int i = 0; i < TILE_SIZE * TILE_SIZE; i++) {
                    low = fminf(low, heights[i]);
                    high = fmaxf(high, heights[i]);
                }
                for (tile_id up = id;; up = tile_parent(up)) {
                    float min, max;
                    assert_int_equal(planet_file_read_range(f, up, &min, &max), OK);
                    assert_true(min <= low && max >= high);
                    looked++;
                    if (up.zoom == 0) break;
                }
            }
    assert_true(looked > 20);
    // The mean of zoom 0 is far below the inset's 900 m; its range is not. Its seam ends in a
    // spline through coarser samples, which may be an eighth of a step too high.
    float min, max;
    assert_int_equal(planet_file_read_range(f, (tile_id){LAYER_HEIGHT, 0, 0, 1}, &min, &max), OK);
    assert_true(max > 900 - 1e-3 && max < 900 * 1.125);
    planet_file_close(&f);
}

// The greatest height between neighbouring samples of the zoom, over what lies between them.
static double greatest_slope(struct planet_file *f, int zoom)
{
    enum { N = TILE_SIZE };
    static float h[N * N];
    double most = 0;
    for (int row = 0; row < grid_rows(zoom); row++)
        for (int col = 0; col < grid_cols(zoom, row); col++) {
            if (planet_file_read_height(f, (tile_id){LAYER_HEIGHT, zoom, row, col}, h)) continue;
            for (int i = 0; i < N * N; i++) {
                double lat = grid_lat(zoom, (int64_t)row * N + i / N);
                double wide = grid_step_lon(zoom, row) * cos(lat) * GROUND_M;
                if (i % N < N - 1) most = fmax(most, step_between(0, h[i], h[i + 1]) / wide);
                if (i / N < N - 1)
                    most = fmax(most,
                                step_between(0, h[i], h[i + N]) / (grid_step_lat(zoom) * GROUND_M));
            }
        }
    return most;
}

// By itself a seam is as wide as a sample of what lies below, whatever the inset's own; a hole in
// it is no border. The oracle is the smoothstep of the distance on the sphere.
static void test_border(void **state)
{
    (void)state;
    raster_spec fine = inset("fine.tif", 10, 50, with_hole);
    write_raster(&globe);
    write_raster(&fine);
    struct planet_file *f = import_seams(2, (struct piece[]){{"fine.tif", 0}, {"globe.tif", 0}},
                                         FEATHER_ROWS, FEATHER_AUTO, LAYER_HEIGHT);
    int zoom = planet_file_meta(f)->max_zoom[LAYER_HEIGHT], looked = 0;
    double width = globe_sample_m(), step = grid_step_lat(zoom) / RAD;
    for (double d = 9 * step; d < 2.4; d += step / 3)
        for (int way = 0; way < 2; way++) {
            int index;
            double lat, lon;
            tile_id id = tile_at(LAYER_HEIGHT, zoom, (way ? 50 - d : 45.3) * RAD,
                                 (way ? 14.5 : 15 - d) * RAD, &index);
            sample_place(id, index, &lat, &lon);
            double inside = fmin(to_meridian_m(lat / RAD, 15 - lon / RAD),
                                 GROUND_M * fmin(50 * RAD - lat, lat - 45 * RAD));
            double got = height_near(f, zoom, lat / RAD, lon / RAD);
            check_near(got, over_shown(f, lat / RAD, lon / RAD, smooth(inside / width)), 5);
            looked++;
        }
    assert_true(looked > 100);
    check_near(height_near(f, zoom, 47, 12 - 13 * step), 900, 1e-3); // beside the hole
    check_near(height_near(f, zoom, 47, 11.97), over_shown(f, 47, 11.97, 0), 90);
    planet_file_close(&f);
    f = import_seams(2, (struct piece[]){{"fine.tif", 0}, {"globe.tif", 0}}, FEATHER_ROWS, 80000,
                     LAYER_HEIGHT);
    check_near(height_near(f, zoom, 45.8, 10.9),
               over_shown(f, 45.8, 10.9, smooth(to_meridian_m(45.8, 0.9) / 80000)), 40);
    planet_file_close(&f);
}

// No seam is steeper than the step over its width allows: over the pole, where the inset's edges
// are neither parallels nor meridians, and across the antimeridian.
static void test_border_slope(void **state)
{
    (void)state;
    raster_spec polar = inset("polar.tif", -1e6, 0.8e6, at_900);
    polar.crs = "EPSG:3413";
    polar.width = polar.height = 300;
    polar.transform[1] = 6000;
    polar.transform[5] = -6000;
    raster_spec date = inset("date.tif", 176, -20, at_900);
    write_raster(&globe);
    write_raster(&polar);
    write_raster(&date);
    struct planet_file *f =
        import_seams(3, (struct piece[]){{"globe.tif", 0}, {"polar.tif", 0}, {"date.tif", 0}},
                     FEATHER_ROWS, FEATHER_AUTO, LAYER_HEIGHT);
    int zoom = planet_file_meta(f)->max_zoom[LAYER_HEIGHT];
    double bound = 900 * 1.5 / globe_sample_m() * 1.1, most = 0;
    for (int z = zoom - 1; z <= zoom; z++) most = fmax(most, greatest_slope(f, z));
    print_message("greatest slope %.4f, bound %.4f\n", most, bound);
    check_near(most, 0, bound);
    assert_true(most > bound / 2);
    check_near(height_near(f, zoom - 1, 89.5, 20), 900, 1e-3);
    check_near(height_near(f, zoom, -22.5, 178.5), 900, 1e-3);
    check_near(height_near(f, zoom, -22.5, -179.9), 900, 1e-3);
    planet_file_close(&f);
}

// A small inset's middle is its own: from half of its radius on nothing else shows. Side by side
// such insets are one, with wider seams and none between them.
static void test_border_of_small(void **state)
{
    (void)state;
    char names[9][8];
    struct piece pieces[10] = {{"globe.tif", 0}};
    write_raster(&globe);
    for (int i = 0; i < 9; i++) {
        snprintf(names[i], sizeof names[i], "%d.tif", i);
        raster_spec cell = inset(names[i], 10 + i % 3 * 0.2, 0.3 - i / 3 * 0.2, at_900);
        cell.width = cell.height = 200;
        cell.transform[1] = 0.001;
        cell.transform[5] = -0.001;
        write_raster(&cell);
        pieces[i + 1] = (struct piece){names[i], 0};
    }
    const double half = 0.1 * RAD * GROUND_M; // of a cell; a sample of the globe is 56 km
    for (int count = 2; count <= 10; count += 8) {
        struct planet_file *f =
            import_seams(count, pieces, FEATHER_ROWS, FEATHER_AUTO, LAYER_HEIGHT);
        int zoom = planet_file_meta(f)->max_zoom[LAYER_HEIGHT];
        double width = count == 2 ? half / 2 : 1.5 * half;
        for (double d = 0.012; d < 0.1; d += 0.004) {
            int index;
            double lat, lon;
            tile_id id = tile_at(LAYER_HEIGHT, zoom, 0.2 * RAD, (10 + d) * RAD, &index);
            sample_place(id, index, &lat, &lon);
            double inside = to_meridian_m(lat / RAD, lon / RAD - 10);
            check_near(height_near(f, zoom, 0.2, 10 + d),
                       over_shown(f, lat / RAD, lon / RAD, smooth(inside / width)), 5);
        }
        if (count == 2) check_near(height_near(f, zoom, 0.2, 10.1), 900, 1e-3);
        for (double lon = 10.16; lon < 10.44 && count == 10; lon += 0.005)
            check_near(height_near(f, zoom, 0, lon), 900, 1e-3);
        planet_file_close(&f);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_ramp),         cmocka_unit_test(test_hole),
        cmocka_unit_test(test_mosaic),       cmocka_unit_test(test_overlap),
        cmocka_unit_test(test_priority),     cmocka_unit_test(test_colour),
        cmocka_unit_test(test_ranges),       cmocka_unit_test(test_border),
        cmocka_unit_test(test_border_slope), cmocka_unit_test(test_border_of_small),
    };
    return cmocka_run_group_tests(tests, make_test_dir, remove_test_dir);
}
