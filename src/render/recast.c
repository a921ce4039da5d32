#include "render/recast.h"

#include <stdio.h>
#include <stdlib.h>

#include "base/log.h"
#include "base/memory.h"
#include "gpu/context.h"
#include "gpu/program.h"

struct recast {
    window_shape shape;
    GLuint program, view; // sRGB is no format of images: its bits are
    GLenum format;
};

status recast_create(const recast_params *p, struct recast **out)
{
    struct recast *r = NEW(struct recast);
    char text[128];
    r->shape = p->shape;
    r->format = p->colors ? GL_R32UI : GL_R32F;
    gpu_context_forgive();
    glGenTextures(1, &r->view);
    glTextureView(r->view, GL_TEXTURE_2D_ARRAY, p->texture, r->format, 0, 1, 0, (GLuint)p->layers);
    snprintf(text, sizeof text, "%s#define COLUMNS %d\n%s", p->defines, p->shape.cols,
             p->colors ? "#define COLORS\n" : "");
    status s = gpu_program_create_compute("recast/recast.comp", text, &r->program);
    if (!s && glGetError() != GL_NO_ERROR) {
        log_error("the GPU does not show the terrain windows as images");
        s = ERR_GPU;
    }
    if (s) recast_destroy(&r);
    *out = r;
    return s;
}

void recast_destroy(struct recast **recast)
{
    struct recast *r = *recast;
    if (!r) return;
    glDeleteTextures(1, &r->view);
    if (r->program) glDeleteProgram(r->program);
    free(r);
    *recast = NULL;
}

static int64_t floor_half(int64_t a)
{
    return a / 2 - (a % 2 < 0);
}

void recast_make(const struct recast *r, const window *to, bool widens, window_rect valid)
{
    int rows = (int)(valid.row1 - valid.row0), cols = (int)(valid.col1 - valid.col0);
    int64_t source = widens ? 2 * valid.col0 : floor_half(valid.col0);
    glUseProgram(r->program);
    glBindImageTexture(0, r->view, 0, GL_TRUE, 0, GL_READ_WRITE, r->format);
    glUniform4i(0, window_texel(valid.row0, r->shape.rows), window_texel(valid.col0, r->shape.cols),
                rows, cols);
    glUniform3i(1, window_texel(source, r->shape.cols), !widens && valid.col0 - 2 * source, widens);
    glUniform1i(2, to->level);
    glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    glDispatchCompute((GLuint)rows, 1, 1);
    glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT |
                    GL_TEXTURE_UPDATE_BARRIER_BIT);
}
