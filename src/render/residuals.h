// Strips of heights that come as residuals (clipmap/residual.h) are added to the doubled samples of
// the next coarser window on the GPU (Asirvatham & Hoppe 2005, 2.4). Main only.
#ifndef PERIGEE_RENDER_RESIDUALS_H
#define PERIGEE_RENDER_RESIDUALS_H

#include <epoxy/gl.h>

#include "clipmap/clipmap.h"
#include "gpu/upload.h"

struct residuals;

// defines: text put before the shader. ERR_GPU.
status residuals_create(const window_shape *shape, const char *defines, struct residuals **out);
void residuals_destroy(struct residuals **residuals);
size_t residuals_gpu_bytes(const struct residuals *residuals);

// Uploads a strip that has residuals and makes its heights in the array (GL_R32F), whose level
// before holds what they add to; later commands may use them. Bits are those of the strip's
// samples.
void residuals_add(struct residuals *residuals, struct gpu_upload *upload, GLuint heights,
                   const clipmap_strip *strip);

#endif
