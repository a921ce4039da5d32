// The pyramid's filter against a plain sum over every child sample of the planet, by chords of unit
// vectors.
#include "check.h"

#include <stdbool.h>

#include "base/memory.h"
#include "base/vec.h"
#include "planet/filter.h"

enum { SAMPLES = TILE_SIZE * TILE_SIZE, MAX_TILES = 160, WAVES = 16 };

// A field given by a function, tiled on demand.
struct field {
    float (*value)(const struct field *f, dvec3 n);
    dvec3 wave[WAVES]; // rad / rad
    double phase[WAVES];
    bool sparse; // tiles of odd columns + rows are not stored, and of the others an eighth of the
                 // samples is NaN
    float *tiles[MAX_TILES];
    tile_id ids[MAX_TILES];
    int count;
};

static dvec3 unit(double lat, double lon)
{
    return (dvec3){cos(lat) * cos(lon), cos(lat) * sin(lon), sin(lat)};
}

static dvec3 sample_normal(tile_id id, int y, int x)
{
    double lat = M_PI / 2 - ((double)id.row * TILE_SIZE + y + 0.5) * grid_step_lat(id.zoom);
    double lon = -M_PI + ((double)id.col * TILE_SIZE + x + 0.5) * grid_step_lon(id.zoom, id.row);
    return unit(lat, lon);
}

static bool is_hole(int y, int x)
{
    return ((y / 8) * 5 + x / 8) % 8 == 0;
}

static const float *field_tile(void *user, tile_id id, bool *has_nan)
{
    struct field *f = user;
    *has_nan = f->sparse;
    if (f->sparse && (id.row + id.col) % 2) return NULL;
    for (int i = 0; i < f->count; i++)
        if (tile_id_equal(f->ids[i], id)) return f->tiles[i];
    assert_true(f->count < MAX_TILES);
    float *t = NEW_ARRAY(float, SAMPLES);
    for (int i = 0; i < SAMPLES; i++) {
        int y = i / TILE_SIZE, x = i % TILE_SIZE;
        t[i] = f->sparse && is_hole(y, x) ? NAN : f->value(f, sample_normal(id, y, x));
    }
    f->ids[f->count] = id;
    f->tiles[f->count] = t;
    return f->tiles[f->count++];
}

static void free_field(struct field *f)
{
    for (int i = 0; i < f->count; i++) free(f->tiles[i]);
    f->count = 0;
}

static float one(const struct field *f, dvec3 n)
{
    (void)f;
    (void)n;
    return 1;
}

// Rough at the scale of a sample, and without any symmetry.
static float rough(const struct field *f, dvec3 n)
{
    (void)f;
    return (float)(100 * sin(531 * n.x + 3) * sin(443 * n.y + 1) + 50 * sin(617 * n.z) + 7 * n.x);
}

// The filter's definition, without its short cuts.
static void plain_filter(struct field *f, tile_id parent, int y, int x, double *value,
                         double *coverage)
{
    double step = grid_step_lat(parent.zoom), sum = 0, weight = 0, total = 0;
    dvec3 p = sample_normal(parent, y, x);
    int zoom = parent.zoom + 1;
    for (int row = 0; row < grid_rows(zoom); row++)
        for (int col = 0; col < grid_cols(zoom, row); col++) {
            tile_id child = {parent.layer, zoom, row, col};
            bool has_nan;
            const float *tile = field_tile(f, child, &has_nan);
            for (int i = 0; i < SAMPLES; i++) {
                // A chord is no shorter than the difference in z.
                double lat = M_PI / 2 - (row * TILE_SIZE + i / TILE_SIZE + 0.5) * step / 2;
                if (fabs(sin(lat) - p.z) > FILTER_REACH * step) {
                    i |= TILE_SIZE - 1;
                    continue;
                }
                dvec3 n = sample_normal(child, i / TILE_SIZE, i % TILE_SIZE);
                double chord = dvec3_length(dvec3_sub(n, p));
                if (chord > FILTER_REACH * step) continue;
                double area = sqrt(1 - n.z * n.z) * grid_coalesce(zoom, row);
                double rim = exp(-0.5 * pow(FILTER_REACH / FILTER_SIGMA, 2));
                double w = area * (exp(-0.5 * pow(chord / (FILTER_SIGMA * step), 2)) - rim);
                total += w;
                if (!tile || isnan(tile[i])) continue;
                weight += w;
                sum += w * (double)tile[i];
            }
        }
    *value = weight > 0 ? sum / weight : NAN;
    *coverage = weight / total;
}

static struct filter_room room;

static int free_room(void **state)
{
    (void)state;
    filter_room_deinit(&room);
    return 0;
}

static void compare_with_plain(bool sparse, tile_id parent)
{
    static const int places[][2] = {{0, 0},    {0, 131}, {1, 255}, {3, 40},   {9, 255},
                                    {100, 80}, {128, 0}, {255, 0}, {255, 77}, {254, 255}};
    static float planes[SAMPLES], coverage[SAMPLES];
    struct field f = {.value = rough, .sparse = sparse};
    filter_parent(parent, 1, field_tile, &f, &room, planes, coverage);
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        int y = places[i][0], x = places[i][1];
        double value, share;
        plain_filter(&f, parent, y, x, &value, &share);
        check_near(coverage[y * TILE_SIZE + x], share, 1e-5);
        if (isnan(value)) assert_true(isnan(planes[y * TILE_SIZE + x]));
        else if (share > 0.05) check_near(planes[y * TILE_SIZE + x], value, 0.4);
    }
    free_field(&f);
}

static void test_plain_sum(void **state)
{
    (void)state;
    compare_with_plain(false, (tile_id){LAYER_HEIGHT, 0, 0, 0});
    compare_with_plain(true, (tile_id){LAYER_HEIGHT, 0, 0, 1});
    compare_with_plain(false, (tile_id){LAYER_HEIGHT, 1, 0, 0});
    compare_with_plain(true, (tile_id){LAYER_HEIGHT, 1, 1, 3});
    compare_with_plain(false, (tile_id){LAYER_HEIGHT, 2, 0, 7});
    compare_with_plain(true, (tile_id){LAYER_HEIGHT, 2, 3, 0});
}

// A constant stays itself, from pole to pole.
static void test_constant(void **state)
{
    (void)state;
    static float planes[SAMPLES], coverage[SAMPLES];
    for (int zoom = 0; zoom <= 3; zoom++)
        for (int row = 0; row < grid_rows(zoom); row++) {
            struct field f = {.value = one};
            tile_id parent = {LAYER_HEIGHT, zoom, row, grid_cols(zoom, row) - 1};
            filter_parent(parent, 1, field_tile, &f, &room, planes, coverage);
            for (int i = 0; i < SAMPLES; i++) {
                check_near(planes[i], 1, 2e-6);
                check_near(coverage[i], 1, 2e-6);
            }
            free_field(&f);
        }
}

// A parent's step of longitude is a whole number of child steps, at most 4, for all child rows in
// reach.
static void test_ratios(void **state)
{
    (void)state;
    for (int zoom = 0; zoom < 16; zoom++)
        for (int row = 0; row < grid_rows(zoom); row++)
            for (int child = 2 * row - 1; child <= 2 * row + 2; child++) {
                if (child < 0 || child >= grid_rows(zoom + 1)) continue;
                int parents = 2 * grid_coalesce(zoom, row),
                    children = grid_coalesce(zoom + 1, child);
                if (parents % children == 0 && parents / children <= 4) continue;
                fail_msg("zoom %d row %d child row %d: %d / %d", zoom, row, child, parents,
                         children);
            }
}

static const int wave_zoom = 3;

// Plane waves of 0.2 to 0.4 cycles a parent sample around the x axis, turned so that the axis
// points at a place.
static void make_waves(struct field *f, double lat, double lon)
{
    struct check_random r = {99};
    dmat3 place =
        dmat3_transpose((dmat3){{unit(lat, lon),
                                 {-sin(lon), cos(lon), 0},
                                 {-sin(lat) * cos(lon), -sin(lat) * sin(lon), cos(lat)}}});
    for (int i = 0; i < WAVES; i++) {
        double turn = check_random_range(&r, 0, 2 * M_PI),
               cycles = check_random_range(&r, 0.2, 0.4);
        double k = 2 * M_PI * cycles / grid_step_lat(wave_zoom);
        f->wave[i] = dmat3_mul(place, (dvec3){0, k * cos(turn), k * sin(turn)});
        f->phase[i] = check_random_range(&r, 0, 2 * M_PI);
    }
}

static float waves(const struct field *f, dvec3 n)
{
    double sum = 0;
    for (int i = 0; i < WAVES; i++) sum += sin(dvec3_dot(f->wave[i], n) + f->phase[i]);
    return (float)sum;
}

// rms over the disc of 0.04 rad around a place of what the filter makes of the waves turned to that
// place.
static double patch_rms(double lat, double lon)
{
    static float planes[SAMPLES], coverage[SAMPLES];
    static struct field f;
    f.value = waves;
    make_waves(&f, lat, lon);
    dvec3 centre = unit(lat, lon);
    double sum = 0, area = 0;
    for (int row = 0; row < grid_rows(wave_zoom); row++)
        for (int col = 0; col < grid_cols(wave_zoom, row); col++) {
            tile_id id = {LAYER_HEIGHT, wave_zoom, row, col};
            double west, south, east, north;
            grid_bounds(id, &west, &south, &east, &north);
            if (lat + 0.05 < south || lat - 0.05 > north) continue;
            double apart = remainder((west + east) / 2 - lon, 2 * M_PI);
            if (lat < 1.5 && fabs(apart) > (east - west) / 2 + 0.3) continue;
            filter_parent(id, 1, field_tile, &f, &room, planes, coverage);
            free_field(&f);
            for (int i = 0; i < SAMPLES; i++) {
                dvec3 n = sample_normal(id, i / TILE_SIZE, i % TILE_SIZE);
                if (dvec3_length(dvec3_sub(n, centre)) > 0.04) continue;
                double w = sqrt(1 - n.z * n.z) * grid_coalesce(id.zoom, id.row);
                sum += w * (double)planes[i] * (double)planes[i];
                area += w;
            }
        }
    return sqrt(sum / area);
}

// The same field, turned, comes out alike at the equator, at 80 N, on the antimeridian and at the
// pole.
static void test_spectrum(void **state)
{
    (void)state;
    static const double places[][2] = {{1.396, 0.2}, {-1.2, M_PI}, {M_PI / 2, 0}};
    double equator = patch_rms(0.1, 0.2);
    assert_true(equator > 1);
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        double there = patch_rms(places[i][0], places[i][1]);
        print_message("rms at the equator %.5f, at (%.2f, %.2f) %.5f\n", equator, places[i][0],
                      places[i][1], there);
        check_near(there / equator, 1, 0.006);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_ratios),
        cmocka_unit_test(test_constant),
        cmocka_unit_test(test_plain_sum),
        cmocka_unit_test(test_spectrum),
    };
    return cmocka_run_group_tests(tests, NULL, free_room);
}
