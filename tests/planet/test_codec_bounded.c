// Heights within a bound: the bound, the prediction, and bodies broken in every way.
#include "check.h"

#include "bounded1_body.h"
#include "planet/codec_bounded.h"
#include "planet/codec_grid.h"
#include "planet/codec_predict.h"

enum { SAMPLES = TILE_SIZE * TILE_SIZE, HEAD = 24, HEAD1 = 32 };

static float heights[SAMPLES], parent[SAMPLES], predicted[SAMPLES], decoded[SAMPLES], got[SAMPLES];
static const tile_id child = {LAYER_HEIGHT, 5, 13, 20};

static double ground(double y, double x)
{
    return 900 * sin(y * 0.05) * cos(x * 0.03) + 40 * sin(x * 0.21 + y * 0.17);
}

// A tile on the bound's grid, with its parent: the same ground at half the resolution.
static void make_heights(double max_error, double rough, bool holes)
{
    struct check_random random = {3};
    double quantum = ldexp(1, bounded_exponent(max_error));
    for (int i = 0; i < SAMPLES; i++) {
        int y = i / TILE_SIZE, x = i % TILE_SIZE;
        double h = ground(y + 0.5, x + 0.5) + check_random_range(&random, -rough, rough);
        heights[i] = (float)(quantum * nearbyint(h / quantum));
        if (holes && (i % 7 == 0 || y < 2)) heights[i] = NAN;
        // The child is its parent's south-western quadrant.
        parent[i] = (float)ground(2 * (y - 127.5) - 0.0, 2 * x + 1.0);
    }
    predict_tile(child, parent, predicted);
}

// Fails when the decoder leaves out corrections or takes another step, when holes are filled.
static void the_bound_holds(void **state)
{
    (void)state;
    static const double bounds[] = {0x1p-8, 0.3, 1, 4, 50, 4096}, roughs[] = {0, 1, 30, 3000};
    for (size_t b = 0; b < sizeof bounds / sizeof *bounds; b++)
        for (size_t r = 0; r < sizeof roughs / sizeof *roughs; r++)
            for (int holes = 0; holes < 2; holes++) {
                make_heights(bounds[b], roughs[r], holes);
                codec_blob body;
                assert_int_equal(bounded_encode(heights, predicted, bounds[b], &body, decoded), OK);
                status s = bounded_is_body(body.data, body.size)
                               ? bounded_decode(body.data, body.size, predicted, got)
                               : codec_height_decode(body.data, body.size, got);
                assert_int_equal(s, OK);
                for (int i = 0; i < SAMPLES; i++) {
                    assert_true(isnan(heights[i]) ? isnan(got[i]) && isnan(decoded[i])
                                                  : got[i] == decoded[i]);
                    if (!isnan(heights[i])) check_near(got[i], heights[i], bounds[b]);
                }
                codec_blob_deinit(&body);
            }
}

// What the parent already says costs nothing, and what it says wrongly is found out.
// Fails when the prediction is not used; when the checksum is not looked at.
static void the_parent_counts(void **state)
{
    (void)state;
    make_heights(1, 0.5, false);
    codec_blob with, without;
    assert_int_equal(bounded_encode(heights, predicted, 1, &with, decoded), OK);
    assert_true(bounded_is_body(with.data, with.size));
    memset(got, 0, sizeof got);
    assert_int_equal(bounded_encode(heights, got, 1, &without, decoded), OK);
    print_message("%zu bytes with the parent, %zu without\n", with.size, without.size);
    assert_true(2 * with.size < without.size);
    parent[100 * TILE_SIZE + 100] += 3;
    parent[200 * TILE_SIZE + 20] += 3;
    predict_tile(child, parent, predicted);
    assert_int_equal(bounded_decode(with.data, with.size, predicted, got), ERR_FORMAT);
    codec_blob_deinit(&with);
    codec_blob_deinit(&without);
}

// The four-point filter has linear precision, and the straight line beyond the border too: from a
// parent on a plane every child lies on it, whichever quadrant it is and where tiles double their
// width. Fails when a quadrant is mistaken, an edge repeated, or the filter's halves swapped.
static void planes_are_predicted(void **state)
{
    (void)state;
    for (int zoom = 1; zoom <= 6; zoom++)
        for (int row = 0; row < grid_rows(zoom); row++)
            for (int col = 0; col < 2; col++) {
                tile_id id = {LAYER_HEIGHT, zoom, row, col}, above = tile_parent(id);
                double lon_step = grid_step_lon(zoom - 1, above.row) / grid_step_lat(zoom - 1);
                double west, south, east, north;
                grid_bounds(above, &west, &south, &east, &north);
                for (int i = 0; i < SAMPLES; i++)
                    parent[i] =
                        (float)(3 * (i / TILE_SIZE + 0.5) + 5 * lon_step * (i % TILE_SIZE + 0.5));
                predict_tile(id, parent, got);
                double w, s, e, n, step = grid_step_lat(zoom - 1);
                grid_bounds(id, &w, &s, &e, &n);
                for (int i = 0; i < SAMPLES; i++) {
                    double y = (north - n) / step + (i / TILE_SIZE + 0.5) / 2;
                    double x = (w - west + (i % TILE_SIZE + 0.5) * (e - w) / TILE_SIZE) / step;
                    check_near(got[i], 3 * y + 5 * x, 2e-2);
                }
            }
}

static void holes_of_the_parent_are_bridged(void **state)
{
    (void)state;
    for (int i = 0; i < SAMPLES; i++) parent[i] = i % 3 ? 70 : NAN;
    predict_tile(child, parent, got);
    for (int i = 0; i < SAMPLES; i++) check_near(got[i], 70, 1e-4);
    for (int i = 0; i < SAMPLES; i++) parent[i] = NAN;
    predict_tile(child, parent, got);
    assert_true(got[0] == 0 && got[SAMPLES - 1] == 0);
    predict_tile(child, NULL, got);
    assert_true(got[0] == 0 && got[SAMPLES - 1] == 0);
}

// Whole and binary numbers only, so that any machine makes the same prediction.
static void make_first_heights(void)
{
    for (int i = 0; i < SAMPLES; i++) {
        int y = i / TILE_SIZE, x = i % TILE_SIZE;
        int wave = abs(x % 128 - 64) / 4 + abs(y % 128 - 64) / 4;
        parent[i] = (float)(x * y) / 16;
        heights[i] = y < 2 ? NAN : (float)(y * x) / 64 + (float)(4 * x + wave);
        if (i % 8009 == 0) heights[i] += 60;
    }
    predict_tile(child, parent, predicted);
}

// Bodies that were made before the wavelet's coefficients were coded here. Fails when they are
// refused, when their holes are filled or when corrections are not taken.
static void first_bodies_are_read(void **state)
{
    (void)state;
    make_first_heights();
    assert_true(bounded_is_body(bounded1_body, sizeof bounded1_body));
    assert_int_equal(bounded_decode(bounded1_body, sizeof bounded1_body, predicted, got), OK);
    for (int i = 0; i < SAMPLES; i++) {
        if (isnan(heights[i])) assert_true(isnan(got[i]));
        else check_near(got[i], heights[i], 4);
    }
}

// The decoder sees a copy of just its size, so that a sanitizer sees every read past its end.
static status decode_copy(const unsigned char *data, size_t size)
{
    unsigned char *copy = malloc(size ? size : 1);
    memcpy(copy, data, size);
    status s =
        bounded_is_body(copy, size) ? bounded_decode(copy, size, predicted, got) : ERR_FORMAT;
    free(copy);
    return s;
}

// Without coefficients, with them and corrections, with holes too; and one of the first kind, that
// has all of them.
enum { EXAMPLES = 4, WITH_HOLES = 2, FIRST = 3 };

static codec_blob example(int kind)
{
    codec_blob body = {malloc(sizeof bounded1_body), sizeof bounded1_body};
    if (kind == FIRST) {
        make_first_heights();
        memcpy(body.data, bounded1_body, sizeof bounded1_body);
        assert_int_equal(bounded_decode(body.data, body.size, predicted, decoded), OK);
        return body;
    }
    free(body.data);
    make_heights(4, kind ? 6 : 2, kind == WITH_HOLES);
    assert_int_equal(bounded_encode(heights, predicted, 4, &body, decoded), OK);
    assert_true(bounded_is_body(body.data, body.size));
    return body;
}

static void truncated_bodies_are_refused(void **state)
{
    (void)state;
    for (int kind = 0; kind < EXAMPLES; kind++) {
        codec_blob body = example(kind);
        assert_int_equal(decode_copy(body.data, body.size), OK);
        for (size_t size = 0; size < body.size; size += 97)
            assert_int_equal(decode_copy(body.data, size), ERR_FORMAT);
        // The last byte may hold nothing but bits that are 0 in any case.
        status s = decode_copy(body.data, body.size - 1);
        for (int i = 0; !s && i < SAMPLES; i++)
            assert_true(got[i] == decoded[i] || isnan(decoded[i]));
        assert_true(s == OK || s == ERR_FORMAT);
        codec_blob_deinit(&body);
    }
}

// A flipped bit is found, or changes nothing. Fails when the checksum is not looked at.
static void flipped_bits_are_found(void **state)
{
    (void)state;
    struct check_random random = {9};
    for (int kind = 0; kind < EXAMPLES; kind++) {
        codec_blob body = example(kind);
        for (int k = 0; k < 500; k++) {
            size_t bit = k < 8 * HEAD ? (size_t)k : check_random_u64(&random) % (8 * body.size);
            body.data[bit / 8] ^= (unsigned char)(1 << bit % 8);
            status s = decode_copy(body.data, body.size);
            // The exponent of the quantum is no part of the counts.
            if (s == OK && bit / 8 != 4)
                for (int i = 0; i < SAMPLES; i++)
                    assert_true(got[i] == decoded[i] || kind >= WITH_HOLES);
            assert_true(s == OK || s == ERR_FORMAT || s == ERR_MEMORY);
            body.data[bit / 8] ^= (unsigned char)(1 << bit % 8);
        }
        codec_blob_deinit(&body);
    }
}

// Sizes, counts and places in the head that are more than there is.
static void claims_are_not_believed(void **state)
{
    (void)state;
    static const struct {
        int at, bytes;
        unsigned char value;
    } claims[] = {{4, 1, 0x80},  {4, 1, GRID_EXPONENT_MAX + 1},
                  {8, 1, 6},     {8, 1, 255},
                  {9, 1, 1},     {10, 2, 255},
                  {12, 2, 255},  {14, 2, 255},
                  {16, 4, 0xff}, {16, 4, 0},
                  {20, 4, 0}};
    for (int kind = 1; kind < FIRST; kind++) // the first has no coefficients to belie
        for (size_t i = 0; i < sizeof claims / sizeof *claims; i++) {
            codec_blob body = example(kind);
            memset(body.data + claims[i].at, claims[i].value, (size_t)claims[i].bytes);
            assert_int_equal(decode_copy(body.data, body.size), ERR_FORMAT);
            codec_blob_deinit(&body);
        }
}

// The same of the first kind: pictures of other sizes in place of the tile's.
static void first_claims_are_not_believed(void **state)
{
    (void)state;
    codec_blob body = example(FIRST);
    // The picture's SIZ marker: width at 8, height at 12, tile sizes at 24 and 28.
    unsigned char *siz = memmem(body.data, body.size, "\xff\x51", 2);
    assert_non_null(siz);
    static const int fields[] = {8, 12, 16, 20, 24, 28, 38};
    for (size_t f = 0; f < sizeof fields / sizeof *fields; f++)
        for (int k = 0; k < 4; k++) {
            unsigned char kept = siz[fields[f] + k];
            siz[fields[f] + k] ^= 0x7f;
            status s = decode_copy(body.data, body.size);
            assert_true(s == ERR_FORMAT || (s == OK && !memcmp(got, decoded, sizeof got)));
            siz[fields[f] + k] = kept;
        }
    for (int at = 8; at < HEAD1 - 4; at += 4) { // step, sizes, checksum
        unsigned char kept[4];
        memcpy(kept, body.data + at, 4);
        memset(body.data + at, 0xff, 4);
        assert_int_equal(decode_copy(body.data, body.size), ERR_FORMAT);
        memcpy(body.data + at, kept, 4);
    }
    codec_blob_deinit(&body);
}

// Noise behind a good head, as a body may hold where its hash has been made to fit. Fails, under a
// sanitizer, when the decoder reads past the body or its tables.
static void noise_is_survived(void **state)
{
    (void)state;
    struct check_random random = {13};
    codec_blob body = example(1);
    for (int k = 0; k < 200; k++) {
        for (size_t i = HEAD; i < body.size; i++)
            body.data[i] = (unsigned char)check_random_u64(&random);
        if (k % 2) body.data[10] = body.data[11] = 255; // the greatest step
        assert_int_equal(decode_copy(body.data, k % 3 ? body.size : HEAD + (size_t)k), ERR_FORMAT);
    }
    codec_blob_deinit(&body);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_bound_holds),
        cmocka_unit_test(the_parent_counts),
        cmocka_unit_test(planes_are_predicted),
        cmocka_unit_test(holes_of_the_parent_are_bridged),
        cmocka_unit_test(truncated_bodies_are_refused),
        cmocka_unit_test(flipped_bits_are_found),
        cmocka_unit_test(first_bodies_are_read),
        cmocka_unit_test(claims_are_not_believed),
        cmocka_unit_test(first_claims_are_not_believed),
        cmocka_unit_test(noise_is_survived),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
