// A persistently mapped ring through which all texture and buffer uploads of a frame go, without a
// wait: a frame may use at most a third of it, and a third is written again only after its fence
// has passed. Between begin and end the pixel unpack state is the ring's; end gives it back. Main
// only.
#ifndef PERIGEE_GPU_UPLOAD_H
#define PERIGEE_GPU_UPLOAD_H

#include <epoxy/gl.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

struct gpu_upload;

status gpu_upload_create(size_t bytes_per_frame, struct gpu_upload **out);
void gpu_upload_destroy(struct gpu_upload **upload);

// Starts a frame's share. False (nothing may be uploaded this frame) when the GPU still reads the
// share to be reused.
bool gpu_upload_begin(struct gpu_upload *upload);

// Room left in this frame's share.
size_t gpu_upload_room(const struct gpu_upload *upload);

// After a begin that was granted. Copies a rectangle of texels (tightly packed rows) into layer
// `layer` of a GL_TEXTURE_2D_ARRAY. bytes <= room.
void gpu_upload_texture(struct gpu_upload *upload, GLuint texture, int layer, int x, int y,
                        int width, int height, GLenum format, GLenum type, const void *texels,
                        size_t bytes);

// Ends the frame's share with a fence.
void gpu_upload_end(struct gpu_upload *upload);

// Bytes uploaded since creation.
size_t gpu_upload_total(const struct gpu_upload *upload);

#endif
