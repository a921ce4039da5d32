// GLSL programs from the files below shaders/. The loader alone writes #version, resolves #include
// "path" (each file once a program), and emits #line, so that compiler messages name file and line.
// Main only.
#ifndef PERIGEE_GPU_PROGRAM_H
#define PERIGEE_GPU_PROGRAM_H

#include <epoxy/gl.h>

#include "base/status.h"

// Reads shaders from this folder instead of the built-in copies; NULL: built-in again. The string
// is borrowed.
void gpu_program_set_dir(const char *dir);

// Compiles and links. `defines` is text put after #version ("#define A 1\n..."), or NULL. Logged:
// ERR_GPU with the compiler's first error, ERR_NOT_FOUND for a missing file with the line that
// asked for it, ERR_IO for one that cannot be read, ERR_FORMAT for an #include that cannot be
// followed. "Once a program" counts only includes that #if lets through.
status gpu_program_create_render(const char *vert, const char *frag, const char *defines,
                                 GLuint *out);
status gpu_program_create_compute(const char *comp, const char *defines, GLuint *out);

#endif
