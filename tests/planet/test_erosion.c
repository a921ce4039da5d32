// Eroded ground: the stripes' statistics and direction, every sample against the same rules in
// double precision, and the floor that no valley is dug below.
#include "check.h"

#include "base/vec.h"
#include "geo/shared.h"
#include "planet/synthesis.h"
#include "planet_fixture.h"

enum { SAMPLES = TILE_SIZE * TILE_SIZE };

static const geodetic places[] = {{0.1, 0.2, 0}, {0.8, -3.14, 0}, {-1.2, 1.5, 0}};

static region region_at(int zoom, geodetic at, float *data)
{
    int row = (int)((M_PI / 2 - at.lat) / M_PI * grid_rows(zoom));
    int col = (int)((at.lon / (2 * M_PI) + 0.5) * grid_cols(zoom, row));
    return region_of_tile((tile_id){LAYER_HEIGHT, zoom, row, col}, 1, data);
}

static const float wave = 0.9f; // cycles a cell

// `turn`: of the wave vector from east to north.
static void fill_stripes(const region *r, double turn)
{
    static synthesis_columns columns;
    static float east[TILE_SIZE], north[TILE_SIZE];
    for (int i = 0; i < TILE_SIZE; i++)
        east[i] = wave * (float)cos(turn), north[i] = wave * (float)sin(turn);
    synthesis_columns_of(r, &columns);
    for (int y = 0; y < r->rows; y++)
        synthesis_stripes(&columns, r->cols, r->zoom, grid_lat(r->zoom, r->row + y), east, north,
                          r->data + y * r->stride);
}

// Mutation: a factor of STRIPE_SCALE off by 1.1, or a lattice in float.
static void stripes_are_alike_everywhere(void **state)
{
    (void)state;
    static float h[SAMPLES];
    double worst_mean = 0, least = 9, most = 0, peak = 0;
    for (int zoom = 5; zoom <= GRID_MAX_ZOOM; zoom++)
        for (int k = 0; k < 3; k++) {
            region r = region_at(zoom, places[k], h);
            fill_stripes(&r, zoom + k);
            double sum = 0, sum2 = 0;
            for (int i = 0; i < SAMPLES; i++) {
                sum += h[i];
                sum2 += h[i] * h[i];
                peak = fmax(peak, fabs(h[i]));
            }
            worst_mean = fmax(worst_mean, fabs(sum / SAMPLES));
            least = fmin(least, sqrt(sum2 / SAMPLES));
            most = fmax(most, sqrt(sum2 / SAMPLES));
        }
    print_message("mean within %.3f, rms %.3f to %.3f, peak %.3f\n", worst_mean, least, most, peak);
    assert_true(worst_mean < 0.03 && least > 0.97 && most < 1.03 && peak < 1.6);
}

// Half as steep again along the wave vector as square to it, in any direction and anywhere.
// Mutation: east and north exchanged, or a sign of theirs.
static void stripes_run_square_to_their_wave(void **state)
{
    (void)state;
    static float h[SAMPLES];
    double worst = 99;
    for (int zoom = 6; zoom <= 18; zoom += 4)
        for (int k = 0; k < 3; k++)
            for (double turn = 0; turn < 3; turn += 0.5) {
                region r = region_at(zoom, places[k], h);
                fill_stripes(&r, turn);
                double across = 0, along = 0;
                for (int y = 0; y < TILE_SIZE - 1; y++) {
                    double shape = r.coalesce * cos(grid_lat(zoom, r.row + y));
                    for (int x = 0; x < TILE_SIZE - 1; x++) {
                        const float *at = h + y * TILE_SIZE + x;
                        double e = (at[1] - at[0]) / shape, n = at[0] - at[TILE_SIZE];
                        across += pow(e * cos(turn) + n * sin(turn), 2);
                        along += pow(n * cos(turn) - e * sin(turn), 2);
                    }
                }
                worst = fmin(worst, sqrt(across / along));
            }
    print_message("at least %.2f times as steep across as along\n", worst);
    assert_true(worst > 1.3);
}

// Ground for the rules: zoom 2 and finer made from zoom 1. Near sea level, where a float holds
// millimetres.
static float low_height(tile_id id, int row, int col, double lat, double lon)
{
    return fixture_land_height(id, row, col, lat, lon) - 50000;
}

static fixture land;

static double sample(const opened *o, int zoom, int64_t row, int64_t col)
{
    int tile_row = (int)(row / TILE_SIZE);
    int64_t cols = (int64_t)TILE_SIZE * grid_cols(zoom, tile_row);
    col = (col % cols + cols) % cols;
    const pyramid_tile *t =
        fixture_get(o, (tile_id){LAYER_HEIGHT, zoom, tile_row, (int)(col / TILE_SIZE)});
    double h = t->heights[row % TILE_SIZE * TILE_SIZE + col % TILE_SIZE];
    fixture_put_back(o, t);
    return h;
}

// The 4 x 4 samples of the parent about one of the child, and what they say.
struct patch {
    double h[4][4], shape[4]; // of a column's length to a row's
    double v, u;              // the child's place, in samples from h[1][1]
    double spacing;
};

// What the parent's inner samples say at [y, x], y and x of 1 and 2.
struct signs {
    double amplitude, bend, east, north;
};

static double tempered(double relief, double spacing)
{
    double least = 0.03 * spacing / sqrt(1 + spacing / 100), steep = 0.15 * spacing;
    double h2 = relief * relief + least * least;
    return relief > 0 ? sqrt(h2 / (1 + h2 / (steep * steep))) : 0;
}

static struct signs signs_at(const struct patch *p, int y, int x, double share)
{
    double sum = 0, weights = 0;
    for (int r = y - 1; r <= y + 1; r++)
        for (int c = x - 1; c < x + 1; c++) {
            double d = (p->h[r][c + 1] - p->h[r][c]) / p->shape[r];
            double w = fmin(4 * p->shape[r] * p->shape[r], 1);
            sum += w * d * d;
            weights += w;
        }
    for (int r = y - 1; r < y + 1; r++)
        for (int c = x - 1; c <= x + 1; c++) {
            sum += pow(p->h[r + 1][c] - p->h[r][c], 2);
            weights += 1;
        }
    double relief = sqrt(sum / weights);
    double least = 0.03 * p->spacing / sqrt(1 + p->spacing / 100);
    double north = (p->h[y - 1][x] - p->h[y + 1][x]) / 2;
    double east = (p->h[y][x + 1] - p->h[y][x - 1]) / 2 / p->shape[y];
    double k =
        wave / sqrt(north * north + east * east + 0.35 * 0.35 * (relief * relief + least * least));
    double mean = (p->h[y - 1][x] + p->h[y + 1][x] + p->h[y][x - 1] + p->h[y][x + 1]) / 4;
    return (struct signs){share * tempered(relief, p->spacing), mean - p->h[y][x], -k * north,
                          k * east};
}

static double spline(const double h[4], double t)
{
    double a = (h[2] - h[0]) / 2, b = (h[3] - h[1]) / 2, t2 = t * t, t3 = t2 * t;
    return (2 * t3 - 3 * t2 + 1) * h[1] + (t3 - 2 * t2 + t) * a + (-2 * t3 + 3 * t2) * h[2] +
           (t3 - t2) * b;
}

// The lattice's cell and the place in it, of an axis.
static uint32_t cell_of(double direction, double frequency, int zoom, double shift, double *place)
{
    double p = direction * frequency + 0x1p30 + (zoom + 1) * shift;
    *place = p - floor(p);
    return (uint32_t)(int64_t)floor(p);
}

static double noise_at(int zoom, double lat, double lon, bool stripes, double east, double north)
{
    double frequency = 1 / ((stripes ? 4 : 2) * grid_step_lat(zoom)), x, y, z;
    uint32_t hx = cell_of(cos(lat) * cos(lon), frequency, zoom, 0.8191725133961645, &x),
             hy = cell_of(cos(lat) * sin(lon), frequency, zoom, 0.6710436067037893, &y),
             hz = cell_of(sin(lat), frequency, zoom, 0.5497004779019703, &z);
    hx *= 0x9e3779b1u, hy *= 0x85ebca77u;
    hz = hz * 0xc2b2ae3du + (uint32_t)zoom * 0x27d4eb2fu;
    if (!stripes) return gradient_noise_d(hx, hy, hz, x, y, z);
    return stripe_noise_d(hx, hy, hz, x, y, z, -east * sin(lon) - north * sin(lat) * cos(lon),
                          east * cos(lon) - north * sin(lat) * sin(lon), north * cos(lat));
}

static double residual(const struct patch *p, tile_id id, int r, int c, enum synthesis kind,
                       double share, double up)
{
    struct signs s = {0};
    for (int y = 0; y < 2; y++)
        for (int x = 0; x < 2; x++) {
            struct signs at = signs_at(p, y + 1, x + 1, share);
            double w = (y ? p->v : 1 - p->v) * (x ? p->u : 1 - p->u);
            s.amplitude += w * at.amplitude, s.bend += w * at.bend;
            s.east += w * at.east, s.north += w * at.north;
        }
    double lat, lon, base = INFINITY;
    fixture_place(id, r, c, &lat, &lon);
    double noise = noise_at(id.zoom, lat, lon, kind == SYNTHESIS_ERODED, s.east, s.north);
    double change = s.amplitude * noise;
    if (kind == SYNTHESIS_ERODED) {
        double most = 1.2 * s.amplitude, sharp = -0.8 * s.bend;
        sharp *= most / hypot(sharp, most);
        change = sharp + sqrt(fmax(s.amplitude * s.amplitude - sharp * sharp,
                                   s.amplitude * s.amplitude / 4)) *
                             noise;
    }
    for (int y = 0; y < 4; y++)
        for (int x = 0; x < 4; x++) base = fmin(base, p->h[y][x]);
    double from = fmax(up, base), room = from - base;
    if (change < 0) change = -(-change * room) / (room - change);
    return from + change;
}

static struct patch patch_at(const opened *o, tile_id id, int r, int c)
{
    int64_t row = (int64_t)TILE_SIZE * id.row + r, col = (int64_t)TILE_SIZE * id.col + c;
    int64_t first_row = region_first_tap(row), first_col = region_first_tap(col);
    struct patch p = {.v = row % 2 ? 0.25 : 0.75,
                      .u = col % 2 ? 0.25 : 0.75,
                      .spacing = GEO_WGS84.a * grid_step_lat(id.zoom - 1)};
    for (int y = 0; y < 4; y++) {
        p.shape[y] =
            grid_coalesce(id.zoom - 1, id.row / 2) * cos(grid_lat(id.zoom - 1, first_row + y));
        for (int x = 0; x < 4; x++)
            p.h[y][x] = sample(o, id.zoom - 1, first_row + y, first_col + x);
    }
    return p;
}

// Tiles and their parents of one width, away from rows of another width and from the poles.
static bool simple(tile_id id)
{
    int coalesce = grid_coalesce(id.zoom, id.row), last = grid_rows(id.zoom) - 1;
    if (id.row < 2 || id.row > last - 2) return false;
    for (int d = -2; d <= 2; d += 2)
        if (grid_coalesce(id.zoom - 1, (id.row + d) / 2) != coalesce) return false;
    return true;
}

// The spline of the parent's samples and the residual, with such a share of its amplitude.
static double made_at(const opened *o, tile_id id, int r, int c, enum synthesis kind, double share,
                      double *up)
{
    struct patch p = patch_at(o, id, r, c);
    double across[4];
    for (int y = 0; y < 4; y++) across[y] = spline(p.h[y], p.u);
    *up = spline(across, p.v);
    return residual(&p, id, r, c, kind, share, *up);
}

// Every sample is what the rules say in double precision, but for the rounding of heights to
// float. Mutation: any of the constants, a wrong tap, a sign.
static void samples_are_what_the_rules_say(enum synthesis kind)
{
    opened o = fixture_open(&land, 0, kind);
    struct check_random random = {31};
    double worst = 0, moved = 0;
    int count = 0;
    for (int zoom = 3; zoom <= 12; zoom += 3)
        for (int place = 0; place < FIXTURE_PLACES; place++) {
            tile_id id = fixture_place_tile(place, zoom);
            if (!simple(id)) continue;
            // gain 0.25: by so much above the steady share at the first zoom below the data
            double spacing = GEO_WGS84.a * grid_step_lat(zoom - 1);
            double share =
                0.16 * spacing / (spacing + 0.5) + (0.25 - 0.16) * ldexp(1, 2 - 2 * (zoom - 1));
            const pyramid_tile *t = fixture_get(&o, id);
            for (int k = 0; k < 300; k++) {
                int r = (int)(check_random_u64(&random) % TILE_SIZE),
                    c = (int)(check_random_u64(&random) % TILE_SIZE);
                double up, want = made_at(&o, id, r, c, kind, share, &up);
                double got = t->heights[r * TILE_SIZE + c];
                // Of the spacing: what is amplified is heights' rounding, not their size.
                worst = fmax(worst, fabs(got - want) / (1e-5 * spacing + 0.01));
                moved += fabs(want - up) / spacing;
                count++;
            }
            fixture_put_back(&o, t);
        }
    print_message("%d samples: worst %.3g of the bound, moved by %.3f of the spacing\n", count,
                  worst, moved / count);
    assert_true(count > 3000 && moved / count > 0.001);
    assert_true(worst < 1);
    fixture_close(&o);
}

static void rules_of_eroded_ground(void **state)
{
    (void)state;
    samples_are_what_the_rules_say(SYNTHESIS_ERODED);
}

static void rules_of_plain_ground(void **state)
{
    (void)state;
    samples_are_what_the_rules_say(SYNTHESIS_PLAIN);
}

// An island of data at ISLAND_ZOOM, about the corner of four tiles.
enum { ISLAND_ZOOM = 3 };
static const geodetic island_at = {M_PI / 8 + 0.004, M_PI / 8 + 0.007, 0};
static const double island_radius = 0.06;

static bool on_island(double lat, double lon)
{
    return hypot(lat - island_at.lat, lon - island_at.lon) < island_radius;
}

static float island_height(tile_id id, int row, int col, double lat, double lon)
{
    bool sea = id.zoom == ISLAND_ZOOM && !on_island(lat, lon);
    return sea ? NAN : low_height(id, row, col, lat, lon);
}

static bool is_island_tile(tile_id id)
{
    double west, south, east, north;
    grid_bounds(id, &west, &south, &east, &north);
    return id.zoom < 2 ||
           (id.zoom == ISLAND_ZOOM && on_island(clamp_double(island_at.lat, south, north),
                                                clamp_double(island_at.lon, west, east)));
}

// Of the sample nearest to a place: how far, in rows, the nearest stored sample is.
static double distance_to_island(int64_t row, int64_t col)
{
    double least = INFINITY, step = grid_step_lat(ISLAND_ZOOM);
    for (int64_t y = row - 10; y <= row + 10; y++)
        for (int64_t x = col - 12; x <= col + 12; x++) {
            double lat = grid_lat(ISLAND_ZOOM, y), lon = ((double)x + 0.5) * step - M_PI;
            if (on_island(lat, lon))
                least = fmin(least, hypot((double)(y - row), (double)(x - col) * cos(lat)));
        }
    return least;
}

// Beside stored ground of its zoom a sample has as much less of the residual as it is near.
// Mutation: PYRAMID_FADE_ROWS 7; gaps of the tile itself alone; the share left out; one for the
// other of rows and columns.
static void it_comes_in_beside_stored_ground(void **state)
{
    (void)state;
    fixture f;
    fixture_init(&f, "erosion-island");
    fixture_write(&f, ISLAND_ZOOM, 0.25, island_height, is_island_tile);
    struct check_random random = {37};
    double step = grid_step_lat(ISLAND_ZOOM), spacing = GEO_WGS84.a * 2 * step;
    for (enum synthesis kind = SYNTHESIS_ERODED; kind <= SYNTHESIS_PLAIN; kind++) {
        opened o = fixture_open(&f, 0, kind);
        double worst = 0, moved[2] = {0};
        int count[2] = {0};
        for (int k = 0; k < 4000; k++) {
            double turn = check_random_range(&random, 0, 2 * M_PI),
                   off = island_radius + check_random_range(&random, 0, 12) * step;
            int64_t row = (int64_t)((M_PI / 2 - island_at.lat - off * sin(turn)) / step),
                    col = (int64_t)((island_at.lon + off * cos(turn) + M_PI) / step);
            double far = distance_to_island(row, col), t = fmin(1, (far - 0.5) / 8), up;
            if (!(far > 0)) continue;
            tile_id id = {LAYER_HEIGHT, ISLAND_ZOOM, (int)(row / TILE_SIZE),
                          (int)(col / TILE_SIZE)};
            double share = 0.16 * spacing / (spacing + 0.5) * t * t * (3 - 2 * t);
            double want =
                made_at(&o, id, (int)(row % TILE_SIZE), (int)(col % TILE_SIZE), kind, share, &up);
            worst = fmax(worst,
                         fabs(sample(&o, ISLAND_ZOOM, row, col) - want) / (1e-5 * spacing + 0.01));
            moved[far > 4] += fabs(want - up);
            count[far > 4]++;
        }
        print_message("%d and %d samples: worst %.3g of the bound, moved by %.1f and %.1f m\n",
                      count[0], count[1], worst, moved[0] / count[0], moved[1] / count[1]);
        assert_true(count[0] > 1000 && count[1] > 1000 && moved[1] / count[1] > 10);
        assert_true(worst < 1);
        fixture_close(&o);
    }
    fixture_deinit(&f);
}

// A level sea beside mountains of 4000 m that rise in two samples.
static float cliff_height(tile_id id, int row, int col, double lat, double lon)
{
    (void)id;
    (void)row;
    (void)col;
    double h = sin(7 * lon + 1) * cos(5 * lat) - 0.2 + 0.3 * sin(31 * lon) * sin(29 * lat);
    return h < 0 ? 0 : (float)fmin(60000 * h, 4000 + 500 * h);
}

// No shore is dug out. Mutation: without upsample_least_row the deepest is -3270 m, and
// without region.c's floor, where rows meet tiles of another width, -107 m.
static void nothing_is_dug_below_its_floor(void **state)
{
    (void)state;
    fixture f;
    fixture_init(&f, "erosion-cliff");
    fixture_write(&f, 1, 0.5, cliff_height, NULL);
    for (enum synthesis kind = SYNTHESIS_ERODED; kind <= SYNTHESIS_PLAIN; kind++) {
        opened o = fixture_open(&f, 0, kind);
        float least = INFINITY, most = 0;
        for (int zoom = 2; zoom <= 8; zoom++)
            for (int place = 0; place < FIXTURE_PLACES; place++) {
                const pyramid_tile *t = fixture_get(&o, fixture_place_tile(place, zoom));
                least = fminf(least, t->min);
                most = fmaxf(most, t->max);
                fixture_put_back(&o, t);
            }
        print_message("from %.3f to %.0f m\n", (double)least, (double)most);
        assert_true(least >= 0 && most > 3000);
        fixture_close(&o);
    }
    fixture_deinit(&f);
}

static int setup(void **state)
{
    (void)state;
    fixture_init(&land, "erosion");
    fixture_write(&land, 1, 0.25, low_height, NULL);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    fixture_deinit(&land);
    return 0;
}

// What is a hair above the floor is on it, or the next finer zoom would take it for a slope: how a
// division is rounded differs between processors. A height of a millimetre is none.
static void level_water_is_level(void **state)
{
    (void)state;
    for (double floor = -400; floor <= 8000; floor += 100) {
        float base = (float)floor;
        for (double hair = 1e-9; hair < 3e-3; hair *= 10) {
            float up = (float)(floor + hair);
            assert_true(synthesis_limited_f(up, base, -2) == base);
        }
        assert_true(synthesis_limited_f(base, base, 0) == base);
        assert_true(synthesis_limited_f(base + 0.03125f, base, 0) == base + 0.03125f);
        assert_true(synthesis_limited_f(base, base, 0.03125f) == base + 0.03125f);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(stripes_are_alike_everywhere),
        cmocka_unit_test(stripes_run_square_to_their_wave),
        cmocka_unit_test(rules_of_eroded_ground),
        cmocka_unit_test(rules_of_plain_ground),
        cmocka_unit_test(it_comes_in_beside_stored_ground),
        cmocka_unit_test(nothing_is_dug_below_its_floor),
        cmocka_unit_test(level_water_is_level),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
