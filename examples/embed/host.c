#include "host.h"

#include <stdio.h>
#include <stdlib.h>

#include <epoxy/egl.h>
#include <epoxy/gl.h>

static EGLDisplay display = EGL_NO_DISPLAY;
static EGLContext context = EGL_NO_CONTEXT;
static int width, height;

static int make_context(void)
{
    static const EGLint config_wanted[] = {EGL_SURFACE_TYPE, EGL_DONT_CARE, EGL_RENDERABLE_TYPE,
                                           EGL_OPENGL_BIT, EGL_NONE};
    static const EGLint wanted[] = {EGL_CONTEXT_MAJOR_VERSION,
                                    4,
                                    EGL_CONTEXT_MINOR_VERSION,
                                    5,
                                    EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                    EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                    EGL_NONE};
    EGLConfig config;
    EGLint count = 0;
    display = eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL);
    if (!eglInitialize(display, NULL, NULL) || !eglBindAPI(EGL_OPENGL_API)) return 1;
    if (!eglChooseConfig(display, config_wanted, &config, 1, &count) || count == 0) return 1;
    context = eglCreateContext(display, config, EGL_NO_CONTEXT, wanted);
    return !eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context);
}

int host_start(int w, int h)
{
    if (make_context()) {
        fprintf(stderr, "embed: no OpenGL 4.5 context\n");
        return 1;
    }
    GLuint framebuffer, color;
    width = w;
    height = h;
    glCreateFramebuffers(1, &framebuffer);
    glCreateRenderbuffers(1, &color);
    glNamedRenderbufferStorage(color, GL_RGBA8, w, h);
    glNamedFramebufferRenderbuffer(framebuffer, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, color);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    return 0;
}

int host_lit_pixels(void)
{
    int lit = 0;
    unsigned char *rgba = malloc((size_t)width * (size_t)height * 4);
    if (!rgba) return -1;
    glReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, rgba);
    for (int i = 0; i < width * height; i++)
        lit += rgba[4 * i] || rgba[4 * i + 1] || rgba[4 * i + 2];
    free(rgba);
    return lit;
}

void host_stop(void)
{
    eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display, context);
    eglTerminate(display);
}
