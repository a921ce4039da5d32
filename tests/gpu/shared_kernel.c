#include "gpu/shared_kernel.h"

#include <stdio.h>

#include "gpu/program.h"

enum { LOCAL_SIZE = 64 };

#define FLOATS(type) ((unsigned)(sizeof(type) / sizeof(float)))

struct shared_inputs shared_inputs_of(const struct shared_case *c)
{
    struct shared_inputs in = {.n = c->n, .e = c->e, .v = c->v, .cb = c->cb, .sb = c->sb};
    in.r = c->r, in.lat = c->lat, in.stretch = c->stretch, in.dlat_db = c->dlat_db, in.w = c->w;
    in.h = c->h, in.place = c->place;
    return in;
}

static GLuint make_buffer(GLuint binding, size_t bytes, const void *data)
{
    GLuint buffer;
    glCreateBuffers(1, &buffer);
    glNamedBufferStorage(buffer, (GLsizeiptr)bytes, data, 0);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, buffer);
    return buffer;
}

status shared_kernel_run(const struct shared_inputs *in, struct shared_outputs *out, int count)
{
    char defines[80];
    GLuint program;
    snprintf(defines, sizeof defines, "#define INPUTS %uu\n#define OUTPUTS %uu\n",
             FLOATS(struct shared_inputs), FLOATS(struct shared_outputs));
    gpu_program_set_dir(TEST_SHADER_DIR);
    status s = gpu_program_create_compute("test/shared.comp", defines, &program);
    if (s) return s;
    GLuint from = make_buffer(0, (size_t)count * sizeof *in, in);
    GLuint to = make_buffer(1, (size_t)count * sizeof *out, NULL);
    glUseProgram(program);
    glProgramUniform1ui(program, 0, (GLuint)count);
    glDispatchCompute((GLuint)(count + LOCAL_SIZE - 1) / LOCAL_SIZE, 1, 1);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glGetNamedBufferSubData(to, 0, (GLsizeiptr)((size_t)count * sizeof *out), out);
    glDeleteProgram(program);
    glDeleteBuffers(1, &from);
    glDeleteBuffers(1, &to);
    return OK;
}
