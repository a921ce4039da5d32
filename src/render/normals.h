// Normals (RG16 snorm, octahedral, ECEF) and convexity (R8 snorm) of the height windows, a layer of
// a texture array a level, taken at creation and made from the heights. Main only.
#ifndef PERIGEE_RENDER_NORMALS_H
#define PERIGEE_RENDER_NORMALS_H

#include <epoxy/gl.h>

#include "base/status.h"
#include "clipmap/clipmap.h"
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

// Of a rectangle of a window, which is all that the array holds of it.
void normals_make(const struct normals *n, GLuint heights, const window *w, window_rect rect);

// A strip of heights was uploaded. Its normals and those of the samples around that see it wait for
// normals_update, until all of its window is there: they need the neighbours.
void normals_note(struct normals *n, const clipmap_strip *strip);
void normals_update(struct normals *n, GLuint heights, const struct clipmap *clipmap);

#endif
