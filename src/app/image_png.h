// 8-bit sRGB pictures as PNG. Any thread.
#ifndef PERIGEE_APP_IMAGE_PNG_H
#define PERIGEE_APP_IMAGE_PNG_H

#include <stdint.h>

#include "base/status.h"

// One text stored with a picture (keyword: 1-79 Latin characters; text: UTF-8).
struct image_text {
    const char *keyword, *text;
};

// rgb: 3 * width * height bytes, top row first. By way of PATH.part. The same input gives the same
// bytes. ERR_IO, logged with the path; nothing is left behind.
status image_png_write(const char *path, int width, int height, const uint8_t *rgb,
                       const struct image_text *texts, int text_count);

// Size of a PNG. ERR_NOT_FOUND, ERR_FORMAT silently: the caller asks whether it is there.
status image_png_size(const char *path, int *width, int *height);

// Reads any PNG of exactly this size as 8-bit RGB. ERR_NOT_FOUND, ERR_IO, ERR_FORMAT, logged with
// the path.
status image_png_read(const char *path, int width, int height, uint8_t *rgb);

#endif
