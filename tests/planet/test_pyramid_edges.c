// The pyramid's samples against oracles of their own: a field known everywhere, and a second way to
// upsample that knows nothing of tiles; and no seam where tiles meet.
#include "check.h"

#include "planet_fixture.h"

enum { SAMPLES = TILE_SIZE * TILE_SIZE, DATA_ZOOM = 3 };

// Whole to DATA_ZOOM; to zoom 1, with sea; to zoom 1, all land.
static fixture smooth, rough, land;

static int setup_group(void **state)
{
    (void)state;
    fixture_init(&smooth, "pyramid-smooth");
    fixture_init(&rough, "pyramid-rough");
    fixture_init(&land, "pyramid-land");
    fixture_write(&smooth, DATA_ZOOM, 0.0, fixture_smooth_height, NULL);
    fixture_write(&rough, 1, 0.25, fixture_rough_height, NULL);
    fixture_write(&land, 1, 0.25, fixture_land_height, NULL);
    return 0;
}

static int teardown_group(void **state)
{
    (void)state;
    fixture_deinit(&smooth);
    fixture_deinit(&rough);
    fixture_deinit(&land);
    return 0;
}

// Measured: 7.7e-4 m, of a field of +-3000 m with waves of 10000 km: zoom 3's cubic error, and
// float rounding.
static void smooth_fields_stay_true(void **state)
{
    (void)state;
    opened o = fixture_open(&smooth, 0, SYNTHESIS_ERODED);
    double worst = 0.0;
    for (int zoom = 0; zoom <= DATA_ZOOM + 3; zoom++)
        for (int place = 0; place < FIXTURE_PLACES; place++) {
            tile_id id = fixture_place_tile(place, zoom);
            const pyramid_tile *tile = fixture_get(&o, id);
            float min = INFINITY, max = -INFINITY;
            for (int i = 0; i < SAMPLES; i++) {
                double lat, lon;
                fixture_place(id, i / TILE_SIZE, i % TILE_SIZE, &lat, &lon);
                double error = fabs((double)tile->heights[i] - fixture_smooth(lat, lon));
                worst = error > worst ? error : worst;
                min = fminf(min, tile->heights[i]);
                max = fmaxf(max, tile->heights[i]);
            }
            assert_true(tile->min == min && tile->max == max);
            fixture_put_back(&o, tile);
        }
    print_message("smooth field to zoom 6: worst error %.3g m\n", worst);
    check_near(worst, 0.0, 3e-3);
    struct pyramid_counters c;
    pyramid_counters(o.pyramid, &c);
    assert_true(c.decoded > 0 && c.upsampled > 0 && c.synthesised == 0 && c.corrupt == 0);
    fixture_close(&o);
}

// The sample of a whole zoom: any row and column; columns wrap, rows run over the poles.
static double sample(const opened *o, int zoom, int64_t row, int64_t col)
{
    int64_t rows = (int64_t)TILE_SIZE * grid_rows(zoom);
    bool beyond = row < 0 || row >= rows;
    if (beyond) row = row < 0 ? -1 - row : 2 * rows - 1 - row;
    int tile_row = (int)(row / TILE_SIZE);
    int64_t cols = (int64_t)TILE_SIZE * grid_cols(zoom, tile_row);
    if (beyond) col += cols / 2;
    col = (col % cols + cols) % cols;
    tile_id id = {LAYER_HEIGHT, zoom, tile_row, (int)(col / TILE_SIZE)};
    const pyramid_tile *tile = fixture_get(o, id);
    double h = tile->heights[row % TILE_SIZE * TILE_SIZE + col % TILE_SIZE];
    fixture_put_back(o, tile);
    return h;
}

// Catmull-Rom at any fraction, from its definition by tangents.
static double spline(const double h[4], double t)
{
    double m1 = (h[2] - h[0]) / 2, m2 = (h[3] - h[1]) / 2, t2 = t * t, t3 = t2 * t;
    return (2 * t3 - 3 * t2 + 1) * h[1] + (t3 - 2 * t2 + t) * m1 + (-2 * t3 + 3 * t2) * h[2] +
           (t3 - t2) * m2;
}

static double spline_along_row(const opened *o, int zoom, int64_t row, double turn)
{
    int64_t rows = (int64_t)TILE_SIZE * grid_rows(zoom);
    int64_t on = row < 0 ? -1 - row : row >= rows ? 2 * rows - 1 - row : row;
    double x = turn * TILE_SIZE * grid_cols(zoom, (int)(on / TILE_SIZE)) - 0.5, west = floor(x),
           h[4];
    for (int i = 0; i < 4; i++) h[i] = sample(o, zoom, row, (int64_t)west - 1 + i);
    return spline(h, x - west);
}

// What a sample of a tile must be, from the zoom before, by the spline through whole rows.
static double oracle(const opened *o, tile_id id, int r, int c)
{
    int64_t row = (int64_t)TILE_SIZE * id.row + r;
    double turn =
        ((double)TILE_SIZE * id.col + c + 0.5) / ((double)TILE_SIZE * grid_cols(id.zoom, id.row));
    double y = (row + 0.5) / 2 - 0.5, north = floor(y), h[4];
    // A row of tiles of another width is first brought to the columns of the parent, which lie
    // where the child's do or a quarter beside: the spline of the spline, not the spline there.
    int64_t parent_cols = (int64_t)TILE_SIZE * grid_cols(id.zoom - 1, id.row / 2);
    double x = turn * parent_cols - 0.5, west = floor(x);
    for (int i = 0; i < 4; i++) {
        double across[4];
        for (int k = 0; k < 4; k++)
            across[k] = spline_along_row(o, id.zoom - 1, (int64_t)north - 1 + i,
                                         ((int64_t)west - 1 + k + 0.5) / (double)parent_cols);
        h[i] = spline(across, x - west);
    }
    return spline(h, y - north);
}

// Every tile edge against the second way. What both neighbours of an edge compute from the same
// samples is thereby the same. Measured: 4.5e-3 m of heights to 40 km, which is float rounding.
static void edges_are_what_whole_rows_give(void **state)
{
    (void)state;
    opened o = fixture_open(&rough, 0, SYNTHESIS_NONE);
    struct check_random random = {5};
    double worst = 0.0;
    int compared = 0;
    for (int zoom = 2; zoom <= 8; zoom++)
        for (int place = 0; place < FIXTURE_PLACES; place++) {
            tile_id id = fixture_place_tile(place, zoom);
            const pyramid_tile *tile = fixture_get(&o, id);
            for (int k = 0; k < 60; k++) {
                int edge = (int)(check_random_u64(&random) % 6),
                    along = (int)(check_random_u64(&random) % 256);
                int near = edge % 2 ? 0 : 255, r = edge < 2 ? near : along,
                    c = edge < 2 ? along : near;
                if (edge > 3) c = (int)(check_random_u64(&random) % 256);
                double want = oracle(&o, id, r, c), got = tile->heights[r * TILE_SIZE + c];
                if (got == 0.0) continue; // flat water is kept flat; see below
                worst = fmax(worst, fabs(got - want));
                compared++;
            }
            fixture_put_back(&o, tile);
        }
    print_message("%d samples at edges: worst difference %.3g m\n", compared, worst);
    assert_true(compared > 2000);
    check_near(worst, 0.0, 0.02);
    fixture_close(&o);
}

// Sums of squared differences to the next row or column: over an edge, and over the middle of the
// tile, which lies between two samples of the zoom before, and of the one before that, as the edge
// does.
typedef struct steps {
    double inside, over;
} steps;

static double step2(const opened *o, int zoom, int64_t row, int64_t col, int down, int right)
{
    double d = sample(o, zoom, row + down, col + right) - sample(o, zoom, row, col);
    return d * d;
}

static void add_steps(const opened *o, tile_id id, steps *south, steps *east)
{
    int64_t row = (int64_t)TILE_SIZE * id.row, col = (int64_t)TILE_SIZE * id.col;
    for (int k = 0; k < TILE_SIZE; k += 3) {
        east->inside += step2(o, id.zoom, row + k, col + 127, 0, 1);
        east->over += step2(o, id.zoom, row + k, col + 255, 0, 1);
        south->inside += step2(o, id.zoom, row + 127, col + k, 1, 0);
        south->over += step2(o, id.zoom, row + 255, col + k, 1, 0);
    }
}

// With synthesis: steps over tile edges are as large as steps inside tiles, on the whole, over the
// antimeridian too. Mean logarithm of the ratio over 170 edges.
static void edges_show_no_seam(enum synthesis kind)
{
    opened o = fixture_open(&land, 0, kind);
    double log_south = 0.0, log_east = 0.0;
    int count = 0, rows = 0;
    for (int zoom = 2; zoom <= 12; zoom++)
        for (int place = 0; place < FIXTURE_PLACES; place++) {
            steps south = {0}, east = {0};
            tile_id id = fixture_place_tile(place, zoom);
            add_steps(&o, id, &south, &east);
            log_east += log(east.over / east.inside) / 2;
            count++;
            // Columns go on in the next row only if its tiles are as wide.
            if (id.row + 1 == grid_rows(zoom)) continue;
            if (grid_coalesce(zoom, id.row) != grid_coalesce(zoom, id.row + 1)) continue;
            log_south += log(south.over / south.inside) / 2;
            rows++;
        }
    print_message("%d edges: step over to step inside %.3f, %.3f\n", count + rows,
                  exp(log_south / rows), exp(log_east / count));
    check_near(log_south / rows, 0.0, 0.1);
    check_near(log_east / count, 0.0, 0.1);
    struct pyramid_counters c;
    pyramid_counters(o.pyramid, &c);
    assert_true(c.synthesised > 100);
    fixture_close(&o);
}

static void synthesised_edges_show_no_seam(void **state)
{
    (void)state;
    edges_show_no_seam(SYNTHESIS_ERODED);
    edges_show_no_seam(SYNTHESIS_PLAIN);
}

// The step over a pole is not larger than those before it. Measured at most 1.5 times.
static void poles_show_no_seam(enum synthesis kind)
{
    opened o = fixture_open(&land, 0, kind);
    double worst = 0;
    for (int zoom = 2; zoom <= 20; zoom++)
        for (int south = 0; south < 2; south++) {
            int64_t last = (int64_t)TILE_SIZE * grid_rows(zoom) - 1, row = south ? last : -1;
            int cols = TILE_SIZE * grid_cols(zoom, 0);
            double over = 0.0, inside = 0.0;
            for (int col = 0; col < cols; col += 37) {
                over += step2(&o, zoom, row, col, 1, 0);
                for (int k = 1; k < 4; k++)
                    inside += step2(&o, zoom, south ? last - k : k - 1, col, 1, 0) / 3;
            }
            worst = fmax(worst, sqrt(over / inside));
            assert_true(sqrt(over / inside) < 2.5);
        }
    print_message("over a pole at most %.2f times the steps before it\n", worst);
    fixture_close(&o);
}

static void synthesised_poles_show_no_seam(void **state)
{
    (void)state;
    poles_show_no_seam(SYNTHESIS_ERODED);
    poles_show_no_seam(SYNTHESIS_PLAIN);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(smooth_fields_stay_true),
        cmocka_unit_test(edges_are_what_whole_rows_give),
        cmocka_unit_test(synthesised_edges_show_no_seam),
        cmocka_unit_test(synthesised_poles_show_no_seam),
    };
    return cmocka_run_group_tests(tests, setup_group, teardown_group);
}
