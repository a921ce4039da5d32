#include "gpu/split.h"

#include "gpu/program.h"

status gpu_split_init(gpu_split *s)
{
    *s = (gpu_split){0};
    status result =
        gpu_program_create_render("shade/fullscreen.vert", "split/split.frag", NULL, &s->program);
    if (!result) glCreateVertexArrays(1, &s->empty_array);
    return result;
}

void gpu_split_deinit(gpu_split *s)
{
    for (int i = 0; i < 2; i++) gpu_target_deinit(&s->pictures[i]);
    if (s->program) glDeleteProgram(s->program);
    glDeleteVertexArrays(1, &s->empty_array);
    *s = (gpu_split){0};
}

status gpu_split_resize(gpu_split *s, int width, int height)
{
    const gpu_target *have = &s->pictures[1];
    const GLenum format = GL_RGBA8;
    if (have->framebuffer && have->width == width && have->height == height) return OK;
    status result = OK;
    for (int i = 0; i < 2; i++) {
        gpu_target_deinit(&s->pictures[i]);
        if (!result) result = gpu_target_init(&s->pictures[i], width, height, &format, 1, 0);
    }
    return result;
}

void gpu_split_draw(const gpu_split *s, GLuint framebuffer, int difference_px, float gain)
{
    int width = s->pictures[0].width, height = s->pictures[0].height;
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glViewport(0, 0, width, height);
    glDisable(GL_BLEND);
    glDisable(GL_CULL_FACE);
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_STENCIL_TEST);
    glDisable(GL_FRAMEBUFFER_SRGB);
    glBindTextureUnit(0, s->pictures[0].colors[0]);
    glBindTextureUnit(1, s->pictures[1].colors[0]);
    glProgramUniform2i(s->program, 0, width / 2, difference_px);
    glProgramUniform1f(s->program, 1, gain);
    glUseProgram(s->program);
    glBindVertexArray(s->empty_array);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glBindVertexArray(0);
    glUseProgram(0); // nobody may find it in use when it is gone
}

status gpu_split_read(const gpu_split *s, int difference_px, float gain, void *rgb)
{
    gpu_target t;
    const GLenum format = GL_RGBA8;
    GLint bound = 0;
    status result = gpu_target_init(&t, s->pictures[0].width, s->pictures[0].height, &format, 1, 0);
    if (result) return result;
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &bound);
    gpu_split_draw(s, t.framebuffer, difference_px, gain);
    gpu_target_read(&t, t.colors[0], GL_RGB, GL_UNSIGNED_BYTE, 3, rgb);
    glBindFramebuffer(GL_FRAMEBUFFER, (GLuint)bound);
    gpu_target_deinit(&t);
    return OK;
}
