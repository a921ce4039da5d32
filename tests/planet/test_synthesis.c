// Synthesis: the noise's statistics, the slopes it grows, and the gain that an import measures.
//
// Fails when broken: sums of the gain in another order with several threads.
#include "check.h"

#include "base/vec.h"
#include "planet/synthesis.h"
#include "planet_fixture.h"

enum { SAMPLES = TILE_SIZE * TILE_SIZE, WAVES = 200 };

static const geodetic places[] = {{0.1, 0.2, 0},  {0.8, -3.14, 0}, {-1.2, 1.5, 0},
                                  {1.57, 0.0, 0}, {-0.5, 2.5, 0},  {0.0, M_PI / 2, 0}};

enum { PLACES = sizeof places / sizeof places[0] };

static region region_at(int zoom, geodetic at, float *data)
{
    int row = (int)((M_PI / 2 - at.lat) / M_PI * grid_rows(zoom));
    int col = (int)((at.lon / (2 * M_PI) + 0.5) * grid_cols(zoom, row));
    return region_of_tile((tile_id){LAYER_HEIGHT, zoom, row, col}, 1, data);
}

static void fill_noise(const region *r)
{
    static synthesis_columns columns;
    synthesis_columns_of(r, &columns);
    for (int y = 0; y < r->rows; y++)
        synthesis_noise(&columns, r->cols, r->zoom, grid_lat(r->zoom, r->row + y),
                        r->data + y * r->stride);
}

// Tile by tile, at every zoom: mean 0, rms 1, no sample far out, and no sign of a lattice too
// coarse for the position's precision (neighbours still differ at zoom 24 as at zoom 5).
static void noise_is_alike_everywhere(void **state)
{
    (void)state;
    static float noise[SAMPLES];
    for (int zoom = 5; zoom <= GRID_MAX_ZOOM; zoom++)
        for (int k = 0; k < PLACES - 3; k++) {
            region r = region_at(zoom, places[k], noise);
            fill_noise(&r);
            double sum = 0, sum2 = 0, step2 = 0, peak = 0;
            for (int i = 0; i < SAMPLES; i++) {
                sum += noise[i];
                sum2 += noise[i] * noise[i];
                peak = fmax(peak, fabs(noise[i]));
                if (i >= TILE_SIZE) step2 += pow(noise[i] - noise[i - TILE_SIZE], 2);
            }
            check_near(sum / SAMPLES, 0.0, 0.03);          // measured 0.015
            check_near(sqrt(sum2 / SAMPLES), 1.0, 0.04);   // measured 0.011
            check_near(sqrt(step2 / SAMPLES), 1.05, 0.05); // measured 1.038 to 1.065
            assert_true(peak < 6.0);
        }
}

// Continuous with its slope: over a hundredth of a sample it changes by about a hundredth as much.
static void noise_is_smooth(void **state)
{
    (void)state;
    struct check_random random = {17};
    for (int k = 0; k < 2000; k++) {
        int zoom = 4 + k % 15;
        double lat = asin(check_random_range(&random, -1, 1)), step = grid_step_lat(zoom);
        double lon = check_random_range(&random, -M_PI, M_PI);
        synthesis_columns at = {{cos(lon)}, {sin(lon)}};
        float h[3];
        for (int i = 0; i < 3; i++)
            synthesis_noise(&at, 1, zoom, lat + (i - 1) * 0.01 * step, &h[i]);
        check_near(h[1] - h[0], 0.0, 0.06);
        check_near(h[2] - 2 * h[1] + h[0], 0.0, 2e-3);
    }
}

// What one zoom adds says nothing of what the next one adds.
static void zooms_are_independent(void **state)
{
    (void)state;
    double sum = 0, a2 = 0, b2 = 0;
    struct check_random random = {23};
    for (int k = 0; k < 20000; k++) {
        double lat = asin(check_random_range(&random, -1, 1));
        double lon = check_random_range(&random, -M_PI, M_PI);
        synthesis_columns at = {{cos(lon)}, {sin(lon)}};
        float a, b;
        synthesis_noise(&at, 1, 7, lat, &a);
        synthesis_noise(&at, 1, 8, lat, &b);
        sum += a * b;
        a2 += a * a;
        b2 += b * b;
    }
    check_near(sum / sqrt(a2 * b2), 0.0, 0.03); // four standard errors
}

static struct {
    double x, y, z, height, phase;
} waves[WAVES];

// Waves in all directions, of lengths down to the samples of zoom 0, with slopes above synthesis's
// least slope and below its steepest.
static void make_waves(void)
{
    struct check_random random = {42};
    for (int i = 0; i < WAVES; i++) {
        double k = 4.0 * exp2(check_random_range(&random, 0.0, 4.5));
        double z = check_random_range(&random, -1, 1), a = check_random_range(&random, 0, 2 * M_PI);
        waves[i].x = k * sqrt(1 - z * z) * cos(a);
        waves[i].y = k * sqrt(1 - z * z) * sin(a);
        waves[i].z = k * z;
        waves[i].height = 10000.0 * pow(k / 4.0, -0.85);
        waves[i].phase = check_random_range(&random, 0, 2 * M_PI);
    }
}

static float wave_height(tile_id id, int row, int col, double lat, double lon)
{
    (void)id;
    (void)row;
    (void)col;
    double x = cos(lat) * cos(lon), y = cos(lat) * sin(lon), z = sin(lat), h = 0.0;
    for (int i = 0; i < WAVES; i++)
        h += waves[i].height *
             sin(waves[i].x * x + waves[i].y * y + waves[i].z * z + waves[i].phase);
    return (float)h;
}

// Mean squared slope between rows, over rows [r0, r1) and columns [c0, c1) of a tile.
static double slope2(const pyramid_tile *t, int r0, int r1, int c0, int c1)
{
    double step = GEO_WGS84.a * grid_step_lat(t->id.zoom), sum = 0.0;
    for (int r = r0; r < r1; r++)
        for (int c = c0; c < c1; c++) {
            double d =
                (double)t->heights[(r + 1) * TILE_SIZE + c] - (double)t->heights[r * TILE_SIZE + c];
            sum += d * d / (step * step);
        }
    return sum / ((r1 - r0) * (c1 - c0));
}

// After fourteen zooms, at two hundred places, against the data's slope around them: rougher, but
// not without end. Measured 2.11, 2.25 and 2.86 times.
static void slopes_grow_but_little(void **state)
{
    (void)state;
    static const double gains[] = {0.02, 0.25, 0.6};
    make_waves();
    for (int g = 0; g < 3; g++) {
        fixture f;
        fixture_init(&f, "synthesis-slopes");
        fixture_write(&f, 0, gains[g], wave_height, NULL);
        opened o = fixture_open(&f, 0, SYNTHESIS_ERODED);
        struct check_random random = {1};
        double data = 0.0, deep = 0.0;
        for (int k = 0; k < 200; k++) {
            double lat = asin(check_random_range(&random, -0.95, 0.95));
            double lon = check_random_range(&random, -3, 3);
            int r = (int)((M_PI / 2 - lat) / M_PI * 256), c = (int)((lon / M_PI + 1) * 256) % 256;
            int west = c < 3 ? 0 : c > 252 ? 249 : c - 3;
            for (int zoom = 0; zoom <= 14; zoom += 14) {
                int row = (int)((M_PI / 2 - lat) / M_PI * grid_rows(zoom));
                int col = (int)((lon / (2 * M_PI) + 0.5) * grid_cols(zoom, row));
                const pyramid_tile *tile;
                tile_id id = {LAYER_HEIGHT, zoom, row, col};
                assert_int_equal(pyramid_acquire(o.pyramid, id, &tile), OK);
                if (zoom == 0) data += slope2(tile, r - 3, r + 3, west, west + 7);
                else deep += slope2(tile, 0, 255, 0, 256);
                pyramid_release(o.pyramid, &tile);
            }
        }
        double growth = sqrt(deep / data);
        print_message("gain %.2f: slope after 14 zooms %.2f times the data's\n", gains[g], growth);
        assert_true(growth > (g == 0 ? 0.8 : 1.0) && growth < 3.0);
        fixture_close(&o);
        fixture_deinit(&f);
    }
}

// A plane slope, and at zoom 1 a residual of known size on it.
// To a sample row of zoom 0, 78 km: so steep that the relief no ground is without does not count,
// and so gentle that it is not tempered: half a percent each.
static const double slope_m = 1500.0;
static double residual_share;

static float sloping_height(tile_id id, int row, int col, double lat, double lon)
{
    (void)lon;
    if (id.zoom == 1 && fabs(lat) > 1.0) return NAN; // columns crowd, and weigh less in the relief
    struct check_random random = {(uint64_t)(row * 256 + col) * 8 + (uint64_t)id.col + 1};
    for (int i = 0; i < 8; i++) check_random_u64(&random);
    double sign = check_random_u64(&random) >> 63 ? 1.0 : -1.0;
    // Of a plane slope along one axis the relief is the rms over both.
    double residual = id.zoom == 0 ? 0.0 : sign * residual_share * slope_m * sqrt(0.5);
    return (float)(lat / grid_step_lat(0) * slope_m + residual);
}

static void the_gain_is_measured(void **state)
{
    (void)state;
    static const struct {
        double residual, gain, tolerance;
    } cases[] = {{0.3, 0.3, 0.003}, {0.05, 0.05, 0.001}, {0.0, 0.02, 0.0}, {2.0, 0.6, 0.0}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        fixture f;
        struct planet_writer *w;
        double gain;
        fixture_init(&f, "synthesis-gain");
        residual_share = cases[i].residual;
        assert_int_equal(planet_writer_open(f.path, "gain", false, &w), OK);
        assert_int_equal(planet_measure_gain(w, GEO_WGS84.a, 1, NULL, NULL, &gain), OK);
        assert_true(gain == 0.0); // nothing to measure
        fixture_put_heights(w, 0, sloping_height, NULL);
        assert_int_equal(planet_measure_gain(w, GEO_WGS84.a, 1, NULL, NULL, &gain), OK);
        assert_true(gain == 0.0); // one zoom
        fixture_put_heights(w, 1, sloping_height, NULL);
        assert_int_equal(planet_measure_gain(w, GEO_WGS84.a, 1, NULL, NULL, &gain), OK);
        check_near(gain, cases[i].gain, cases[i].tolerance);
        fixture_put_heights(w, 2, sloping_height, NULL); // more than workers read at once
        double alone, together;
        assert_int_equal(planet_measure_gain(w, GEO_WGS84.a, 1, NULL, NULL, &alone), OK);
        assert_int_equal(planet_measure_gain(w, GEO_WGS84.a, 3, NULL, NULL, &together), OK);
        assert_true(alone == together);
        planet_writer_close(&w);
        fixture_deinit(&f);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(noise_is_alike_everywhere), cmocka_unit_test(noise_is_smooth),
        cmocka_unit_test(zooms_are_independent),     cmocka_unit_test(slopes_grow_but_little),
        cmocka_unit_test(the_gain_is_measured),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
