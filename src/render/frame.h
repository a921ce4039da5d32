// The passes of a frame that do not depend on how vertices were placed: G-buffer targets, the
// shading of every pixel into linear light, the resolve to the screen; and a guard that leaves a
// foreign GL context as it was. Main only.
#ifndef PERIGEE_RENDER_FRAME_H
#define PERIGEE_RENDER_FRAME_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "gpu/target.h"
#include "render/blocks.h"
#include "render/windows.h"

typedef struct frame {
    // Ring coordinates RG32F (and map coordinates RG32F, and identifiers RG32UI), depth 32F
    // reversed.
    gpu_target geometry;
    gpu_target light; // linear RGBA16F, a = 1 on the planet; for fragments a copy of the depth,
                      // which chooses the shader
    GLuint view_buffer, levels_buffer;
    GLuint shade_program, sky_program, resolve_program, empty_array;
    bool texcoord_vertex, identify, compute; // compute: how pixels are shaded
} frame;

// `defines`: text put before the shaders. ERR_GPU.
status frame_init(frame *f, const char *defines, bool texcoord_vertex, bool identify);
void frame_deinit(frame *f);

// Makes the targets fit; nothing when they do already.
status frame_resize(frame *f, int width, int height);
size_t frame_target_bytes(const frame *f);

// The identifiers of the geometry drawn last (mesh.frag), two a pixel, top row first.
void frame_read_identifiers(const frame *f, uint32_t *pairs);

void frame_set_blocks(frame *f, const struct view_block *view, const struct levels_block *levels);

// Binds blocks, windows and the cleared G-buffer for a support geometry to draw into.
void frame_begin_geometry(frame *f, const struct windows *w);
// Every pixel once; fleeting levels are made again, coarse to fine, and each is shaded with while
// it is there.
void frame_shade(frame *f, struct windows *w);
// Draws the light into `framebuffer` over (0, 0, width, height).
void frame_resolve(frame *f, GLuint framebuffer, bool antialias);

// What of the caller's GL state the passes touch.
struct frame_state {
    GLint framebuffer, program, vertex_array, viewport[4], clip_origin, clip_depth, depth_func,
        cull_mode, front_face, active_texture;
    GLboolean depth_test, cull_face, blend, scissor, srgb, depth_mask, color_mask[4], stencil;
};

void frame_state_save(struct frame_state *s);
void frame_state_restore(const struct frame_state *s);

#endif
