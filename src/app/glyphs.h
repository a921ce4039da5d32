// Text in 8-bit RGB pictures, in the font that Dear ImGui brings. Main only.
#ifndef PERIGEE_APP_GLYPHS_H
#define PERIGEE_APP_GLYPHS_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

struct glyphs;

// The font, its pixels `scale` x `scale` large (1 to 4).
struct glyphs *glyphs_create(int scale);
void glyphs_destroy(struct glyphs **glyphs);

// Size of a line and of a text of Latin-1 letters in UTF-8, px.
int glyphs_height(const struct glyphs *glyphs);
int glyphs_width(const struct glyphs *glyphs, const char *text);

// Draws a line with its upper left corner at x, y; what lies outside is cut.
void glyphs_draw(const struct glyphs *glyphs, uint8_t *rgb, int width, int height, int x, int y,
                 const uint8_t color[3], const char *text);

#ifdef __cplusplus
}
#endif

#endif
