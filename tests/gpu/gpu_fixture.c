#include "gpu/gpu_fixture.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <epoxy/gl.h>

#include "gpu/context.h"

enum { SKIPPED = 77 };

static struct gpu_context *context;
static int reported;

static void GLAPIENTRY count_message(GLenum source, GLenum type, GLuint id, GLenum severity,
                                     GLsizei length, const GLchar *message, const void *user)
{
    (void)source, (void)severity, (void)length, (void)user;
    if (type != GL_DEBUG_TYPE_ERROR) return;
    reported++;
    fprintf(stderr, "OpenGL error 0x%x: %s\n", id, message);
}

int gpu_fixture_open(void)
{
    setenv("PERIGEE_GL_DEBUG", "1", 0);
    gpu_tune_allocator();
    status s = gpu_context_create(&context);
    if (s == ERR_NOT_FOUND) fprintf(stderr, "skipped: there is no EGL here\n");
    if (s) return s == ERR_NOT_FOUND ? SKIPPED : EXIT_FAILURE;
    gpu_context_debug();
    glDebugMessageCallback(count_message, NULL);
    printf("%s, OpenGL %s\n", (const char *)glGetString(GL_RENDERER),
           (const char *)glGetString(GL_VERSION));
    return 0;
}

double gpu_fixture_snap_px(void)
{
    GLint bits = 0;
    glGetIntegerv(GL_SUBPIXEL_BITS, &bits);
    return strstr((const char *)glGetString(GL_RENDERER), "llvmpipe") ? 0
                                                                      : M_SQRT2 * ldexp(0.5, -bits);
}

void gpu_fixture_forgive(void)
{
    gpu_context_forgive();
    reported = 0;
}

int gpu_fixture_close(int rc)
{
    GLenum left = glGetError();
    if (left || reported)
        fprintf(stderr, "%d GL errors were reported, 0x%04x is left\n", reported, left);
    gpu_context_destroy(&context);
    return rc ? rc : left || reported ? EXIT_FAILURE : 0;
}
