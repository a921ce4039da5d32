// An OpenGL 4.5 core context without a window (EGL surfaceless). Main only.
#ifndef PERIGEE_GPU_CONTEXT_H
#define PERIGEE_GPU_CONTEXT_H

#include <stdbool.h>

#include "base/status.h"

struct gpu_context;

// Makes a context and makes it current: on a real GPU where EGL has one, else on Mesa's software
// driver. At most one at a time in a process. With one clear line: ERR_NOT_FOUND when there is no
// EGL, ERR_GPU when it has no OpenGL 4.5 core. PERIGEE_EGL_DEVICE=N in the environment takes the
// N-th EGL device only; PERIGEE_GL_DEBUG=1 makes a debug context.
status gpu_context_create(struct gpu_context **out);
void gpu_context_destroy(struct gpu_context **context);

// Checks that the context current now (made by whomever) is GL 4.5 core or later; ERR_GPU with one
// clear line if not.
status gpu_context_check(void);

// Routes GL's debug messages of high severity to log_warn (debug contexts only).
void gpu_context_debug(void);

// Takes the errors that GL holds from before, so that what follows is judged by its own. A lost
// context may report one for ever: so many are taken and no more, and what follows fails by it.
void gpu_context_forgive(void);

// Is work over every pixel better done by compute shaders? So it is on graphics cards: those of
// data centres have a thirtieth of their processors for fragments. Mesa's software driver takes
// half as long again for it. PERIGEE_COMPUTE=0 or 1 in the environment says otherwise. Needs a
// context.
bool gpu_prefers_compute(void);

// glibc gives freed memory back to the system every frame, which costs the software driver a third
// of small frames. Call once at program start.
void gpu_tune_allocator(void);

#endif
