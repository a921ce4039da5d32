// Windows whose share of the circle doubles or halves keep what they show (clipmap_set_recast): a
// compute pass makes columns of the new width out of the old, in place, where the level's layer
// lies in its texture array. Main only.
#ifndef PERIGEE_RENDER_RECAST_H
#define PERIGEE_RENDER_RECAST_H

#include <epoxy/gl.h>
#include <stdbool.h>

#include "base/status.h"
#include "clipmap/window.h"

struct recast;

typedef struct recast_params {
    window_shape shape;
    GLuint texture; // array of heights (GL_R32F) or colours (GL_SRGB8_ALPHA8); outlives the recast
    int layers;
    bool colors;
    const char *defines; // text put before the shader
} recast_params;

// ERR_GPU.
status recast_create(const recast_params *params, struct recast **out);
void recast_destroy(struct recast **recast);

// Makes the rectangle `valid` of `to`; later commands may use it.
void recast_make(const struct recast *recast, const window *to, bool widens, window_rect valid);

#endif
