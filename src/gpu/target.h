// Off-screen colour and depth targets and their readback. Main only.
#ifndef PERIGEE_GPU_TARGET_H
#define PERIGEE_GPU_TARGET_H

#include <epoxy/gl.h>

#include "base/status.h"

enum { GPU_TARGET_MAX_COLORS = 4 };

typedef struct gpu_target {
    GLuint framebuffer;
    GLuint colors[GPU_TARGET_MAX_COLORS];
    GLuint depth;
    int width, height, color_count;
} gpu_target;

// Textures of the given formats, and a depth texture of depth_format when it is not 0. ERR_GPU when
// the framebuffer is incomplete or too large (logged with the size).
status gpu_target_init(gpu_target *t, int width, int height, const GLenum *color_formats,
                       int color_count, GLenum depth_format);
void gpu_target_deinit(gpu_target *t);

// Reads a whole texture of the target, top row first. pixels must hold width * height texels of
// (format, type). Waits for the GPU: stills and tests only.
void gpu_target_read(const gpu_target *t, GLuint texture, GLenum format, GLenum type,
                     size_t texel_bytes, void *pixels);

#endif
