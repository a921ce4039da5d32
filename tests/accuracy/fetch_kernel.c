#include "fetch_kernel.h"

#include "gpu/program.h"

enum { LOCAL_SIZE = 64, LEVELS_BINDING = 1 };

static GLuint make_buffer(GLenum target, GLuint binding, size_t bytes, const void *data)
{
    GLuint buffer;
    glCreateBuffers(1, &buffer);
    glNamedBufferStorage(buffer, (GLsizeiptr)bytes, data, 0);
    glBindBufferBase(target, binding, buffer);
    return buffer;
}

// As src/render/windows.c makes it.
static GLuint make_texture(const float *heights)
{
    GLuint t;
    glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &t);
    glTextureStorage3D(t, 1, GL_R32F, FETCH_COLUMNS, FETCH_ROWS, FETCH_LEVELS);
    glTextureSubImage3D(t, 0, 0, 0, 0, FETCH_COLUMNS, FETCH_ROWS, FETCH_LEVELS, GL_RED, GL_FLOAT,
                        heights);
    glTextureParameteri(t, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureParameteri(t, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(t, GL_TEXTURE_WRAP_S, GL_REPEAT);
    glTextureParameteri(t, GL_TEXTURE_WRAP_T, GL_REPEAT);
    glBindTextureUnit(0, t);
    return t;
}

status fetch_kernel_run(const float *heights, const struct levels_block *levels,
                        const char *defines, const struct fetch_case *cases,
                        struct fetch_result *results, int count)
{
    size_t n = (size_t)count;
    GLuint program;
    gpu_program_set_dir(ACCURACY_SHADER_DIR);
    status s = gpu_program_create_compute("accuracy/fetch.comp", defines, &program);
    if (s) return s;
    GLuint buffers[3], texture = make_texture(heights);
    buffers[0] = make_buffer(GL_SHADER_STORAGE_BUFFER, 0, n * sizeof *cases, cases);
    buffers[1] = make_buffer(GL_SHADER_STORAGE_BUFFER, 1, n * sizeof *results, NULL);
    buffers[2] = make_buffer(GL_UNIFORM_BUFFER, LEVELS_BINDING, sizeof *levels, levels);
    glUseProgram(program);
    glProgramUniform1ui(program, 0, (GLuint)count);
    glDispatchCompute((GLuint)(count + LOCAL_SIZE - 1) / LOCAL_SIZE, 1, 1);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glGetNamedBufferSubData(buffers[1], 0, (GLsizeiptr)(n * sizeof *results), results);
    glDeleteBuffers(3, buffers);
    glDeleteTextures(1, &texture);
    glDeleteProgram(program);
    return OK;
}
