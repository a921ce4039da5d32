#include "gpu/program.h"

#include <stdlib.h>

#include "base/log.h"
#include "base/memory.h"
#include "gpu/source.h"

enum { MESSAGE_SIZE = 800 };

static const char *shader_dir;

void gpu_program_set_dir(const char *dir)
{
    shader_dir = dir;
}

static void log_compile_error(GLuint shader, const char *entry, const struct source *source)
{
    GLint size = 0;
    glGetShaderiv(shader, GL_INFO_LOG_LENGTH, &size);
    char *text = NEW_ARRAY(char, (size_t)size + 1);
    glGetShaderInfoLog(shader, size + 1, NULL, text);
    char line[MESSAGE_SIZE];
    source_map_message(source, text, line, sizeof line);
    log_error("shader %s: %s", entry, line[0] ? line : "refused without a message");
    free(text);
}

static status compile(GLenum stage, const char *entry, const char *defines, GLuint *out)
{
    *out = 0;
    struct source source;
    status s = source_assemble(shader_dir, entry, defines, &source);
    if (s) return s;
    GLuint shader = glCreateShader(stage);
    const GLchar *text = source.text;
    glShaderSource(shader, 1, &text, NULL);
    glCompileShader(shader);
    GLint compiled = GL_FALSE;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    if (compiled) {
        *out = shader;
    } else {
        log_compile_error(shader, entry, &source);
        glDeleteShader(shader);
        s = ERR_GPU;
    }
    source_deinit(&source);
    return s;
}

static void log_link_error(GLuint program, const char *first, const char *second)
{
    GLint size = 0;
    glGetProgramiv(program, GL_INFO_LOG_LENGTH, &size);
    char *text = NEW_ARRAY(char, (size_t)size + 1);
    glGetProgramInfoLog(program, size + 1, NULL, text);
    char line[MESSAGE_SIZE];
    const struct source none = {0};
    source_map_message(&none, text, line, sizeof line);
    log_error("shader %s%s%s does not link: %s", first, second ? " + " : "", second ? second : "",
              line[0] ? line : "refused without a message");
    free(text);
}

// Takes the shaders: they are deleted either way.
static status link_take(const GLuint *shaders, int count, const char *first, const char *second,
                        GLuint *out)
{
    GLuint program = glCreateProgram();
    for (int i = 0; i < count; i++) glAttachShader(program, shaders[i]);
    glLinkProgram(program);
    for (int i = 0; i < count; i++) {
        glDetachShader(program, shaders[i]);
        glDeleteShader(shaders[i]);
    }
    GLint linked = GL_FALSE;
    glGetProgramiv(program, GL_LINK_STATUS, &linked);
    if (!linked) {
        log_link_error(program, first, second);
        glDeleteProgram(program);
        return ERR_GPU;
    }
    *out = program;
    return OK;
}

status gpu_program_create_render(const char *vert, const char *frag, const char *defines,
                                 GLuint *out)
{
    GLuint shaders[2];
    *out = 0;
    status s = compile(GL_VERTEX_SHADER, vert, defines, &shaders[0]);
    if (s) return s;
    s = compile(GL_FRAGMENT_SHADER, frag, defines, &shaders[1]);
    if (s) {
        glDeleteShader(shaders[0]);
        return s;
    }
    return link_take(shaders, 2, vert, frag, out);
}

status gpu_program_create_compute(const char *comp, const char *defines, GLuint *out)
{
    GLuint shader;
    *out = 0;
    status s = compile(GL_COMPUTE_SHADER, comp, defines, &shader);
    return s ? s : link_take(&shader, 1, comp, NULL, out);
}
