// The atlas is built and read on the CPU; no ImGui context and no GL is needed for it.
#include "app/glyphs.h"

#include <imgui.h>

struct glyphs {
    ImFontAtlas atlas;
    ImFont *font;
    unsigned char *alpha;
    int width, height, scale;
};

namespace
{

// The next letter of UTF-8 text of at most two bytes a letter; 0 at the end.
unsigned next_letter(const char **text)
{
    unsigned c = (unsigned char)**text;
    if (c) ++*text;
    if (c < 0xc2 || c > 0xdf || ((unsigned char)**text & 0xc0) != 0x80) return c;
    unsigned low = (unsigned char)*(*text)++ & 0x3f;
    return (c & 0x1f) << 6 | low;
}

void blend(uint8_t *pixel, const uint8_t color[3], int alpha)
{
    for (int i = 0; i < 3; i++)
        pixel[i] = (uint8_t)((pixel[i] * (255 - alpha) + color[i] * alpha + 127) / 255);
}

void draw_glyph(const glyphs *g, const ImFontGlyph *glyph, uint8_t *rgb, int width, int height,
                int x, int y, const uint8_t color[3])
{
    int u = (int)(glyph->U0 * (float)g->width + 0.5F),
        v = (int)(glyph->V0 * (float)g->height + 0.5F);
    int left = x + (int)glyph->X0 * g->scale, top = y + (int)glyph->Y0 * g->scale;
    int across = (int)(glyph->X1 - glyph->X0) * g->scale,
        down = (int)(glyph->Y1 - glyph->Y0) * g->scale;
    for (int j = 0; j < down; j++)
        for (int i = 0; i < across; i++) {
            int px = left + i, py = top + j;
            if (px < 0 || py < 0 || px >= width || py >= height) continue;
            int alpha = g->alpha[(v + j / g->scale) * g->width + u + i / g->scale];
            blend(rgb + 3 * ((size_t)py * (size_t)width + (size_t)px), color, alpha);
        }
}

} // namespace

extern "C" struct glyphs *glyphs_create(int scale)
{
    glyphs *g = new glyphs;
    g->scale = scale;
    g->font = g->atlas.AddFontDefault();
    g->atlas.GetTexDataAsAlpha8(&g->alpha, &g->width, &g->height);
    return g;
}

extern "C" void glyphs_destroy(struct glyphs **g)
{
    delete *g;
    *g = nullptr;
}

extern "C" int glyphs_height(const struct glyphs *g)
{
    return (int)g->font->FontSize * g->scale;
}

extern "C" int glyphs_width(const struct glyphs *g, const char *text)
{
    int width = 0;
    for (unsigned c = next_letter(&text); c; c = next_letter(&text))
        width += (int)g->font->FindGlyph((ImWchar)c)->AdvanceX * g->scale;
    return width;
}

extern "C" void glyphs_draw(const struct glyphs *g, uint8_t *rgb, int width, int height, int x,
                            int y, const uint8_t color[3], const char *text)
{
    for (unsigned c = next_letter(&text); c; c = next_letter(&text)) {
        const ImFontGlyph *glyph = g->font->FindGlyph((ImWchar)c);
        if (glyph->Visible) draw_glyph(g, glyph, rgb, width, height, x, y, color);
        x += (int)glyph->AdvanceX * g->scale;
    }
}
