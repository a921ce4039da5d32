// The loops that are compiled twice (base/vector.h) against the same sources compiled once, for any
// processor: the same bits. Fails when either is allowed to fuse products and sums (-mfma
// -ffp-contract=fast for import_resample.c or filter.c).
#include "check.h"

#include "planet/codec_grid.h"
#include "planet/filter.h"
#include "planet/import_resample.h"

enum { SAMPLES = TILE_SIZE * TILE_SIZE, WIDTH = 1500, HEIGHT = 750 };

// The same functions of the other build (tests/planet/CMakeLists.txt).
status plain_resample_tile(struct raster *raster, tile_id id, struct resample_room *room,
                           float *planes);
void plain_resample_room_deinit(struct resample_room *room);
void plain_filter_parent(tile_id parent, int channels, filter_fetch fetch, void *user,
                         struct filter_room *room, float *planes, float *coverage);
void plain_filter_room_deinit(struct filter_room *room);
bool plain_grid_round(const float *samples, int exponent, int32_t *counts, bool *holes);
status plain_grid_encode(const int32_t *counts, int exponent, const float *holes, codec_blob *out);

static float raster_samples[WIDTH * HEIGHT], got[SAMPLES], want[SAMPLES];

static void fill(float *samples, int count, bool holes)
{
    struct check_random random = {11};
    for (int i = 0; i < count; i++) {
        samples[i] = (float)check_random_range(&random, -4000, 8000);
        if (holes && i % 97 < 3) samples[i] = NAN;
    }
}

static void needs_two_builds(void)
{
#ifdef __x86_64__
    if (__builtin_cpu_supports("avx2")) return;
#endif
    skip();
}

// Interpolated at the equator, averaged and in groups of columns near the poles.
static void resampled_alike(void **state)
{
    (void)state;
    needs_two_builds();
    static const tile_id ids[] = {{LAYER_HEIGHT, 2, 1, 3}, {LAYER_HEIGHT, 2, 0, 0},
                                  {LAYER_HEIGHT, 3, 7, 1}, {LAYER_HEIGHT, 0, 0, 1},
                                  {LAYER_HEIGHT, 5, 2, 4}, {LAYER_HEIGHT, 1, 1, 2}};
    for (int holes = 0; holes < 2; holes++) {
        fill(raster_samples, WIDTH * HEIGHT, holes);
        import_input input = {.source = {.layer = LAYER_HEIGHT, .path = "noise"},
                              .memory = raster_samples,
                              .width = WIDTH,
                              .height = HEIGHT};
        struct raster *raster;
        struct resample_room room = {0}, plain = {0};
        assert_int_equal(raster_open(&input, GEO_WGS84, &raster), OK);
        for (size_t i = 0; i < sizeof ids / sizeof *ids; i++) {
            assert_int_equal(resample_tile(raster, ids[i], &room, got), OK);
            assert_int_equal(plain_resample_tile(raster, ids[i], &plain, want), OK);
            assert_memory_equal(got, want, sizeof got);
        }
        resample_room_deinit(&room);
        plain_resample_room_deinit(&plain);
        raster_close(&raster);
    }
}

static const float *fetch(void *user, tile_id id, bool *has_nan)
{
    const bool *holes = user;
    *has_nan = *holes;
    return *holes && id.col % 5 == 3 ? NULL : raster_samples + id.row % 2 * 1000;
}

static void filtered_alike(void **state)
{
    (void)state;
    needs_two_builds();
    static const tile_id ids[] = {{LAYER_HEIGHT, 3, 3, 5}, {LAYER_HEIGHT, 3, 3, 6},
                                  {LAYER_HEIGHT, 4, 0, 1}, {LAYER_HEIGHT, 4, 14, 2},
                                  {LAYER_HEIGHT, 0, 0, 0}, {LAYER_HEIGHT, 4, 5, 0}};
    static float coverage[SAMPLES], plain_coverage[SAMPLES];
    struct filter_room room = {0}, plain = {0};
    for (int k = 0; k < 2; k++) {
        bool holes = k;
        fill(raster_samples, SAMPLES + 1000, holes);
        for (size_t i = 0; i < sizeof ids / sizeof *ids; i++) {
            filter_parent(ids[i], 1, fetch, &holes, &room, got, coverage);
            plain_filter_parent(ids[i], 1, fetch, &holes, &plain, want, plain_coverage);
            assert_memory_equal(got, want, sizeof got);
            assert_memory_equal(coverage, plain_coverage, sizeof coverage);
        }
    }
    filter_room_deinit(&room);
    plain_filter_room_deinit(&plain);
}

static void coded_alike(void **state)
{
    (void)state;
    needs_two_builds();
    static int32_t counts[SAMPLES], plain_counts[SAMPLES];
    for (int k = 0; k < 2; k++)
        for (int exponent = -12; exponent <= 8; exponent += 5) {
            bool holes, plain_holes;
            codec_blob body, plain;
            fill(got, SAMPLES, k);
            assert_int_equal(grid_round(got, exponent, counts, &holes),
                             plain_grid_round(got, exponent, plain_counts, &plain_holes));
            assert_int_equal(holes, plain_holes);
            assert_memory_equal(counts, plain_counts, sizeof counts);
            assert_int_equal(grid_encode(counts, exponent, holes ? got : NULL, &body), OK);
            assert_int_equal(plain_grid_encode(counts, exponent, holes ? got : NULL, &plain), OK);
            assert_int_equal(body.size, plain.size);
            assert_memory_equal(body.data, plain.data, body.size);
            codec_blob_deinit(&body);
            codec_blob_deinit(&plain);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(resampled_alike),
        cmocka_unit_test(filtered_alike),
        cmocka_unit_test(coded_alike),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
