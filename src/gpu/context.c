// One EGL display, tried in the order: real GPUs (EGL devices that are not software), Mesa's
// surfaceless platform, the default display, software devices. The first that gives an OpenGL 4.5
// core context is taken; PERIGEE_EGL_DEVICE=N narrows the choice to the N-th EGL device,
// PERIGEE_GL_DEBUG=1 asks for a debug context.
#include "gpu/context.h"

#include <assert.h>
#include <dlfcn.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <epoxy/egl.h>
#include <epoxy/gl.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "base/log.h"
#include "base/memory.h"

enum { MAX_DEVICES = 32, REASON_SIZE = 400, GL_NEEDED = 45 };

struct gpu_context {
    EGLDisplay display;
    EGLContext context;
    EGLSurface surface;       // EGL_NO_SURFACE where the display can do without
    char reason[REASON_SIZE]; // why the last display that got furthest was refused
};

static bool has_word(const char *list, const char *word)
{
    size_t length = strlen(word);
    for (const char *p = list ? strstr(list, word) : NULL; p; p = strstr(p + length, word))
        if ((p == list || p[-1] == ' ') && (p[length] == ' ' || p[length] == 0)) return true;
    return false;
}

static bool env_is_set(const char *name)
{
    const char *value = getenv(name);
    return value && value[0] && strcmp(value, "0") != 0;
}

static void close_display(struct gpu_context *c)
{
    if (c->display == EGL_NO_DISPLAY) return;
    eglMakeCurrent(c->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (c->surface != EGL_NO_SURFACE) eglDestroySurface(c->display, c->surface);
    if (c->context != EGL_NO_CONTEXT) eglDestroyContext(c->display, c->context);
    eglTerminate(c->display);
    c->display = EGL_NO_DISPLAY;
    c->context = EGL_NO_CONTEXT;
    c->surface = EGL_NO_SURFACE;
}

// A context of at least `version` (0: whatever the driver gives), current on return.
static bool make_current(struct gpu_context *c, int version)
{
    const char *extensions = eglQueryString(c->display, EGL_EXTENSIONS);
    bool surfaceless = has_word(extensions, "EGL_KHR_surfaceless_context");
    EGLConfig config = EGL_NO_CONFIG_KHR;
    if (!surfaceless || !has_word(extensions, "EGL_KHR_no_config_context")) {
        const EGLint wanted[] = {EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_SURFACE_TYPE,
                                 surfaceless ? 0 : EGL_PBUFFER_BIT, EGL_NONE};
        EGLint count = 0;
        if (!eglChooseConfig(c->display, wanted, &config, 1, &count) || count < 1) return false;
    }
    const EGLint core[] = {EGL_CONTEXT_MAJOR_VERSION,
                           version / 10,
                           EGL_CONTEXT_MINOR_VERSION,
                           version % 10,
                           EGL_CONTEXT_OPENGL_PROFILE_MASK,
                           EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                           EGL_CONTEXT_OPENGL_DEBUG,
                           env_is_set("PERIGEE_GL_DEBUG"),
                           EGL_NONE};
    const EGLint any[] = {EGL_NONE};
    c->context = eglCreateContext(c->display, config, EGL_NO_CONTEXT, version ? core : any);
    if (c->context == EGL_NO_CONTEXT) return false;
    if (!surfaceless) {
        const EGLint size[] = {EGL_WIDTH, 1, EGL_HEIGHT, 1, EGL_NONE};
        c->surface = eglCreatePbufferSurface(c->display, config, size);
    }
    return eglMakeCurrent(c->display, c->surface, c->surface, c->context);
}

// Takes the display or closes it again, leaving the reason.
static bool try_display(struct gpu_context *c, EGLDisplay display)
{
    if (display == EGL_NO_DISPLAY) return false;
    c->display = display;
    if (!eglInitialize(display, NULL, NULL)) {
        c->display = EGL_NO_DISPLAY;
        return false;
    }
    if (eglBindAPI(EGL_OPENGL_API) && make_current(c, GL_NEEDED)) return true;
    close_display(c);
    c->display = display;
    if (eglInitialize(display, NULL, NULL) && eglBindAPI(EGL_OPENGL_API) && make_current(c, 0))
        snprintf(c->reason, sizeof c->reason, "%s offers only OpenGL %s",
                 (const char *)glGetString(GL_RENDERER), (const char *)glGetString(GL_VERSION));
    else if (!c->reason[0])
        snprintf(c->reason, sizeof c->reason, "%s offers no OpenGL (EGL error 0x%04x)",
                 eglQueryString(display, EGL_VENDOR), (unsigned)eglGetError());
    close_display(c);
    return false;
}

static EGLDisplay platform_display(EGLenum platform, void *native)
{
    PFNEGLGETPLATFORMDISPLAYEXTPROC get =
        (PFNEGLGETPLATFORMDISPLAYEXTPROC)eglGetProcAddress("eglGetPlatformDisplayEXT");
    return get ? get(platform, native, NULL) : EGL_NO_DISPLAY;
}

static int list_devices(const char *client, EGLDeviceEXT *devices)
{
    PFNEGLQUERYDEVICESEXTPROC query =
        (PFNEGLQUERYDEVICESEXTPROC)eglGetProcAddress("eglQueryDevicesEXT");
    EGLint count = 0;
    if (!query || !has_word(client, "EGL_EXT_platform_device") ||
        !query(MAX_DEVICES, devices, &count))
        return 0;
    return count;
}

static bool try_devices(struct gpu_context *c, const EGLDeviceEXT *devices, int count,
                        bool software)
{
    PFNEGLQUERYDEVICESTRINGEXTPROC query =
        (PFNEGLQUERYDEVICESTRINGEXTPROC)eglGetProcAddress("eglQueryDeviceStringEXT");
    for (int i = 0; query && i < count; i++) {
        const char *extensions = query(devices[i], EGL_EXTENSIONS);
        if (has_word(extensions, "EGL_MESA_device_software") != software) continue;
        if (try_display(c, platform_display(EGL_PLATFORM_DEVICE_EXT, devices[i]))) return true;
    }
    return false;
}

static status open_chosen_device(struct gpu_context *c, const EGLDeviceEXT *devices, int count,
                                 const char *chosen)
{
    char *end;
    long index = strtol(chosen, &end, 10);
    if (end == chosen || *end || index < 0 || index >= count) {
        log_error("PERIGEE_EGL_DEVICE=%s: there are %d EGL devices, counted from 0", chosen, count);
        return ERR_GPU;
    }
    if (try_display(c, platform_display(EGL_PLATFORM_DEVICE_EXT, devices[index]))) return OK;
    log_error("PERIGEE_EGL_DEVICE=%s: no OpenGL 4.5 core: %s", chosen,
              c->reason[0] ? c->reason : "the device cannot be opened");
    return ERR_GPU;
}

static status open_any(struct gpu_context *c)
{
    void *library = dlopen("libEGL.so.1",
                           RTLD_LAZY); // stays open: libepoxy ends the process where it is missing
    if (!library) {
        log_error("no EGL: the library libEGL.so.1 is not installed");
        return ERR_NOT_FOUND;
    }
    const char *client = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    EGLDeviceEXT devices[MAX_DEVICES];
    int count = list_devices(client, devices);
    const char *chosen = getenv("PERIGEE_EGL_DEVICE");
    if (chosen && chosen[0]) return open_chosen_device(c, devices, count, chosen);
    if (try_devices(c, devices, count, false)) return OK;
    if (has_word(client, "EGL_MESA_platform_surfaceless") &&
        try_display(c, platform_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY)))
        return OK;
    if (try_display(c, eglGetDisplay(EGL_DEFAULT_DISPLAY))) return OK;
    if (try_devices(c, devices, count, true)) return OK;
    if (!c->reason[0]) {
        log_error("no EGL display: neither a GPU nor Mesa's software driver can be opened");
        return ERR_NOT_FOUND;
    }
    log_error("no OpenGL 4.5 core: %s", c->reason);
    return ERR_GPU;
}

status gpu_context_create(struct gpu_context **out)
{
    struct gpu_context *c = NEW(struct gpu_context);
    c->display = EGL_NO_DISPLAY;
    c->context = EGL_NO_CONTEXT;
    c->surface = EGL_NO_SURFACE;
    status s = open_any(c);
    if (!s) s = gpu_context_check();
    if (s) gpu_context_destroy(&c);
    *out = c;
    return s;
}

void gpu_context_destroy(struct gpu_context **context)
{
    if (!*context) return;
    close_display(*context);
    free(*context);
    *context = NULL;
}

static bool library_has_current(const char *library, const char *function)
{
    void *handle = dlopen(library, RTLD_LAZY | RTLD_NOLOAD);
    if (!handle) return false;
    void *(*current)(void) = NULL;
    *(void **)&current = dlsym(handle, function);
    bool is_current = current && current();
    dlclose(handle);
    return is_current;
}

// libepoxy ends the process when it is asked for a function while nothing is current, so ask the
// window systems first.
static bool any_context_is_current(void)
{
    return library_has_current("libEGL.so.1", "eglGetCurrentContext") ||
           library_has_current("libGL.so.1", "glXGetCurrentContext") ||
           library_has_current("libGLX.so.0", "glXGetCurrentContext");
}

status gpu_context_check(void)
{
    if (!any_context_is_current()) {
        log_error("no OpenGL context is current on this thread");
        return ERR_GPU;
    }
    if (!epoxy_is_desktop_gl() || epoxy_gl_version() < GL_NEEDED) {
        log_error("no OpenGL 4.5 core: %s offers only %s", (const char *)glGetString(GL_RENDERER),
                  (const char *)glGetString(GL_VERSION));
        return ERR_GPU;
    }
    return OK;
}

static void GLAPIENTRY log_message(GLenum source, GLenum type, GLuint id, GLenum severity,
                                   GLsizei length, const GLchar *message, const void *user)
{
    (void)source, (void)severity, (void)length, (void)user;
    log_warn("OpenGL %s 0x%x: %s", type == GL_DEBUG_TYPE_ERROR ? "error" : "message", id, message);
}

void gpu_context_debug(void)
{
    GLint flags = 0;
    glGetIntegerv(GL_CONTEXT_FLAGS, &flags);
    if (!(flags & GL_CONTEXT_FLAG_DEBUG_BIT)) return;
    glEnable(GL_DEBUG_OUTPUT);
    glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
    glDebugMessageControl(GL_DONT_CARE, GL_DONT_CARE, GL_DONT_CARE, 0, NULL, GL_FALSE);
    glDebugMessageControl(GL_DONT_CARE, GL_DONT_CARE, GL_DEBUG_SEVERITY_HIGH, 0, NULL, GL_TRUE);
    glDebugMessageCallback(log_message, NULL);
}

void gpu_context_forgive(void)
{
    enum { MOST = 16 };
    for (int i = 0; i < MOST && glGetError() != GL_NO_ERROR;) i++;
}

void gpu_tune_allocator(void)
{
#ifdef __GLIBC__
    enum { MIB = 1 << 20 };
    mallopt(M_MMAP_THRESHOLD, 32 * MIB); // the largest that glibc takes
    mallopt(M_TRIM_THRESHOLD, 256 * MIB);
    mallopt(M_TOP_PAD, 16 * MIB);
#endif
}

bool gpu_prefers_compute(void)
{
    const char *wanted = getenv("PERIGEE_COMPUTE");
    if (wanted && wanted[0]) return strcmp(wanted, "0") != 0;
    const char *renderer = (const char *)glGetString(GL_RENDERER);
    return !strstr(renderer, "llvmpipe") && !strstr(renderer, "softpipe");
}
