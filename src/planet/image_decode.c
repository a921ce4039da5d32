// One function a format, each: size first, then the pixels.
#include "planet/image_decode.h"

#include <png.h>
#include <stdio.h>
#include <string.h>
#include <turbojpeg.h>
#include <webp/decode.h>

static status wrong(char *why, const char *what)
{
    snprintf(why, IMAGE_WHY_SIZE, "%s", what);
    return ERR_FORMAT;
}

static status wrong_size(char *why, int width, int height, int size)
{
    snprintf(why, IMAGE_WHY_SIZE, "%d x %d pixels, not %d x %d", width, height, size, size);
    return ERR_FORMAT;
}

static status decode_jpeg(const void *data, size_t bytes, int size, uint8_t *rgba, char *why)
{
    tjhandle handle = tjInitDecompress();
    if (!handle) return ERR_MEMORY;
    int width = 0, height = 0, sampling, space;
    status s = OK;
    if (tjDecompressHeader3(handle, data, (unsigned long)bytes, &width, &height, &sampling, &space))
        s = wrong(why, "a broken JPEG");
    else if (width != size || height != size) s = wrong_size(why, width, height, size);
    // A warning is a body cut short or broken, which the library papers over.
    else if (tjDecompress2(handle, data, (unsigned long)bytes, rgba, size, 0, size, TJPF_RGBA,
                           TJFLAG_LIMITSCANS))
        s = wrong(why, "a broken JPEG");
    tjDestroy(handle);
    return s;
}

static status decode_png(const void *data, size_t bytes, int size, uint8_t *rgba, char *why)
{
    png_image image = {.version = PNG_IMAGE_VERSION};
    status s = OK;
    if (!png_image_begin_read_from_memory(&image, data, bytes)) {
        s = wrong(why, "a broken PNG");
    } else if (image.width != (png_uint_32)size || image.height != (png_uint_32)size) {
        s = wrong_size(why, (int)(image.width & 0xffffff), (int)(image.height & 0xffffff), size);
    } else {
        image.format = PNG_FORMAT_RGBA;
        if (!png_image_finish_read(&image, NULL, rgba, 0, NULL)) s = wrong(why, "a broken PNG");
    }
    png_image_free(&image);
    return s;
}

static status decode_webp(const void *data, size_t bytes, int size, uint8_t *rgba, char *why)
{
    int width, height;
    if (!WebPGetInfo(data, bytes, &width, &height)) return wrong(why, "a broken WebP");
    if (width != size || height != size) return wrong_size(why, width, height, size);
    size_t room = (size_t)size * (size_t)size * 4;
    if (!WebPDecodeRGBAInto(data, bytes, rgba, room, size * 4)) return wrong(why, "a broken WebP");
    return OK;
}

status image_decode(const void *data, size_t bytes, int size, uint8_t *rgba,
                    char why[IMAGE_WHY_SIZE])
{
    const uint8_t *b = data;
    if (bytes > 4 && memcmp(b, "\xff\xd8\xff", 3) == 0)
        return decode_jpeg(data, bytes, size, rgba, why);
    if (bytes > 8 && memcmp(b, "\x89PNG\r\n\x1a\n", 8) == 0)
        return decode_png(data, bytes, size, rgba, why);
    if (bytes > 12 && memcmp(b, "RIFF", 4) == 0 && memcmp(b + 8, "WEBP", 4) == 0)
        return decode_webp(data, bytes, size, rgba, why);
    return wrong(why, bytes ? "no JPEG, PNG or WebP" : "empty");
}
