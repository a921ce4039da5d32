// The tile grid by brute force: every tile of the coarse zooms, the rows of the fine ones.
#include "check.h"

#include "base/vec.h"
#include "planet/grid.h"

// Every tile to this zoom (2.2 million of them); beyond, whole rows.
enum { ALL_ZOOMS = 10 };

static void widths_are_powers_of_two(void **state)
{
    (void)state;
    for (int zoom = 0; zoom <= GRID_MAX_ZOOM; zoom++) {
        int rows = grid_rows(zoom), step = rows > 4096 ? rows / 4096 : 1;
        assert_int_equal(rows, 1 << zoom);
        for (int row = 0; row < rows; row += step) {
            int c = grid_coalesce(zoom, row);
            assert_true(c >= 1 && (c & (c - 1)) == 0);
            assert_int_equal(c * (int64_t)grid_cols(zoom, row), 2 * (int64_t)rows);
            assert_int_equal(c, grid_coalesce(zoom, rows - 1 - row));
        }
    }
}

// Within a row, samples are never narrower on the ground than half their height, where the row is
// nearest to the equator, and never wider than their height there.
static void samples_are_near_square(void **state)
{
    (void)state;
    for (int zoom = 1; zoom <= GRID_MAX_ZOOM; zoom++)
        for (int k = 0; k < 2000; k++) {
            int rows = grid_rows(zoom), row = (int)((int64_t)rows * k / 2000);
            double w, s, e, n;
            grid_bounds((tile_id){LAYER_HEIGHT, zoom, row, 0}, &w, &s, &e, &n);
            double nearest = fmin(fabs(s), fabs(n));
            double shape = grid_step_lon(zoom, row) * cos(nearest) / grid_step_lat(zoom);
            assert_true(shape > 0.5 && shape <= 1.0);
        }
}

// No gap and no overlap: rows and columns share their bounds bit by bit, from pole to pole and
// around.
static void tiles_cover_the_sphere(void **state)
{
    (void)state;
    for (int zoom = 0; zoom <= ALL_ZOOMS; zoom++) {
        double w, s, e, n, last_south = M_PI / 2;
        for (int row = 0; row < grid_rows(zoom); row++) {
            double last_east = -M_PI;
            for (int col = 0; col < grid_cols(zoom, row); col++) {
                grid_bounds((tile_id){LAYER_HEIGHT, zoom, row, col}, &w, &s, &e, &n);
                assert_true(w == last_east && e > w && n == last_south && s < n);
                last_east = e;
            }
            assert_true(last_east == M_PI);
            last_south = s;
        }
        assert_true(last_south == -M_PI / 2);
    }
}

static void parents_contain_children(void **state)
{
    (void)state;
    for (int zoom = 1; zoom <= ALL_ZOOMS; zoom++)
        for (int row = 0; row < grid_rows(zoom); row++)
            for (int col = 0; col < grid_cols(zoom, row); col++) {
                tile_id id = {LAYER_COLOR, zoom, row, col}, up = tile_parent(id);
                double w, s, e, n, pw, ps, pe, pn;
                grid_bounds(id, &w, &s, &e, &n);
                grid_bounds(up, &pw, &ps, &pe, &pn);
                assert_int_equal(up.layer, LAYER_COLOR);
                assert_int_equal(up.zoom, zoom - 1);
                assert_true(up.col < grid_cols(up.zoom, up.row));
                assert_true(pw <= w && e <= pe && ps <= s && n <= pn);
                // One child is half as wide as its parent, or as wide.
                double share = (pe - pw) / (e - w);
                assert_true(fabs(share - 1.0) < 1e-9 || fabs(share - 2.0) < 1e-9);
            }
}

// Neighbouring rows differ in width by at most a factor of two: patches rely on it.
static void neighbouring_rows_differ_by_two_at_most(void **state)
{
    (void)state;
    for (int zoom = 1; zoom <= 16; zoom++)
        for (int row = 1; row < grid_rows(zoom); row++) {
            int a = grid_coalesce(zoom, row - 1), b = grid_coalesce(zoom, row);
            assert_true(a == b || a == 2 * b || b == 2 * a);
        }
    for (int zoom = 3; zoom <= GRID_MAX_ZOOM; zoom++) assert_int_equal(grid_cols(zoom, 0), 8);
}

static void sample_latitudes_are_cell_centres(void **state)
{
    (void)state;
    for (int zoom = 0; zoom <= GRID_MAX_ZOOM; zoom++)
        for (int k = 0; k < 100; k++) {
            int rows = grid_rows(zoom), row = (int)((int64_t)(rows - 1) * k / 99);
            double w, s, e, n;
            grid_bounds((tile_id){LAYER_HEIGHT, zoom, row, 0}, &w, &s, &e, &n);
            // Measured 2.2e-16 against the interpolated bounds.
            check_near(grid_lat(zoom, (int64_t)row * TILE_SIZE), n + (s - n) * 0.5 / TILE_SIZE,
                       1e-15);
            check_near(grid_lat(zoom, (int64_t)row * TILE_SIZE + 255),
                       n + (s - n) * 255.5 / TILE_SIZE, 1e-15);
        }
}

static void layers_have_names(void **state)
{
    (void)state;
    assert_string_equal(tile_layer_name(LAYER_HEIGHT), "height");
    assert_string_equal(tile_layer_name(LAYER_COLOR), "color");
    assert_string_equal(tile_layer_name(LAYER_NIGHT), "night");
    assert_true(tile_id_equal((tile_id){1, 2, 3, 4}, (tile_id){1, 2, 3, 4}));
    assert_false(tile_id_equal((tile_id){1, 2, 3, 4}, (tile_id){0, 2, 3, 4}));
    assert_false(tile_id_equal((tile_id){1, 2, 3, 4}, (tile_id){1, 2, 3, 5}));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(widths_are_powers_of_two),
        cmocka_unit_test(samples_are_near_square),
        cmocka_unit_test(tiles_cover_the_sphere),
        cmocka_unit_test(parents_contain_children),
        cmocka_unit_test(neighbouring_rows_differ_by_two_at_most),
        cmocka_unit_test(sample_latitudes_are_cell_centres),
        cmocka_unit_test(layers_have_names),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
