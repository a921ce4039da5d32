// An OpenGL 4.5 core context without a window (EGL surfaceless). Main only.
#ifndef PERIGEE_GPU_CONTEXT_H
#define PERIGEE_GPU_CONTEXT_H

#include "base/status.h"

struct gpu_context;

// Makes a context and makes it current. ERR_GPU with one clear line when there is no EGL or no GL 4.5.
status gpu_context_create(struct gpu_context **out);
void gpu_context_destroy(struct gpu_context **context);

// Checks that the context current now (made by whomever) is GL 4.5 core or later; ERR_GPU with one clear line if not.
status gpu_context_check(void);

// Routes GL's debug messages of high severity to log_warn (debug contexts only).
void gpu_context_debug(void);

// glibc gives freed memory back to the system every frame, which costs the software driver a third of small frames.
// Call once at program start.
void gpu_tune_allocator(void);

#endif
