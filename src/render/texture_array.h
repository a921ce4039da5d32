// Texture arrays whose layers are windows: they repeat in both directions, for windows are
// toroidal. Main only.
#ifndef PERIGEE_RENDER_TEXTURE_ARRAY_H
#define PERIGEE_RENDER_TEXTURE_ARRAY_H

#include <epoxy/gl.h>
#include <stddef.h>

#include "clipmap/window.h"

static inline GLuint texture_array(GLenum format, const window_shape *shape, int layers,
                                   GLenum filter)
{
    GLuint t;
    glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &t);
    glTextureStorage3D(t, 1, format, shape->cols, shape->rows, layers);
    glTextureParameteri(t, GL_TEXTURE_MIN_FILTER, (GLint)filter);
    glTextureParameteri(t, GL_TEXTURE_MAG_FILTER, (GLint)filter);
    glTextureParameteri(t, GL_TEXTURE_WRAP_S, GL_REPEAT);
    glTextureParameteri(t, GL_TEXTURE_WRAP_T, GL_REPEAT);
    return t;
}

static inline size_t texture_array_bytes(const window_shape *shape, int layers, size_t texel_bytes)
{
    return (size_t)shape->rows * (size_t)shape->cols * (size_t)layers * texel_bytes;
}

#endif
