// Tiles of servers against the planet's grid: which are needed, and the resampling against the
// field they were sampled from, whose place is known in closed form.
#include "planet/tile_matrix.h"

#include "base/vec.h"
#include "check.h"

static const tile_matrix MERCATOR = {MATRIX_MERCATOR, 256, 0, 12};
static const tile_matrix MERCATOR_512 = {MATRIX_MERCATOR, 512, 0, 11};
static const tile_matrix GEOGRAPHIC = {MATRIX_GEOGRAPHIC, 256, 0, 12};

// Metres, of wavelength 16 samples of zoom 3 in both directions.
static double field(double lat, double lon)
{
    return 1000 * sin(128 * lat) + 500 * cos(128 * lon) + 3000 * lat;
}

// Latitude of a continuous row of Web Mercator, 0 to 1 from the north: Snyder 1987, eq. 7-4.
static double mercator_lat(double y)
{
    return M_PI / 2 - 2 * atan(exp(-(1 - 2 * y) * M_PI));
}

static double sample(const tile_matrix *m, int level, int64_t row, int64_t col)
{
    double rows = ldexp(m->tile_size, level);
    double y = ((double)row + 0.5) / rows;
    bool mercator = m->projection == MATRIX_MERCATOR;
    double lat = mercator ? mercator_lat(y) : M_PI / 2 - M_PI * y;
    double lon = ((double)col + 0.5) / (mercator ? rows : 2 * rows) * 2 * M_PI - M_PI;
    return field(lat, lon);
}

static float *make_raster(const tile_matrix *m, const tile_span *s)
{
    int64_t width = (int64_t)(s->x1 - s->x0) * m->tile_size;
    int64_t height = (int64_t)(s->y1 - s->y0) * m->tile_size;
    float *raster = malloc((size_t)(width * height) * sizeof *raster);
    for (int64_t y = 0; y < height; y++)
        for (int64_t x = 0; x < width; x++)
            raster[y * width + x] = (float)sample(m, s->level, (int64_t)s->y0 * m->tile_size + y,
                                                  (int64_t)s->x0 * m->tile_size + x);
    return raster;
}

// Largest difference of a resampled tile from the field at its sample centres.
static double worst(const tile_matrix *m, tile_id id)
{
    static float out[TILE_SIZE * TILE_SIZE];
    tile_span span;
    assert_true(matrix_span(m, id, &span));
    float *raster = make_raster(m, &span);
    matrix_resample_heights(m, id, &span, raster, out);
    free(raster);
    double west, south, east, north, most = 0;
    grid_bounds(id, &west, &south, &east, &north);
    for (int i = 0; i < TILE_SIZE * TILE_SIZE; i++) {
        double lat = grid_lat(id.zoom, (int64_t)TILE_SIZE * id.row + i / TILE_SIZE);
        double lon = west + (east - west) * (i % TILE_SIZE + 0.5) / TILE_SIZE;
        if (isnan(out[i])) continue;
        most = fmax(most, fabs((double)out[i] - field(lat, lon)));
    }
    return most;
}

static tile_id tile_at(int zoom, double lat_deg, double lon_deg)
{
    int row = (int)((90 - lat_deg) / 180 * grid_rows(zoom));
    return (tile_id){LAYER_HEIGHT, zoom, row, (int)((lon_deg + 180) / 360 * grid_cols(zoom, row))};
}

// The mean over a sample differs from its middle by the field's curvature: 1000 (128 step)^2 / 24
// for rows of one step, up to twice the step where the server's are wider. A shift of a tenth of a
// sample would be ten times that.
static void rows_and_columns_are_where_they_were(void **state)
{
    (void)state;
    const tile_matrix *all[] = {&MERCATOR, &MERCATOR_512, &GEOGRAPHIC};
    const double lats[] = {0.1, -0.1, 30, -45, 59, 61, 70, -80, 84};
    for (int k = 0; k < 3; k++)
        for (size_t i = 0; i < sizeof lats / sizeof *lats; i++)
            for (int zoom = 5; zoom <= 8; zoom++) {
                double step = 128 * grid_step_lat(zoom), wide = 128;
                tile_id id = tile_at(zoom, lats[i], 11);
                wide *= grid_step_lon(zoom, id.row);
                double bound = 1000 * step * step * 4 / 24 + 500 * wide * wide / 24 + 0.01;
                // Near the poles longitude and latitude come from a coarser level, by linear
                // interpolation: (factor step)^2 / 8, and at the tile's edges half a sample
                // of it beyond the last: 3 / 8.
                double over = grid_coalesce(zoom, id.row) / 4.0;
                if (k == 2 && over > 1) bound += 1000 * over * over * step * step * 3 / 8;
                check_near(worst(all[k], id), 0, bound);
            }
}

static void spans(void **state)
{
    (void)state;
    tile_span s;
    // The equator: one column, level z + 1, exactly two halves at zoom 0.
    assert_true(matrix_span(&MERCATOR, (tile_id){LAYER_HEIGHT, 0, 0, 1}, &s));
    assert_true(s.level == 1 && s.x0 == 1 && s.x1 == 2 && s.y0 == 0 && s.y1 == 2);
    assert_true(matrix_span(&MERCATOR_512, (tile_id){LAYER_HEIGHT, 0, 0, 1}, &s));
    assert_true(s.level == 0 && s.x0 == 0 && s.x1 == 1 && s.y0 == 0 && s.y1 == 1);
    assert_true(matrix_span(&GEOGRAPHIC, (tile_id){LAYER_HEIGHT, 3, 4, 5}, &s));
    assert_true(s.level == 3 && s.x0 == 5 && s.x1 == 6 && s.y0 == 4 && s.y1 == 5);
    // Where the planet merges two tiles into one Mercator is one level coarser.
    tile_id north = tile_at(6, 63, 0);
    assert_int_equal(grid_coalesce(6, north.row), 2);
    assert_true(matrix_span(&MERCATOR, north, &s));
    assert_int_equal(s.level, 6);
    assert_int_equal(s.x1 - s.x0, 1);
    assert_true(matrix_span(&GEOGRAPHIC, north, &s));
    assert_int_equal(s.x1 - s.x0, 2);
    // Finer than the server: none; the cap beyond Mercator: a span without tiles.
    assert_false(matrix_span(&MERCATOR, tile_at(12, 0.1, 0.1), &s));
    assert_true(matrix_span(&MERCATOR, tile_at(9, 89.9, 10), &s));
    assert_true(s.y0 == s.y1);
    assert_int_equal(matrix_max_zoom(&MERCATOR), 11);
    assert_int_equal(matrix_max_zoom(&MERCATOR_512), 11);
    assert_int_equal(matrix_max_zoom(&GEOGRAPHIC), 12);
}

// No tile of the planet needs more than MATRIX_MAX_TILES, none lacks one of the server's rows.
static void every_tile_is_covered(void **state)
{
    (void)state;
    const tile_matrix *all[] = {&MERCATOR, &MERCATOR_512, &GEOGRAPHIC};
    for (int k = 0; k < 3; k++)
        for (int zoom = 0; zoom <= 9; zoom++)
            for (int row = 0; row < grid_rows(zoom); row++) {
                tile_id id = {LAYER_HEIGHT, zoom, row, grid_cols(zoom, row) - 1};
                tile_span s;
                double west, south, east, north, w, b, e, n;
                assert_true(matrix_span(all[k], id, &s));
                if (s.y0 == s.y1) continue;
                grid_bounds(id, &west, &south, &east, &north);
                matrix_bounds(all[k], s.level, s.x0, s.y0, &w, &b, &e, &n);
                assert_true(w <= west + 1e-9);
                assert_true(n >= fmin(north, 1.4844) - 1e-9);
                matrix_bounds(all[k], s.level, s.x1 - 1, s.y1 - 1, &w, &b, &e, &n);
                assert_true(e >= east - 1e-9);
                assert_true(b <= fmax(south, -1.4844) + 1e-9);
            }
}

// A planet tile that crosses 85.05 degrees has no data beyond, and data up to there.
static void mercator_ends(void **state)
{
    (void)state;
    static float out[TILE_SIZE * TILE_SIZE];
    tile_id id = tile_at(5, 85.1, 10);
    tile_span s;
    assert_true(matrix_span(&MERCATOR, id, &s));
    float *raster = make_raster(&MERCATOR, &s);
    matrix_resample_heights(&MERCATOR, id, &s, raster, out);
    for (int row = 0; row < TILE_SIZE; row++) {
        double lat = grid_lat(5, (int64_t)TILE_SIZE * id.row + row) * 180 / M_PI;
        if (fabs(lat - 85.0511) > 0.03) assert_int_equal(isnan(out[row * 256]), lat > 85.0511);
    }
    free(raster);
}

// Light is averaged, not codes: rows of black and white give the grey of half the light, 188.
static void colour_is_averaged_in_linear_light(void **state)
{
    (void)state;
    tile_id id = tile_at(4, 50, 10);
    id.layer = LAYER_COLOR;
    tile_span s;
    tile_matrix fine = {MATRIX_MERCATOR, 256, 6, 6}; // columns finer than the planet's
    assert_true(matrix_span(&fine, id, &s));
    size_t count = (size_t)(s.x1 - s.x0) * (size_t)(s.y1 - s.y0) * 65536;
    uint8_t *raster = malloc(count * 4), out[TILE_SIZE * TILE_SIZE * 4];
    for (size_t i = 0; i < count; i++)
        memset(raster + 4 * i, i % 2 ? 255 : 0, 3), raster[4 * i + 3] = 255;
    matrix_resample_pixels(&fine, id, &s, raster, out);
    for (int i = 0; i < TILE_SIZE * TILE_SIZE; i++) {
        check_near(out[4 * i], 188, 1);
        assert_int_equal(out[4 * i + 3], 255);
    }
    for (size_t i = 0; i < count; i++)
        memset(raster + 4 * i, 200, 3), raster[4 * i + 3] = i % 2 ? 255 : 0;
    matrix_resample_pixels(&fine, id, &s, raster, out);
    check_near(out[3], 128, 1);
    check_near(out[0], 100, 1); // multiplied
    free(raster);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_and_columns_are_where_they_were),
        cmocka_unit_test(spans),
        cmocka_unit_test(every_tile_is_covered),
        cmocka_unit_test(mercator_ends),
        cmocka_unit_test(colour_is_averaged_in_linear_light),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
