// Heights between samples: what bilinear and bicubic ones must reproduce, that bicubic ones have no
// creases, and that what bounds them does, over borders of tiles, widths and the antimeridian.
#include "check.h"

#include "ground.h"
#include "oracle.h"
#include "reference/reference.h"

#define RAD (M_PI / 180)

static const geo_ellipsoid sphere = {.a = 1e6, .b = 1e6};

// Places on borders: of two tiles at the equator; where rows of different widths meet (of zoom 3
// the first tile row has samples twice as far apart in longitude as the second); the antimeridian.
static const struct {
    const char *name;
    int zoom;
    double lat, lon;
} places[] = {{"equator", 2, 0, 0}, {"width", 3, 67.5, 22.5}, {"antimeridian", 2, -20, 180}};
enum { PLACES = 3 };

static int place;
static bool curved; // the surface is quadratic, else it is a plane of the map

// Degrees from the place.
static double surface(double x, double y, double *per_lat, double *per_lon)
{
    double bend = curved;
    *per_lon = 2 + bend * (-1.4 * x + 0.4 * y);
    *per_lat = 5 + bend * (0.4 * x + 1.8 * y);
    return 3 + 2 * x + 5 * y + bend * (-0.7 * x * x + 0.4 * x * y + 0.9 * y * y);
}

// The surface within 12 degrees of the place, 0 beyond.
static float surface_sample(int zoom, int64_t row, int64_t col)
{
    double lat, lon, slopes[2];
    ground_place(zoom, row, col, &lat, &lon);
    double x = remainder(lon / RAD - places[place].lon, 360), y = lat / RAD - places[place].lat;
    return fabs(x) > 12 || fabs(y) > 12 ? 0 : (float)surface(x, y, &slopes[0], &slopes[1]);
}

// Largest errors over random points within 10 degrees of the place.
static void measure_surface(bool bicubic, double *height, double *gradient)
{
    struct ground g;
    struct check_random r = {17};
    *height = *gradient = 0;
    ground_open(&g, sphere, places[place].zoom, surface_sample);
    g.bicubic = bicubic;
    ground_look_from(&g, (double[]){1e9, 0, 1e8}, places[place].zoom);
    for (int i = 0; i < 20000; i++) {
        double x = check_random_range(&r, -10, 10), y = check_random_range(&r, -10, 10);
        double lat = places[place].lat + y, lon = places[place].lon + x, want[2], got[2];
        double h = surface(x, y, &want[0], &want[1]);
        *height = fmax(*height, fabs(field_height(&g.reader, lat, lon) - h));
        field_gradient(&g.reader, lat, lon, &got[0], &got[1]);
        for (int k = 0; k < 2; k++) *gradient = fmax(*gradient, fabs(got[k] - want[k]));
    }
    ground_close(&g);
}

// The plane's samples are exact. The quadratic's, up to 256 m, are floats: each is off by up to
// 7.7e-6 m, which weights whose magnitudes add up to 25/16 make 1.2e-5 m; a slope has 3/2 of the
// difference of two, over the distance of samples, times 5/4.
static void test_surfaces_are_exact(void **state)
{
    (void)state;
    assert_int_equal(grid_coalesce(3, 0), 2 * grid_coalesce(3, 1));
    for (place = 0; place < PLACES; place++) {
        double height, gradient, step = 180.0 / (TILE_SIZE << places[place].zoom);
        for (int bicubic = 0; bicubic < 2; bicubic++) {
            curved = bicubic;
            measure_surface(bicubic, &height, &gradient);
            print_message("%s: %s: height %.2e m, slope %.2e m a degree\n", places[place].name,
                          curved ? "quadratic, bicubic" : "plane, bilinear", height, gradient);
            assert_true(height <= (curved ? 1.2e-5 : 1e-12));
            assert_true(gradient <= (curved ? 2.9e-5 / step : 1e-12));
        }
        curved = true;
        measure_surface(false, &height, &gradient); // what would pass if there were no difference
        assert_true(height > 1e-3);
    }
}

static float noise(int zoom, int64_t row, int64_t col)
{
    struct check_random r = {(uint64_t)(row * 7919 + col * 104729 + zoom + 1)};
    check_random_u64(&r);
    check_random_u64(&r);
    return (float)check_random_range(&r, -1000, 1000);
}

// On both sides of lines through samples slopes are the same, unless bilinear. Bends of up to
// 10^4 m over (0.09 degrees)^2 change slopes by less than 0.03 m a degree in 2e-8 degrees.
static void check_creases(bool bicubic, int lines)
{
    struct ground g;
    struct check_random r = {23};
    double worst = 0, least = INFINITY;
    ground_open(&g, sphere, 3, noise);
    g.bicubic = bicubic;
    ground_look_from(&g, (double[]){1e9, 0, 1e8}, 3);
    for (int i = 0; i < lines; i++) {
        int64_t row = (int64_t)check_random_range(&r, 256, 2018);
        if (i % 3 == 0) row = row / 256 * 256 - i % 2; // beside the border of two tiles
        double lat, lon, a[2], b[2];
        int64_t col = i % 5 ? (int64_t)check_random_range(&r, 0, 512) : 0;
        ground_place(3, row, col, &lat, &lon);
        double y = lat / RAD, x = lon / RAD, off = check_random_range(&r, -1, 1), e = 1e-8;
        bool along = i % 2;
        if (along) x += off;
        else y += 0.08 * off;
        field_gradient(&g.reader, along ? y - e : y, along ? x : x - e, &a[0], &a[1]);
        field_gradient(&g.reader, along ? y + e : y, along ? x : x + e, &b[0], &b[1]);
        double jump = fmax(fabs(a[0] - b[0]), fabs(a[1] - b[1]));
        worst = fmax(worst, jump);
        least = fmin(least, jump);
    }
    print_message("%s: slopes jump by %.2e to %.2e m a degree\n", bicubic ? "bicubic" : "bilinear",
                  least, worst);
    if (bicubic) assert_true(worst < 0.03);
    else assert_true(worst > 1e3);
    ground_close(&g);
}

static void test_no_creases(void **state)
{
    (void)state;
    check_creases(true, 3000);
    check_creases(false, 3000);
}

// Boxes from a thousandth of a cell to many tiles, also over the antimeridian and beyond poles.
static field_box random_box(struct check_random *r)
{
    double high = pow(10, check_random_range(r, -4, 1.8)),
           wide = pow(10, check_random_range(r, -4, 2.3));
    double lat = check_random_range(r, -90, 90), lon = check_random_range(r, -540, 540);
    return (field_box){fmax(-90, lat - high), fmin(90, lat + high), lon - wide, lon + wide};
}

// Is the place in sight of an eye far away?
static bool before(dvec3 eye, double lat, double lon)
{
    dvec3 n = {cos(lat * RAD) * cos(lon * RAD), cos(lat * RAD) * sin(lon * RAD), sin(lat * RAD)};
    return dvec3_dot(n, eye) > 0.1 * dvec3_length(eye);
}

static void check_boxes(const char *name, bool bicubic, int zoom, ground_sample *sample)
{
    static const dvec3 eyes[] = {{1e9, 0, 0}, {-1e9, 1e7, 0}, {0, 1e8, 1e9}, {1e7, 0, -1e9}};
    struct ground g;
    struct check_random r = {29};
    oracle o = {sphere.a, sphere.b, zoom, sample, 0, 0, bicubic, false};
    double low, high, closest = INFINITY;
    int tried = 0;
    ground_open(&g, sphere, zoom, sample);
    g.bicubic = bicubic;
    for (int i = 0; i < 4000; i++) {
        dvec3 eye = eyes[i / 1000];
        if (i % 1000 == 0) ground_look_from(&g, (double[]){eye.x, eye.y, eye.z}, zoom);
        field_range(g.field, &low, &high);
        field_box box = random_box(&r);
        double bound = field_max(g.field, &box);
        assert_true(bound <= high);
        for (int j = 0; j < 40; j++) {
            double lat = check_random_range(&r, box.south, box.north),
                   lon = check_random_range(&r, box.west, box.east);
            if (!before(eye, lat, lon)) continue;
            double h = (double)oracle_height(&o, lat * RAD, lon * RAD);
            assert_true(h >= low && h <= high);
            closest = fmin(closest, bound - h);
            tried++;
            if (h > bound)
                fail_msg("%s: %g m at %g %g, more than %g m, the bound of a box %g by %g", name, h,
                         lat, lon, bound, box.north - box.south, box.east - box.west);
        }
    }
    print_message("%s: %d places, within [%.1f, %.1f] m, as near as %.3f m to a box's bound\n",
                  name, tried, low, high, closest);
    assert_true(tried > 20000);
    ground_close(&g);
}

// The most that a bicubic surface can stand out (patch.h).
static float crests(int zoom, int64_t row, int64_t col)
{
    (void)zoom;
    bool inner = (row % 4 == 1 || row % 4 == 2) == (col % 4 == 1 || col % 4 == 2);
    return inner ? 1000 : -1000;
}

// Beside a lone deep sample a bicubic surface rises, also where none of the two by two samples
// about a place says so; here those are in the next block of 4 by 4.
static float pits(int zoom, int64_t row, int64_t col)
{
    (void)zoom;
    return (row % 16 == 7 || row % 16 == 12) && (col % 16 == 7 || col % 16 == 12) ? -1000 : 0;
}

static void test_boxes_are_bounded(void **state)
{
    (void)state;
    check_boxes("noise, bilinear", false, 3, noise);
    check_boxes("noise, bicubic", true, 3, noise);
    check_boxes("crests, bicubic", true, 2, crests);
    check_boxes("pits, bicubic", true, 2, pits);
}

// Parts of single patches: near the highest corner where they are small.
static void test_parts_are_bounded(void **state)
{
    (void)state;
    struct ground g;
    struct check_random r = {31};
    double worst = 0;
    ground_open(&g, sphere, 2, noise);
    g.bicubic = true;
    ground_look_from(&g, (double[]){1e9, 0, 1e8}, 2);
    for (int i = 0; i < 20000; i++) {
        double lat = check_random_range(&r, -80, 80), lon = check_random_range(&r, -180, 180);
        field_patch p = field_patch_at(&g.reader, lat, lon);
        patch_bounds b = patch_bound(&p);
        double size = pow(10, check_random_range(&r, -3, 0)), e[2], most = -INFINITY;
        field_box part = {lat, lat + size * (p.box.north - lat), lon,
                          lon + size * (p.box.east - lon)};
        double bound = patch_max(&p, &b, &part);
        for (int j = 0; j < 16; j++) {
            double y = check_random_range(&r, part.south, part.north),
                   x = check_random_range(&r, part.west, part.east);
            most = fmax(most, patch_height(&p, y, x));
            patch_gradient(&p, y, x, &e[0], &e[1]);
            assert_true(fabs(e[0]) <= b.lat && fabs(e[1]) <= b.lon);
        }
        assert_true(most <= bound);
        if (size < 0.01) worst = fmax(worst, bound - most);
    }
    print_message("parts below a hundredth: bounds at most %.2f m above what was met\n", worst);
    assert_true(worst < 10);
    ground_close(&g);
}

enum { SIDE = 24 };

// Frames say the heights that were asked for, at the places they say.
static void test_frames(void **state)
{
    (void)state;
    static float height[SIDE * SIDE];
    static double lat[SIDE * SIDE], lon[SIDE * SIDE];
    struct ground g;
    ground_open(&g, sphere, 2, noise);
    for (int bicubic = 0; bicubic < 2; bicubic++) {
        oracle o = {sphere.a, sphere.b, 2, noise, 0, 0, bicubic, false};
        reference_params p = {.pyramid = g.planet.pyramid,
                              .camera = {30, 50, 1e5, 20, -60, 0, 50},
                              .width = SIDE,
                              .height = SIDE,
                              .zoom = SIGHT_STORED,
                              .bicubic = bicubic};
        reference_planes planes = {.height_m = height, .lat_deg = lat, .lon_deg = lon};
        assert_int_equal(reference_render(&p, &planes), OK);
        for (int i = 0; i < SIDE * SIDE; i++)
            check_near(height[i], (double)oracle_height(&o, lat[i] * RAD, lon[i] * RAD), 1e-3);
    }
    ground_close(&g);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_surfaces_are_exact),
        cmocka_unit_test(test_no_creases),
        cmocka_unit_test(test_boxes_are_bounded),
        cmocka_unit_test(test_parts_are_bounded),
        cmocka_unit_test(test_frames),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
