#include "render/residuals.h"

#include <stdlib.h>

#include "base/log.h"
#include "base/memory.h"
#include "clipmap/residual.h"
#include "gpu/context.h"
#include "gpu/program.h"
#include "render/texture_array.h"

struct residuals {
    window_shape shape;
    GLuint texture, program; // of one strip
    size_t bytes;
};

status residuals_create(const window_shape *shape, const char *defines, struct residuals **out)
{
    struct residuals *r = NEW(struct residuals);
    const window_shape strip = {.rows = CLIPMAP_MAX_ROWS, .cols = shape->cols};
    gpu_context_forgive();
    r->shape = *shape;
    r->texture = texture_array(GL_R16I, &strip, 1, GL_NEAREST);
    r->bytes = texture_array_bytes(&strip, 1, 2);
    status s = gpu_program_create_compute("residual/add.comp", defines, &r->program);
    if (!s && glGetError() != GL_NO_ERROR) {
        log_error("the GPU refused %zu KiB for residuals", r->bytes >> 10);
        s = ERR_GPU;
    }
    if (s) residuals_destroy(&r);
    *out = r;
    return s;
}

void residuals_destroy(struct residuals **residuals)
{
    struct residuals *r = *residuals;
    if (!r) return;
    glDeleteTextures(1, &r->texture);
    if (r->program) glDeleteProgram(r->program);
    free(r);
    *residuals = NULL;
}

size_t residuals_gpu_bytes(const struct residuals *r)
{
    return r->bytes;
}

void residuals_add(struct residuals *r, struct gpu_upload *upload, GLuint heights,
                   const clipmap_strip *strip)
{
    const window_shape *shape = &r->shape;
    window_rect around = window_rect_parents(strip->rect);
    float quantum = clip_residual_quantum(strip->window.zoom);
    gpu_upload_texture(upload, r->texture, 0, 0, 0, strip->cols, strip->rows, GL_RED_INTEGER,
                       GL_SHORT, strip->residuals, strip->bytes);
    glUseProgram(r->program);
    glBindTextureUnit(0, heights);
    glBindTextureUnit(1, r->texture);
    glBindImageTexture(0, heights, 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R32F);
    glUniform4i(0, strip->tex_row, strip->tex_col, strip->rows, strip->cols);
    glUniform4i(1, window_texel(around.row0, shape->rows), window_texel(around.col0, shape->cols),
                (int)(strip->rect.row0 & 1), (int)(strip->rect.col0 & 1));
    glUniform1i(2, strip->level);
    glUniform2f(3, quantum, 1 / quantum);
    glDispatchCompute((GLuint)(strip->cols + 31) / 32, (GLuint)(strip->rows + 3) / 4, 1);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT);
}
