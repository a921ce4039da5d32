// Work for the GPU that lasts as long as one likes: full-screen draws of many arithmetic steps.
#ifndef PERIGEE_TESTS_BUSY_H
#define PERIGEE_TESTS_BUSY_H

#include <time.h>

#include "gpu/program.h"
#include "gpu/target.h"

struct busy {
    gpu_target target;
    GLuint program, vertices;
};

static inline double busy_now_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

static inline status busy_init(struct busy *b)
{
    const GLenum format = GL_RGBA8;
    glCreateVertexArrays(1, &b->vertices);
    gpu_program_set_dir(TEST_SHADER_DIR);
    status s =
        gpu_program_create_render("test/fullscreen.vert", "test/busy.frag", NULL, &b->program);
    return s ? s : gpu_target_init(&b->target, 256, 256, &format, 1, 0);
}

static inline void busy_draw(const struct busy *b, int rounds)
{
    glBindVertexArray(b->vertices);
    glBindFramebuffer(GL_FRAMEBUFFER, b->target.framebuffer);
    glViewport(0, 0, b->target.width, b->target.height);
    glUseProgram(b->program);
    glProgramUniform1i(b->program, 1, rounds);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

static inline void busy_deinit(struct busy *b)
{
    gpu_target_deinit(&b->target);
    glDeleteProgram(b->program);
    glDeleteVertexArrays(1, &b->vertices);
}

// Rounds that keep this GPU busy for about `ms`.
static inline int busy_rounds(const struct busy *b, double ms)
{
    for (int rounds = 16;; rounds *= 2) {
        busy_draw(b, rounds);
        glFinish();
        double start = busy_now_ms();
        busy_draw(b, rounds);
        glFinish();
        double took = busy_now_ms() - start;
        if (took > ms / 8 || rounds > 1 << 20) return (int)(rounds * ms / took) + 1;
    }
}

#endif
