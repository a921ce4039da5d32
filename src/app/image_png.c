// libpng leaves a fault by longjmp: each function that calls it holds its own landing place and no
// other state.
#include "app/image_png.h"

#include <errno.h>
#include <png.h>
#include <setjmp.h>
#include <stdio.h>
#include <string.h>

#include "app/output_file.h"
#include "base/log.h"

enum { COMPRESSION_LEVEL = 4, MAX_TEXTS = 8 };

static void on_error(png_structp png, png_const_charp message)
{
    log_error("%s: %s", (const char *)png_get_error_ptr(png), message);
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp message)
{
    log_debug("%s: %s", (const char *)png_get_error_ptr(png), message);
}

// Reports the system's own reason, which libpng's stdio writer does not know.
static void write_bytes(png_structp png, png_bytep data, size_t size)
{
    if (fwrite(data, 1, size, png_get_io_ptr(png)) != size) png_error(png, strerror(errno));
}

static void flush_bytes(png_structp png)
{
    (void)png;
}

static void set_texts(png_structp png, png_infop info, const struct image_text *texts, int count)
{
    png_text out[MAX_TEXTS];
    memset(out, 0, sizeof out);
    if (count > MAX_TEXTS) count = MAX_TEXTS;
    for (int i = 0; i < count; i++) {
        bool ascii = true;
        for (const char *p = texts[i].text; *p; p++) ascii = ascii && (unsigned char)*p < 128;
        out[i].compression = ascii ? PNG_TEXT_COMPRESSION_NONE : PNG_ITXT_COMPRESSION_NONE;
        out[i].key = (png_charp)texts[i].keyword;
        out[i].text = (png_charp)texts[i].text;
    }
    png_set_text(png, info, out, count);
}

struct picture {
    int width, height;
    const uint8_t *rgb;
    const struct image_text *texts;
    int text_count;
};

static status encode(png_structp png, png_infop info, FILE *f, const struct picture *p)
{
    if (setjmp(png_jmpbuf(png))) return ERR_IO;
    png_set_write_fn(png, f, write_bytes, flush_bytes);
    png_set_compression_level(png, COMPRESSION_LEVEL);
    png_set_IHDR(png, info, (png_uint_32)p->width, (png_uint_32)p->height, 8, PNG_COLOR_TYPE_RGB,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB_gAMA_and_cHRM(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
    set_texts(png, info, p->texts, p->text_count);
    png_write_info(png, info);
    for (int y = 0; y < p->height; y++)
        png_write_row(png, p->rgb + (size_t)y * 3 * (size_t)p->width);
    png_write_end(png, info);
    return OK;
}

static status write_file(const char *path, const char *part, const struct picture *p)
{
    FILE *f = fopen(part, "wb");
    if (!f) {
        log_error("%s: cannot write: %s", path, strerror(errno));
        return ERR_IO;
    }
    png_structp png =
        png_create_write_struct(PNG_LIBPNG_VER_STRING, (void *)path, on_error, on_warning);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    status s = ERR_MEMORY;
    if (info) s = encode(png, info, f, p);
    else log_error("%s: out of memory", path);
    png_destroy_write_struct(&png, &info);
    if (fclose(f) != 0 && !s) {
        log_error("%s: cannot write: %s", path, strerror(errno));
        s = ERR_IO;
    }
    return s;
}

status image_png_write(const char *path, int width, int height, const uint8_t *rgb,
                       const struct image_text *texts, int text_count)
{
    struct picture p = {width, height, rgb, texts, text_count};
    char part[OUTPUT_PATH_SIZE];
    status s = output_part(path, part);
    if (s) return s;
    s = write_file(path, part, &p);
    if (!s) s = output_commit(path);
    if (s) output_discard(path);
    return s;
}

status image_png_size(const char *path, int *width, int *height)
{
    static const unsigned char start[16] = "\211PNG\r\n\032\n\0\0\0\rIHDR";
    unsigned char header[24];
    FILE *f = fopen(path, "rb");
    if (!f) return ERR_NOT_FOUND;
    size_t got = fread(header, 1, sizeof header, f);
    fclose(f);
    if (got != sizeof header || memcmp(header, start, sizeof start) != 0) return ERR_FORMAT;
    *width = (int)png_get_uint_32(header + 16);
    *height = (int)png_get_uint_32(header + 20);
    return OK;
}

static status decode(png_structp png, png_infop info, FILE *f, const char *path, int width,
                     int height, uint8_t *rgb)
{
    if (setjmp(png_jmpbuf(png))) return ERR_FORMAT;
    png_init_io(png, f);
    png_read_info(png, info);
    png_uint_32 w = png_get_image_width(png, info), h = png_get_image_height(png, info);
    if (w != (png_uint_32)width || h != (png_uint_32)height) {
        log_error("%s: %ux%u pixels, not %dx%d", path, (unsigned)w, (unsigned)h, width, height);
        return ERR_FORMAT;
    }
    png_set_expand(png);
    png_set_strip_16(png);
    png_set_strip_alpha(png);
    png_set_gray_to_rgb(png);
    int passes = png_set_interlace_handling(png);
    png_read_update_info(png, info);
    if (png_get_rowbytes(png, info) != 3 * (size_t)width) png_error(png, "not readable as RGB");
    for (int pass = 0; pass < passes; pass++)
        for (int y = 0; y < height; y++)
            png_read_row(png, rgb + (size_t)y * 3 * (size_t)width, NULL);
    png_read_end(png, NULL);
    return OK;
}

status image_png_read(const char *path, int width, int height, uint8_t *rgb)
{
    FILE *f = fopen(path, "rb");
    if (!f) {
        log_error("%s: cannot open: %s", path, strerror(errno));
        return errno == ENOENT ? ERR_NOT_FOUND : ERR_IO;
    }
    png_structp png =
        png_create_read_struct(PNG_LIBPNG_VER_STRING, (void *)path, on_error, on_warning);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    status s = ERR_MEMORY;
    if (info) s = decode(png, info, f, path, width, height, rgb);
    else log_error("%s: out of memory", path);
    png_destroy_read_struct(&png, &info, NULL);
    fclose(f);
    return s;
}
