// The analytic planet, imported through the real path, against its formula: every zoom, poles,
// antimeridian, and turned.
#include "test_import_common.h"

#include "analytic_planet.h"
#include "planet/filter.h"

enum { ZOOM = 3, SAMPLES = TILE_SIZE * TILE_SIZE };

// Bound of the field's slope, metres / rad: the sum of amplitude times wave number.
#define SLOPE_MAX 26500.0

struct worst {
    double pole, elsewhere; // the two rows of samples around the poles; all others
};

static struct worst worst_of_zoom(struct planet_file *f, int zoom, const dmat3 *rotation)
{
    static float heights[SAMPLES];
    struct worst worst = {0};
    for (int row = 0; row < grid_rows(zoom); row++)
        for (int col = 0; col < grid_cols(zoom, row); col++) {
            tile_id id = {LAYER_HEIGHT, zoom, row, col};
            assert_int_equal(planet_file_read_height(f, id, heights), OK);
            for (int i = 0; i < SAMPLES; i++) {
                double lat, lon;
                sample_place(id, i, &lat, &lon);
                double error =
                    fabs((double)heights[i] - analytic_height_rotated(rotation, lat, lon));
                bool pole = fabs(lat) > M_PI / 2 - grid_step_lat(zoom);
                double *most = pole ? &worst.pole : &worst.elsewhere;
                if (!(error <= *most)) *most = error;
            }
        }
    return worst;
}

// What averaging does to a field of this curvature: half the kernel's variance times the Laplacian,
// of every filtering on the way from the finest zoom, on top of the first sampling's (a kernel of
// at most 0.6 rows).
static double bound_of_zoom(int zoom)
{
    double variance = pow(0.6 * grid_step_lat(ZOOM), 2);
    for (int z = ZOOM - 1; z >= zoom; z--) variance += pow(FILTER_SIGMA * grid_step_lat(z), 2);
    return 0.5 * variance * ANALYTIC_CURVATURE_MAX * 1.1 + 0.01;
}

static void check_all(const char *name, const dmat3 *rotation)
{
    struct planet_file *f = open_planet(name);
    assert_int_equal(planet_file_meta(f)->max_zoom[LAYER_HEIGHT], ZOOM);
    for (int zoom = ZOOM; zoom >= 0; zoom--) {
        struct worst most = worst_of_zoom(f, zoom, rotation);
        double bound = bound_of_zoom(zoom);
        print_message("%s zoom %d: worst error %.3f m, at the poles %.3f m, bound %.3f m\n", name,
                      zoom, most.elsewhere, most.pole, bound);
        check_near(most.elsewhere, 0, bound);
        // Around a pole the children are few rings: their centroid is off by up to 1 % of a row.
        check_near(most.pole, 0, bound + 0.01 * SLOPE_MAX * grid_step_lat(zoom));
    }
    planet_file_close(&f);
}

static void test_every_sample(void **state)
{
    (void)state;
    assert_int_equal(analytic_planet_make(in_dir("plain.planet"), ZOOM), OK);
    check_all("plain.planet", NULL);
    // The pole of the field is brought to 30 N 100 E, and the other way round.
    dmat3 turn = geo_ecef_from_enu(30 * RAD, 100 * RAD);
    assert_int_equal(analytic_planet_make_rotated(in_dir("turned.planet"), ZOOM, &turn,
                                                  (geo_ellipsoid){.a = 6371000, .b = 6371000}),
                     OK);
    check_all("turned.planet", &turn);
    struct planet_file *f = open_planet("turned.planet");
    check_near(planet_file_meta(f)->ellipsoid.b, 6371000, 0);
    planet_file_close(&f);
}

// The curvature that the header promises, by differences along random great circles.
static void test_curvature(void **state)
{
    (void)state;
    struct check_random r = {11};
    double most = 0, highest = 0;
    for (int i = 0; i < 20000; i++) {
        double lat = asin(check_random_range(&r, -1, 1)), lon = check_random_range(&r, -M_PI, M_PI);
        double step = 1e-3, h = analytic_height(lat, lon);
        double second = (analytic_height(fmin(lat + step, M_PI / 2), lon) +
                         analytic_height(lat - step, lon) - 2 * h) /
                        (step * step);
        if (lat + step < M_PI / 2) most = fmax(most, fabs(second));
        highest = fmax(highest, fabs(h));
    }
    print_message("highest |height| %.0f m, curvature %.0f m / rad^2\n", highest, most);
    assert_true(highest <= ANALYTIC_HEIGHT_MAX && most <= ANALYTIC_CURVATURE_MAX);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_curvature),
                                       cmocka_unit_test(test_every_sample)};
    return cmocka_run_group_tests(tests, make_test_dir, remove_test_dir);
}
