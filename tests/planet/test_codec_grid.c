// Heights on a grid of quanta: every sample, every quantum, and bodies broken in every way.
#include "check.h"

#include "planet/codec_grid.h"

enum { SAMPLES = TILE_SIZE * TILE_SIZE, HEAD = 12 };

static float heights[SAMPLES], rounded[SAMPLES], got[SAMPLES];

enum ground { SMOOTH, ROUGH, WILD, GROUNDS };

static void make_heights(enum ground ground, double scale, bool holes)
{
    struct check_random random = {3};
    for (int i = 0; i < SAMPLES; i++) {
        double h = 900 * sin(i / TILE_SIZE * 0.05) * cos(i % TILE_SIZE * 0.03);
        if (ground == ROUGH) h += check_random_range(&random, -3, 3);
        if (ground == WILD) h = check_random_range(&random, -8e6, 8e6);
        heights[i] = (float)(h * scale);
        if (holes && (i % 7 == 0 || i / TILE_SIZE < 2)) heights[i] = i % 2 ? NAN : INFINITY;
    }
    memcpy(rounded, heights, sizeof rounded);
}

// Decoded: the multiple nearest to each height, in double precision, and not a bit beside it.
// Fails when heights are cut off instead of rounded, when a hole is filled, when the prediction of
// the decoder differs from the coder's in any place.
static void nearest_multiples_come_back(void **state)
{
    (void)state;
    for (int exponent = GRID_EXPONENT_MIN; exponent <= GRID_EXPONENT_MAX; exponent++)
        for (enum ground ground = 0; ground < GROUNDS; ground++)
            for (int holes = 0; holes < 2; holes++) {
                double quantum = ldexp(1, exponent);
                make_heights(ground, ground == WILD ? quantum : 1, holes);
                codec_blob body;
                assert_int_equal(codec_height_encode_grid(rounded, exponent, &body), OK);
                assert_true(grid_is_body(body.data, body.size));
                assert_int_equal(codec_height_decode(body.data, body.size, got), OK);
                for (int i = 0; i < SAMPLES; i++) {
                    if (!isfinite(heights[i])) {
                        assert_true(isnan(got[i]) && isnan(rounded[i]));
                        continue;
                    }
                    check_near(got[i], quantum * nearbyint(heights[i] / quantum), 0);
                    assert_true(got[i] == rounded[i]);
                }
                codec_blob_deinit(&body);
            }
}

// Bytes: what the coder must do with noise of a known entropy. Uniform noise of n values cannot
// take less than log2(n) bits a sample; the gradient of the plane below costs next to nothing.
// Fails when the differences are not taken, or are coded with fixed bits.
static void size_is_near_the_entropy(void **state)
{
    (void)state;
    struct check_random random = {5};
    for (int i = 0; i < SAMPLES; i++)
        rounded[i] =
            (float)(2 * (i / TILE_SIZE) + i % TILE_SIZE) + (float)(check_random_u64(&random) >> 61);
    codec_blob body;
    assert_int_equal(codec_height_encode_grid(rounded, 0, &body), OK);
    double bits = 8.0 * (double)body.size / SAMPLES;
    print_message("3 bits of noise on a plane: %.2f bits a sample\n", bits);
    assert_true(bits >= 3 && bits < 4.6); // the noise of three neighbours is in each difference
    codec_blob_deinit(&body);
}

// Fails when heights past the grid are cut off to fit.
static void heights_past_the_grid_stay_as_they_are(void **state)
{
    (void)state;
    make_heights(ROUGH, 1, true);
    rounded[9] = heights[9] = 0x1p23f / 64;
    codec_blob body;
    assert_int_equal(codec_height_encode_grid(rounded, -6, &body), OK);
    assert_false(grid_is_body(body.data, body.size));
    assert_int_equal(codec_height_decode(body.data, body.size, got), OK);
    for (int i = 0; i < SAMPLES; i++)
        assert_true(isfinite(heights[i]) ? got[i] == heights[i] : isnan(got[i]));
    codec_blob_deinit(&body);
}

// Fails when the choice is made before rounding.
static void one_value_after_rounding_takes_8_bytes(void **state)
{
    (void)state;
    for (int i = 0; i < SAMPLES; i++) rounded[i] = 70 + 0.001f * (float)(i % 5);
    codec_blob body;
    assert_int_equal(codec_height_encode_grid(rounded, -3, &body), OK);
    assert_int_equal(body.size, 8);
    assert_int_equal(codec_height_decode(body.data, body.size, got), OK);
    assert_true(got[0] == 70 && got[SAMPLES - 1] == 70);
    codec_blob_deinit(&body);
}

// The decoder sees a copy of just its size, so that a sanitizer sees every read past its end.
static status decode_copy(const unsigned char *data, size_t size)
{
    unsigned char *copy = malloc(size ? size : 1);
    memcpy(copy, data, size);
    status s = codec_height_decode(copy, size, got);
    free(copy);
    return s;
}

static codec_blob example(bool holes)
{
    make_heights(ROUGH, 1, holes);
    codec_blob body;
    assert_int_equal(codec_height_encode_grid(rounded, -4, &body), OK);
    return body;
}

// Fails when the count of decoded samples is not looked at.
static void truncated_bodies_are_refused(void **state)
{
    (void)state;
    for (int holes = 0; holes < 2; holes++) {
        codec_blob body = example(holes);
        for (size_t size = 0; size < body.size; size += 131)
            assert_int_equal(decode_copy(body.data, size), ERR_FORMAT);
        assert_int_equal(decode_copy(body.data, body.size - 2), ERR_FORMAT);
        codec_blob_deinit(&body);
    }
}

// Any flipped bit gives samples within the grid's limit or ERR_FORMAT, and nothing else. Fails,
// under a sanitizer, when the decoder reads past the body.
static void flipped_bits_are_survived(void **state)
{
    (void)state;
    struct check_random random = {9};
    int refused = 0;
    for (int holes = 0; holes < 2; holes++) {
        codec_blob body = example(holes);
        for (int k = 0; k < 900; k++) {
            size_t bit = k < 8 * 40 ? (size_t)k : check_random_u64(&random) % (8 * body.size);
            body.data[bit / 8] ^= (unsigned char)(1 << bit % 8);
            status s = decode_copy(body.data, body.size);
            assert_true(s == OK || s == ERR_FORMAT);
            for (int i = 0; !s && i < SAMPLES; i++)
                assert_true(isnan(got[i]) || fabsf(got[i]) < 0x1p31f);
            refused += s != OK;
            body.data[bit / 8] ^= (unsigned char)(1 << bit % 8);
        }
        codec_blob_deinit(&body);
    }
    assert_true(refused > 100);
}

// Fails when any of the head's fields is taken as it comes, or the limit is not looked at after
// decoding.
static void claims_of_the_head_are_not_believed(void **state)
{
    (void)state;
    static const struct {
        int at;
        unsigned char value;
    } claims[] = {{4, 0x80}, {4, 127}, {4, GRID_EXPONENT_MAX + 1},
                  {5, 0},    {5, 33},  {5, 255},
                  {6, 1},    {7, 1},   {8, 255},
                  {9, 255},  {11, 1},  {11, 255}};
    for (int holes = 0; holes < 2; holes++)
        for (size_t i = 0; i < sizeof claims / sizeof *claims; i++) {
            codec_blob body = example(holes);
            body.data[claims[i].at] = claims[i].value;
            assert_int_equal(decode_copy(body.data, body.size), ERR_FORMAT);
            codec_blob_deinit(&body);
        }
    // Counts that no float holds, coded in good order.
    static int32_t counts[SAMPLES];
    counts[77] = GRID_COUNT_LIMIT;
    codec_blob past;
    assert_int_equal(grid_encode(counts, 0, NULL, &past), OK);
    assert_int_equal(decode_copy(past.data, past.size), ERR_FORMAT);
    codec_blob_deinit(&past);
    // Noise behind a good head, as a body may hold where its checksum has been made to fit.
    struct check_random random = {13};
    for (int k = 0; k < 200; k++) {
        unsigned char noise[4000];
        for (size_t i = 0; i < sizeof noise; i++)
            noise[i] = (unsigned char)check_random_u64(&random);
        unsigned char head[HEAD] = {'P', 'G', 'L', '1', 0, (unsigned char)(1 + k % 32)};
        memcpy(noise, head, HEAD);
        status s = decode_copy(noise, sizeof noise);
        assert_true(s == OK || s == ERR_FORMAT);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nearest_multiples_come_back),
        cmocka_unit_test(size_is_near_the_entropy),
        cmocka_unit_test(heights_past_the_grid_stay_as_they_are),
        cmocka_unit_test(one_value_after_rounding_takes_8_bytes),
        cmocka_unit_test(truncated_bodies_are_refused),
        cmocka_unit_test(flipped_bits_are_survived),
        cmocka_unit_test(claims_of_the_head_are_not_believed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
