#include "app/contact_sheet.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

enum { MARGIN = 4, BACKGROUND = 32 };

struct contact_sheet {
    int cells, columns, rows;
    int cell_width, cell_height;
    int frame_width, frame_height, frame_count;
    int width, height;
    float linear[256];
    uint8_t *pixels;
};

static float linear_from_srgb(int code)
{
    double c = code / 255.0;
    return (float)(c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4));
}

static uint8_t srgb_from_linear(double light)
{
    double c = light <= 0.0031308 ? 12.92 * light : 1.055 * pow(light, 1 / 2.4) - 0.055;
    return (uint8_t)lround(255 * c);
}

struct contact_sheet *contact_sheet_create(int columns, int rows, int cell_width, int frame_width,
                                           int frame_height, int frame_count)
{
    struct contact_sheet *s = NEW(struct contact_sheet);
    s->cells = columns * rows < frame_count ? columns * rows : frame_count;
    s->columns = columns < s->cells ? columns : s->cells;
    s->rows = (s->cells + s->columns - 1) / s->columns;
    s->cell_width = cell_width < frame_width ? cell_width : frame_width;
    s->cell_height = (int)lround((double)s->cell_width * frame_height / frame_width);
    if (s->cell_height < 1) s->cell_height = 1;
    s->frame_width = frame_width;
    s->frame_height = frame_height;
    s->frame_count = frame_count;
    s->width = MARGIN + s->columns * (s->cell_width + MARGIN);
    s->height = MARGIN + s->rows * (s->cell_height + MARGIN);
    for (int i = 0; i < 256; i++) s->linear[i] = linear_from_srgb(i);
    size_t bytes = 3 * (size_t)s->width * (size_t)s->height;
    s->pixels = NEW_ARRAY(uint8_t, bytes);
    memset(s->pixels, BACKGROUND, bytes);
    return s;
}

void contact_sheet_destroy(struct contact_sheet **sheet)
{
    if (!*sheet) return;
    free((*sheet)->pixels);
    free(*sheet);
    *sheet = NULL;
}

static int frame_of_cell(const struct contact_sheet *s, int cell)
{
    if (s->cells == 1) return 0;
    return (int)lround((double)cell * (s->frame_count - 1) / (s->cells - 1));
}

// The cell that shows this frame, or -1.
static int cell_of_frame(const struct contact_sheet *s, int frame)
{
    for (int cell = 0; cell < s->cells; cell++)
        if (frame_of_cell(s, cell) == frame) return cell;
    return -1;
}

bool contact_sheet_wants(const struct contact_sheet *s, int frame)
{
    return cell_of_frame(s, frame) >= 0;
}

// The source pixels [first, last) that target pixel i of `count` covers, at least one.
static void cover(int i, int count, int source, int *first, int *last)
{
    *first = (int)((long long)i * source / count);
    *last = (int)((long long)(i + 1) * source / count);
    if (*last <= *first) *last = *first + 1;
}

static void average(const struct contact_sheet *s, const uint8_t *rgb, int x, int y, uint8_t out[3])
{
    int x0, x1, y0, y1;
    cover(x, s->cell_width, s->frame_width, &x0, &x1);
    cover(y, s->cell_height, s->frame_height, &y0, &y1);
    double sum[3] = {0, 0, 0};
    for (int v = y0; v < y1; v++) {
        const uint8_t *p = rgb + 3 * ((size_t)v * (size_t)s->frame_width + (size_t)x0);
        for (int u = x0; u < x1; u++, p += 3)
            for (int c = 0; c < 3; c++) sum[c] += (double)s->linear[p[c]];
    }
    for (int c = 0; c < 3; c++) out[c] = srgb_from_linear(sum[c] / ((x1 - x0) * (y1 - y0)));
}

void contact_sheet_add(struct contact_sheet *s, int frame, const uint8_t *rgb)
{
    int cell = cell_of_frame(s, frame);
    if (cell < 0) return;
    int left = MARGIN + cell % s->columns * (s->cell_width + MARGIN);
    int top = MARGIN + cell / s->columns * (s->cell_height + MARGIN);
    for (int y = 0; y < s->cell_height; y++) {
        uint8_t *row = s->pixels + 3 * ((size_t)(top + y) * (size_t)s->width + (size_t)left);
        for (int x = 0; x < s->cell_width; x++) average(s, rgb, x, y, row + 3 * x);
    }
}

void contact_sheet_size(const struct contact_sheet *s, int *width, int *height)
{
    *width = s->width;
    *height = s->height;
}

const uint8_t *contact_sheet_pixels(const struct contact_sheet *s)
{
    return s->pixels;
}
