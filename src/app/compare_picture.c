#include "app/compare_picture.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "app/camera_string.h"
#include "app/glyphs.h"
#include "app/image_png.h"
#include "base/log.h"
#include "base/vec.h"

enum {
    PANEL_MAX = 640,
    TEXT_MIN = 1000,
    MARGIN = 12,
    BAR_HEIGHT = 16,
    BAR_WIDTH = 420,
    SWATCH = 16
};

static const uint8_t INK[3] = {225, 228, 232}, DIM[3] = {150, 156, 165}, PAPER[3] = {24, 26, 30};

// By enum compare_kind; ground has the scale.
static const uint8_t KIND_COLORS[][3] = {
    {58, 64, 78}, {0, 0, 0}, {70, 112, 160}, {0, 255, 255}, {90, 220, 60}};

// Matplotlib's "inferno" (CC0), nine of its colours.
static const uint8_t SCALE[][3] = {{0, 0, 4},      {31, 12, 72},   {85, 15, 109},
                                   {136, 34, 106}, {186, 54, 85},  {227, 89, 51},
                                   {249, 140, 10}, {249, 201, 50}, {252, 255, 164}};

enum { SCALE_LAST = sizeof SCALE / sizeof SCALE[0] - 1 };

// Place on the scale of an error, in [0, 1].
static double scale_place(double px)
{
    double place =
        log(fmax(px, 1e-12) / COMPARE_SCALE_LOW) / log(COMPARE_SCALE_HIGH / COMPARE_SCALE_LOW);
    return clamp_double(place, 0, 1);
}

static void scale_color(double place, uint8_t rgb[3])
{
    double at = place * SCALE_LAST;
    int i = at >= SCALE_LAST ? SCALE_LAST - 1 : (int)at;
    for (int k = 0; k < 3; k++)
        rgb[k] = (uint8_t)lround(SCALE[i][k] + (at - i) * (SCALE[i + 1][k] - SCALE[i][k]));
}

static void map_color(enum compare_kind kind, double px, uint8_t rgb[3])
{
    if (kind == COMPARE_GROUND) scale_color(scale_place(fabs(px)), rgb);
    else memcpy(rgb, KIND_COLORS[kind], 3);
}

void compare_picture_map(const compare_maps *maps, int width, int height, uint8_t *rgb)
{
    for (size_t i = 0; i < (size_t)width * (size_t)height; i++)
        map_color((enum compare_kind)maps->kind[i], maps->geometric_px[i], rgb + 3 * i);
}

struct sheet {
    int width, height, shrink, panel_width, panel_height, left[3], top;
    uint8_t *rgb;
    struct glyphs *glyphs;
};

static void write_text(const struct sheet *s, int x, int y, const uint8_t color[3],
                       const char *text)
{
    glyphs_draw(s->glyphs, s->rgb, s->width, s->height, x, y, color, text);
}

static void fill(const struct sheet *s, int x, int y, int width, int height, const uint8_t rgb[3])
{
    for (int j = y < 0 ? 0 : y; j < y + height && j < s->height; j++)
        for (int i = x < 0 ? 0 : x; i < x + width && i < s->width; i++)
            memcpy(s->rgb + 3 * ((size_t)j * (size_t)s->width + (size_t)i), rgb, 3);
}

static uint8_t encode(double light)
{
    light = clamp_double(light, 0, 1);
    light = light <= 0.0031308 ? 12.92 * light : 1.055 * pow(light, 1 / 2.4) - 0.055;
    return (uint8_t)lround(255 * light);
}

// Mean of a block of a plane; a picture without colour shows its ground in one grey.
static void frame_color(const compare_picture *p, const struct sheet *s, int width, int x, int y,
                        uint8_t rgb[3])
{
    const float *const planes[3] = {p->r, p->g, p->b};
    for (int k = 0; k < 3; k++) {
        double sum = 0;
        for (int j = 0; j < s->shrink; j++)
            for (int i = 0; i < s->shrink; i++) {
                size_t at =
                    (size_t)(y * s->shrink + j) * (size_t)width + (size_t)(x * s->shrink + i);
                sum += planes[k] ? clamp_double(planes[k][at], 0, 1) : isnan(p->z_m[at]) ? 0 : 0.1;
            }
        rgb[k] = encode(sum / (s->shrink * s->shrink));
    }
}

// What is worse is shown: a hole before an extra pixel, before an error, before a silhouette.
static double badness(const compare_maps *m, size_t at)
{
    switch ((enum compare_kind)m->kind[at]) {
    case COMPARE_MISSING:
        return 4;
    case COMPARE_EXTRA:
        return 3;
    case COMPARE_GROUND:
        return 1 + scale_place(fabs((double)m->geometric_px[at]));
    case COMPARE_SILHOUETTE:
        return 0.5;
    default:
        return 0;
    }
}

static void error_color(const compare_maps *m, const struct sheet *s, int width, int x, int y,
                        uint8_t rgb[3])
{
    size_t worst = (size_t)(y * s->shrink) * (size_t)width + (size_t)(x * s->shrink);
    for (int j = 0; j < s->shrink; j++)
        for (int i = 0; i < s->shrink; i++) {
            size_t at = (size_t)(y * s->shrink + j) * (size_t)width + (size_t)(x * s->shrink + i);
            if (badness(m, at) > badness(m, worst)) worst = at;
        }
    map_color((enum compare_kind)m->kind[worst], m->geometric_px[worst], rgb);
}

static void draw_panels(const struct sheet *s, int width, const compare_picture *a,
                        const compare_picture *b, const compare_maps *maps)
{
    for (int y = 0; y < s->panel_height; y++)
        for (int x = 0; x < s->panel_width; x++)
            for (int k = 0; k < 3; k++) {
                uint8_t *to = s->rgb + 3 * ((size_t)(s->top + y) * (size_t)s->width +
                                            (size_t)(s->left[k] + x));
                if (k == 2) error_color(maps, s, width, x, y, to);
                else frame_color(k == 0 ? a : b, s, width, x, y, to);
            }
}

// A square of lines about the largest error.
static void mark_maximum(const struct sheet *s, const compare_stat *stat)
{
    static const uint8_t white[3] = {255, 255, 255};
    if (stat->count == 0 || stat->max < COMPARE_SCALE_LOW) return;
    int x = s->left[2] + stat->x / s->shrink, y = s->top + stat->y / s->shrink;
    for (int side = -1; side <= 1; side += 2) {
        fill(s, x - 7, y + 7 * side, 15, 1, white);
        fill(s, x + 7 * side, y - 7, 1, 15, white);
    }
}

static int draw_scale(const struct sheet *s, int y)
{
    static const double ticks[] = {0.001, 0.01, 0.1, 1, 10};
    int x = MARGIN, line = glyphs_height(s->glyphs);
    write_text(s, x, y, INK, "geometric error, px");
    y += line + 4;
    for (int i = 0; i < BAR_WIDTH; i++) {
        uint8_t rgb[3];
        scale_color((double)i / (BAR_WIDTH - 1), rgb);
        fill(s, x + i, y, 1, BAR_HEIGHT, rgb);
    }
    for (size_t i = 0; i < sizeof ticks / sizeof ticks[0]; i++) {
        char text[16];
        int at = x + (int)(scale_place(ticks[i]) * (BAR_WIDTH - 1));
        snprintf(text, sizeof text, "%g", ticks[i]);
        fill(s, at, y + BAR_HEIGHT, 1, 4, INK);
        int left = at - glyphs_width(s->glyphs, text) / 2;
        write_text(s, left < x ? x : left, y + BAR_HEIGHT + 5, INK, text);
    }
    static const enum compare_kind kinds[] = {COMPARE_SILHOUETTE, COMPARE_SKY, COMPARE_MISSING,
                                              COMPARE_EXTRA};
    static const char *const meanings[] = {"silhouette, told apart", "sky", "missing in a",
                                           "extra in a"};
    x += BAR_WIDTH + 3 * MARGIN;
    for (int i = 0; i < 4; i++) {
        fill(s, x, y, SWATCH, BAR_HEIGHT, KIND_COLORS[kinds[i]]);
        write_text(s, x + SWATCH + 6, y + 2, INK, meanings[i]);
        x += SWATCH + 6 + glyphs_width(s->glyphs, meanings[i]) + 2 * MARGIN;
    }
    return y + BAR_HEIGHT + 5 + 2 * line;
}

// A text, cut at a width.
static void write_fitting(const struct sheet *s, int x, int y, int width, char *text)
{
    size_t length = strlen(text);
    while (length > 0 && glyphs_width(s->glyphs, text) > width) text[--length] = '\0';
    write_text(s, x, y, INK, text);
}

static void draw_texts(const struct sheet *s, const compare_head *head, const compare_row *row)
{
    char text[2 * COMPARE_LINE_SIZE], camera[CAMERA_STRING_SIZE];
    char lines[COMPARE_LINES][COMPARE_LINE_SIZE];
    int line = glyphs_height(s->glyphs) + 3, y = MARGIN;
    camera_string_format(&row->camera, camera, sizeof camera);
    snprintf(text, sizeof text, "%.60s%s%d x %d px, camera %s", head->planet,
             head->planet[0] ? ", " : "", head->width, head->height, camera);
    write_text(s, MARGIN, y, INK, text);
    y = s->top - line;
    snprintf(text, sizeof text, "a: %.200s", head->a);
    write_fitting(s, s->left[0], y, s->panel_width, text);
    snprintf(text, sizeof text, "b: %.200s", head->b);
    write_fitting(s, s->left[1], y, s->panel_width, text);
    snprintf(text, sizeof text, "error (square: maximum)");
    write_fitting(s, s->left[2], y, s->panel_width, text);
    y = draw_scale(s, s->top + s->panel_height + MARGIN);
    int count = compare_report_lines(row, lines);
    for (int i = 0; i < count; i++, y += line) write_text(s, MARGIN, y, INK, lines[i]);
    if (row->result.colors) write_text(s, MARGIN, y, DIM, head->color_note);
}

static status sheet_init(struct sheet *s, int width, int height)
{
    *s = (struct sheet){.shrink = (width + PANEL_MAX - 1) / PANEL_MAX, .glyphs = glyphs_create(1)};
    int line = glyphs_height(s->glyphs) + 3;
    while (s->shrink > height) s->shrink--;
    s->panel_width = width / s->shrink;
    s->panel_height = height / s->shrink;
    for (int i = 0; i < 3; i++) s->left[i] = MARGIN + i * (s->panel_width + MARGIN);
    s->top = 2 * MARGIN + 2 * line;
    int wide = s->left[2] + s->panel_width + MARGIN;
    s->width = wide > TEXT_MIN ? wide : TEXT_MIN;
    s->height = s->top + s->panel_height + 4 * MARGIN + BAR_HEIGHT + (COMPARE_LINES + 3) * line;
    s->rgb = calloc((size_t)s->width * (size_t)s->height, 3);
    if (s->rgb) {
        fill(s, 0, 0, s->width, s->height, PAPER);
        return OK;
    }
    log_error("compare: out of memory for a picture of %d x %d", s->width, s->height);
    return ERR_MEMORY;
}

status compare_picture_write(const char *path, const compare_head *head, const compare_row *row,
                             const compare_picture *a, const compare_picture *b,
                             const compare_maps *maps)
{
    struct sheet s;
    static const struct image_text texts[] = {{"Software", "Perigee"}};
    status result = sheet_init(&s, head->width, head->height);
    if (!result) {
        draw_panels(&s, head->width, a, b, maps);
        mark_maximum(&s, &row->result.geometric_px);
        draw_texts(&s, head, row);
        result = image_png_write(path, s.width, s.height, s.rgb, texts, 1);
    }
    glyphs_destroy(&s.glyphs);
    free(s.rgb);
    return result;
}
