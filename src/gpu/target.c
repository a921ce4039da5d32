#include "gpu/target.h"

#include <assert.h>
#include <limits.h>
#include <stdbool.h>
#include <string.h>

#include "base/log.h"
#include "gpu/context.h"
#include "gpu/pixel_store.h"

static bool has_stencil(GLenum format)
{
    return format == GL_DEPTH24_STENCIL8 || format == GL_DEPTH32F_STENCIL8;
}

static GLuint make_texture(GLenum format, int width, int height)
{
    GLuint texture;
    glCreateTextures(GL_TEXTURE_2D, 1, &texture);
    glTextureStorage2D(texture, 1, format, width, height);
    glTextureParameteri(texture, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTextureParameteri(texture, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTextureParameteri(texture, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(texture, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    return texture;
}

static status check_size(int width, int height)
{
    GLint most = 0;
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
    if (width >= 1 && height >= 1 && width <= most && height <= most) return OK;
    log_error("no picture of %d x %d pixels: this OpenGL makes 1 to %d a side", width, height,
              most);
    return ERR_GPU;
}

static status check_complete(const gpu_target *t)
{
    GLenum error = glGetError();
    if (error == GL_OUT_OF_MEMORY) {
        log_error("no GPU memory for a picture of %d x %d pixels", t->width, t->height);
        return ERR_GPU;
    }
    GLenum state = glCheckNamedFramebufferStatus(t->framebuffer, GL_DRAW_FRAMEBUFFER);
    if (!error && state == GL_FRAMEBUFFER_COMPLETE) return OK;
    log_error("a framebuffer of %d x %d pixels is refused: status 0x%04x, error 0x%04x", t->width,
              t->height, state, error);
    return ERR_GPU;
}

status gpu_target_init(gpu_target *t, int width, int height, const GLenum *color_formats,
                       int color_count, GLenum depth_format)
{
    assert(color_count >= 0 && color_count <= GPU_TARGET_MAX_COLORS);
    *t = (gpu_target){.width = width, .height = height, .color_count = color_count};
    status s = check_size(width, height);
    if (s) return s;
    gpu_context_forgive();
    GLenum draw[GPU_TARGET_MAX_COLORS] = {GL_NONE};
    glCreateFramebuffers(1, &t->framebuffer);
    for (int i = 0; i < color_count; i++) {
        draw[i] = GL_COLOR_ATTACHMENT0 + (GLenum)i;
        t->colors[i] = make_texture(color_formats[i], width, height);
        glNamedFramebufferTexture(t->framebuffer, draw[i], t->colors[i], 0);
    }
    if (depth_format) {
        t->depth = make_texture(depth_format, width, height);
        GLenum point =
            has_stencil(depth_format) ? GL_DEPTH_STENCIL_ATTACHMENT : GL_DEPTH_ATTACHMENT;
        glNamedFramebufferTexture(t->framebuffer, point, t->depth, 0);
    }
    glNamedFramebufferDrawBuffers(t->framebuffer, color_count ? color_count : 1, draw);
    glNamedFramebufferReadBuffer(t->framebuffer, draw[0]);
    s = check_complete(t);
    if (s) gpu_target_deinit(t);
    return s;
}

void gpu_target_deinit(gpu_target *t)
{
    glDeleteFramebuffers(1, &t->framebuffer);
    glDeleteTextures(t->color_count, t->colors);
    glDeleteTextures(1, &t->depth);
    *t = (gpu_target){0};
}

static void swap_rows(unsigned char *a, unsigned char *b, size_t size)
{
    unsigned char chunk[4096];
    for (size_t at = 0; at < size; at += sizeof chunk) {
        size_t n = size - at < sizeof chunk ? size - at : sizeof chunk;
        memcpy(chunk, a + at, n);
        memcpy(a + at, b + at, n);
        memcpy(b + at, chunk, n);
    }
}

// GL counts rows from the bottom and the bytes of one read in an int: bands of rows, each turned
// over in its place.
void gpu_target_read(const gpu_target *t, GLuint texture, GLenum format, GLenum type,
                     size_t texel_bytes, void *pixels)
{
    size_t row = (size_t)t->width * texel_bytes;
    int band = row * (size_t)t->height <= INT_MAX ? t->height : (int)(INT_MAX / row);
    struct pixel_store saved;
    pixel_store_tight(&saved, PIXEL_PACK, 0);
    for (int y = 0; y < t->height; y += band) {
        int rows = t->height - y < band ? t->height - y : band;
        unsigned char *first = (unsigned char *)pixels + (size_t)(t->height - y - rows) * row;
        glGetTextureSubImage(texture, 0, 0, y, 0, t->width, rows, 1, format, type,
                             (GLsizei)((size_t)rows * row), first);
        for (int i = 0; i < rows / 2; i++)
            swap_rows(first + (size_t)i * row, first + (size_t)(rows - 1 - i) * row, row);
    }
    pixel_store_restore(&saved);
}
