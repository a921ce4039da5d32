// Tile bodies: round trips, and bodies broken in every way that a file may hold.
#include "check.h"

#include "planet/codec.h"

enum { SAMPLES = TILE_SIZE * TILE_SIZE };

static float heights[SAMPLES], got[SAMPLES];
static unsigned char pixels[SAMPLES * 3], got_pixels[SAMPLES * 3];

static void make_heights(bool rough)
{
    struct check_random random = {1};
    for (int i = 0; i < SAMPLES; i++) {
        double smooth = 1000.0 * sin(i / TILE_SIZE * 0.05) * cos(i % TILE_SIZE * 0.03);
        heights[i] = (float)(smooth + (rough ? check_random_range(&random, -1e4, 1e4) : 0.0));
    }
}

static void make_pixels(int channels)
{
    for (int i = 0; i < SAMPLES; i++)
        for (int c = 0; c < channels; c++)
            pixels[channels * i + c] = (unsigned char)(128 + 100 * sin(i / TILE_SIZE * 0.03 + c) *
                                                                 cos(i % TILE_SIZE * 0.04));
}

static void heights_round_trip(void **state)
{
    (void)state;
    for (int rough = 0; rough < 2; rough++) {
        make_heights(rough);
        heights[5] = NAN;
        heights[SAMPLES - 1] = NAN;
        heights[6] = -0.0f;
        heights[7] = 3e38f;
        heights[8] = 1e-40f;
        codec_blob body;
        assert_int_equal(codec_height_encode(heights, &body), OK);
        assert_true(body.size < SAMPLES * 4 + 2048); // what does not compress is stored as it is
        assert_int_equal(codec_height_decode(body.data, body.size, got), OK);
        for (int i = 0; i < SAMPLES; i++)
            assert_true(isnan(heights[i]) ? isnan(got[i]) : !memcmp(&heights[i], &got[i], 4));
        codec_blob_deinit(&body);
        assert_null(body.data);
    }
}

// One value throughout: bytes, not kilobytes, and exactly that value.
static void uniform_tiles_are_small(void **state)
{
    (void)state;
    static const float values[] = {0, -0.0f, 8848.86f, -1e-40f, 3e38f};
    codec_blob body;
    for (size_t k = 0; k < sizeof values / sizeof *values; k++) {
        for (int i = 0; i < SAMPLES; i++) heights[i] = values[k];
        assert_int_equal(codec_height_encode(heights, &body), OK);
        assert_int_equal(body.size, 8);
        assert_int_equal(codec_height_decode(body.data, body.size, got), OK);
        assert_memory_equal(heights, got, sizeof got);
        assert_int_equal(codec_pixels_decode(body.data, body.size, 1, got_pixels), ERR_FORMAT);
        body.data[0] ^= 1;
        assert_int_equal(codec_height_decode(body.data, body.size, got), ERR_FORMAT);
        codec_blob_deinit(&body);
    }
    heights[SAMPLES / 2] = 1;
    assert_int_equal(codec_height_encode(heights, &body), OK);
    assert_true(body.size > 100);
    codec_blob_deinit(&body);
    for (int channels = 1; channels <= 3; channels += 2) {
        for (int i = 0; i < SAMPLES * channels; i++)
            pixels[i] = (unsigned char)(37 + 50 * (i % channels));
        assert_int_equal(codec_pixels_encode(pixels, channels, 90, &body), OK);
        assert_int_equal(body.size, 8);
        assert_int_equal(codec_pixels_decode(body.data, body.size, channels, got_pixels), OK);
        assert_memory_equal(pixels, got_pixels, (size_t)SAMPLES * (size_t)channels);
        assert_int_equal(codec_pixels_decode(body.data, body.size, 4 - channels, got_pixels),
                         ERR_FORMAT);
        codec_blob_deinit(&body);
    }
    // A body from elsewhere with a height that is none.
    static const unsigned char nan_body[8] = {'P', 'G', 'U', '0', 0, 0, 0x80, 0x7f};
    assert_int_equal(codec_height_decode(nan_body, sizeof nan_body, got), OK);
    assert_true(isnan(got[0]));
}

static void infinities_become_nan(void **state)
{
    (void)state;
    make_heights(false);
    heights[0] = INFINITY;
    heights[1] = -INFINITY;
    codec_blob body;
    assert_int_equal(codec_height_encode(heights, &body), OK);
    assert_int_equal(codec_height_decode(body.data, body.size, got), OK);
    assert_true(isnan(got[0]) && isnan(got[1]) && got[2] == heights[2]);
    assert_true(isinf(heights[0])); // the caller's samples are left alone
    codec_blob_deinit(&body);
}

static void pixels_round_trip(void **state)
{
    (void)state;
    for (int channels = 1; channels <= 3; channels += 2)
        for (int quality = 75; quality <= 95; quality += 20) {
            make_pixels(channels);
            codec_blob body;
            assert_int_equal(codec_pixels_encode(pixels, channels, quality, &body), OK);
            assert_int_equal(codec_pixels_decode(body.data, body.size, channels, got_pixels), OK);
            double sum = 0.0;
            for (int i = 0; i < SAMPLES * channels; i++) sum += abs(pixels[i] - got_pixels[i]);
            assert_true(sum / (SAMPLES * channels) < 1.5); // measured 0.15 to 1.15
            codec_blob_deinit(&body);
        }
}

static void channels_are_not_mixed_up(void **state)
{
    (void)state;
    make_pixels(3);
    codec_blob color, night, height;
    assert_int_equal(codec_pixels_encode(pixels, 3, 90, &color), OK);
    assert_int_equal(codec_pixels_encode(pixels, 1, 90, &night), OK);
    make_heights(false);
    assert_int_equal(codec_height_encode(heights, &height), OK);
    assert_int_equal(codec_pixels_decode(color.data, color.size, 1, got_pixels), ERR_FORMAT);
    assert_int_equal(codec_pixels_decode(night.data, night.size, 3, got_pixels), ERR_FORMAT);
    assert_int_equal(codec_pixels_decode(height.data, height.size, 3, got_pixels), ERR_FORMAT);
    assert_int_equal(codec_height_decode(color.data, color.size, got), ERR_FORMAT);
    assert_int_equal(codec_height_decode("", 0, got), ERR_FORMAT);
    codec_blob_deinit(&color);
    codec_blob_deinit(&night);
    codec_blob_deinit(&height);
}

// Copies a body, so that a sanitizer sees every read past its end.
static unsigned char *copy_of(const codec_blob *body, size_t size)
{
    unsigned char *copy = malloc(size ? size : 1);
    memcpy(copy, body->data, size);
    return copy;
}

static void truncated_heights_are_refused(void **state)
{
    (void)state;
    make_heights(false);
    codec_blob body;
    assert_int_equal(codec_height_encode(heights, &body), OK);
    for (size_t size = 0; size < body.size; size += 97) {
        unsigned char *copy = copy_of(&body, size);
        assert_int_equal(codec_height_decode(copy, size, got), ERR_FORMAT);
        free(copy);
    }
    codec_blob_deinit(&body);
}

static void truncated_pixels_are_refused(void **state)
{
    (void)state;
    make_pixels(3);
    codec_blob body;
    assert_int_equal(codec_pixels_encode(pixels, 3, 90, &body), OK);
    // The end-of-image marker is the last two bytes.
    for (size_t size = 0; size < body.size - 2; size += 97) {
        unsigned char *copy = copy_of(&body, size);
        assert_int_equal(codec_pixels_decode(copy, size, 3, got_pixels), ERR_FORMAT);
        free(copy);
    }
    codec_blob_deinit(&body);
}

// Any flipped bit gives samples or ERR_FORMAT, nothing else. Every bit of the header, and bits
// spread over the rest.
static void flipped_bits_are_survived(void **state)
{
    (void)state;
    struct check_random random = {7};
    make_heights(false);
    make_pixels(3);
    codec_blob bodies[2];
    int refused[2] = {0};
    assert_int_equal(codec_height_encode(heights, &bodies[0]), OK);
    assert_int_equal(codec_pixels_encode(pixels, 3, 90, &bodies[1]), OK);
    for (int kind = 0; kind < 2; kind++)
        for (int k = 0; k < 500 * 8 + 300; k++) {
            size_t bit =
                k < 500 * 8 ? (size_t)k : check_random_u64(&random) % (bodies[kind].size * 8);
            if (k < 500 * 8 && k % 3 != kind) continue;
            unsigned char *copy = copy_of(&bodies[kind], bodies[kind].size);
            copy[bit / 8] ^= (unsigned char)(1 << bit % 8);
            status s = kind == 0 ? codec_height_decode(copy, bodies[kind].size, got)
                                 : codec_pixels_decode(copy, bodies[kind].size, 3, got_pixels);
            assert_true(s == OK || s == ERR_FORMAT);
            refused[kind] += s != OK;
            free(copy);
        }
    assert_true(refused[0] > 300 && refused[1] > 300);
    codec_blob_deinit(&bodies[0]);
    codec_blob_deinit(&bodies[1]);
}

// Headers that claim an image of another size are refused before anything is made of that size.
static void claims_of_size_are_not_believed(void **state)
{
    (void)state;
    make_heights(false);
    make_pixels(3);
    codec_blob body;
    assert_int_equal(codec_height_encode(heights, &body), OK);
    static const char name[] = "dataWindow\0box2i";
    unsigned char *at = memmem(body.data, body.size, name, sizeof name);
    assert_non_null(at);
    int32_t claims[] = {-1, 0, 254, 256, 65535, INT32_MAX - 1, INT32_MIN};
    for (size_t i = 0; i < sizeof claims / sizeof claims[0]; i++) {
        memcpy(at + sizeof name + 4 + 8, &claims[i], 4); // x of the far corner
        assert_int_equal(codec_height_decode(body.data, body.size, got), ERR_FORMAT);
    }
    codec_blob_deinit(&body);
    assert_int_equal(codec_pixels_encode(pixels, 3, 90, &body), OK);
    at = memmem(body.data, body.size, "\xff\xc0", 2); // start of frame: height at 5, width at 7
    assert_non_null(at);
    memset(at + 5, 0xff, 4);
    assert_int_equal(codec_pixels_decode(body.data, body.size, 3, got_pixels), ERR_FORMAT);
    codec_blob_deinit(&body);
    unsigned char *huge = calloc(1, 64 << 20);
    assert_int_equal(codec_height_decode(huge, 64 << 20, got), ERR_FORMAT);
    assert_int_equal(codec_pixels_decode(huge, 64 << 20, 3, got_pixels), ERR_FORMAT);
    free(huge);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(heights_round_trip),
        cmocka_unit_test(uniform_tiles_are_small),
        cmocka_unit_test(infinities_become_nan),
        cmocka_unit_test(pixels_round_trip),
        cmocka_unit_test(channels_are_not_mixed_up),
        cmocka_unit_test(truncated_heights_are_refused),
        cmocka_unit_test(truncated_pixels_are_refused),
        cmocka_unit_test(flipped_bits_are_survived),
        cmocka_unit_test(claims_of_size_are_not_believed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
