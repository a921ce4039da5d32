// Images of tile servers, made here by the encoders of their formats: what comes out is what went
// in, and what is cut short, of another size or of no format is refused with its reason. Fails when
// a format is told by another's first bytes, when channels are exchanged, and when sizes are not
// looked at.
#include "planet/image_decode.h"

#include "check.h"

#include <turbojpeg.h>
#include <webp/encode.h>

enum { SIZE = 64, BYTES = SIZE * SIZE * 4 };

static uint8_t picture[BYTES], out[2 * BYTES];
static char why[IMAGE_WHY_SIZE];

static void paint(void)
{
    for (int i = 0; i < SIZE * SIZE; i++) {
        int x = i % SIZE, y = i / SIZE;
        const uint8_t rgba[4] = {(uint8_t)(3 * x), (uint8_t)(4 * y), (uint8_t)(x + y),
                                 (uint8_t)(255 - y)};
        memcpy(picture + 4 * i, rgba, 4);
    }
}

static void webp(void **state)
{
    (void)state;
    uint8_t *body = NULL;
    size_t bytes = WebPEncodeLosslessRGBA(picture, SIZE, SIZE, SIZE * 4, &body);
    assert_true(bytes > 0);
    assert_int_equal(image_decode(body, bytes, SIZE, out, why), OK);
    assert_memory_equal(out, picture, BYTES);
    assert_int_equal(image_decode(body, bytes, SIZE / 2, out, why), ERR_FORMAT);
    assert_string_equal(why, "64 x 64 pixels, not 32 x 32");
    assert_int_equal(image_decode(body, bytes / 2, SIZE, out, why), ERR_FORMAT);
    assert_string_equal(why, "a broken WebP");
    WebPFree(body);
}

static void jpeg(void **state)
{
    (void)state;
    unsigned char *body = NULL;
    unsigned long bytes = 0;
    tjhandle handle = tjInitCompress();
    assert_int_equal(
        tjCompress2(handle, picture, SIZE, 0, SIZE, TJPF_RGBA, &body, &bytes, TJSAMP_444, 98, 0),
        0);
    assert_int_equal(image_decode(body, bytes, SIZE, out, why), OK);
    for (int i = 0; i < BYTES; i++) check_near(out[i], i % 4 == 3 ? 255 : picture[i], 6);
    assert_int_equal(image_decode(body, bytes, SIZE / 2, out, why), ERR_FORMAT);
    assert_string_equal(why, "64 x 64 pixels, not 32 x 32");
    assert_int_equal(image_decode(body, bytes / 2, SIZE, out, why), ERR_FORMAT);
    assert_string_equal(why, "a broken JPEG");
    tjFree(body);
    tjDestroy(handle);
}

static void no_image(void **state)
{
    (void)state;
    assert_int_equal(image_decode("", 0, SIZE, out, why), ERR_FORMAT);
    assert_string_equal(why, "empty");
    assert_int_equal(image_decode("GIF89a and the rest", 19, SIZE, out, why), ERR_FORMAT);
    assert_string_equal(why, "no JPEG, PNG or WebP");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(webp),
        cmocka_unit_test(jpeg),
        cmocka_unit_test(no_image),
    };
    paint();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
