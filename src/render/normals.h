// Normals (RG16 snorm, octahedral, ECEF) and convexity (R8 snorm) of the height windows, a layer of
// a texture array a level, taken at creation and made from the heights. Main only.
#ifndef PERIGEE_RENDER_NORMALS_H
#define PERIGEE_RENDER_NORMALS_H

#include <epoxy/gl.h>

#include "base/status.h"
#include "clipmap/window.h"
#include "geo/ellipsoid.h"

struct normals;

typedef struct normals_params {
    geo_ellipsoid ellipsoid;
    window_shape shape;
    int layers, convexity_layers;
    const char *defines; // text put before the shader
} normals_params;

// ERR_GPU when the program fails; the caller asks GL whether the textures were granted.
status normals_create(const normals_params *params, struct normals **out);
void normals_destroy(struct normals **normals);
GLuint normals_texture(const struct normals *n);
GLuint normals_convexity(const struct normals *n);
size_t normals_gpu_bytes(const struct normals *n);

// Between these: any number of rectangles, from the array of heights.
void normals_begin(const struct normals *n, GLuint heights);
void normals_end(void);

// Normals of `rect` and of the samples around it that see it, as far as
// they are `valid` in the window that the level's texture holds.
void normals_compute(const struct normals *n, const window *held, window_rect valid,
                     window_rect rect);

#endif
