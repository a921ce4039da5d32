#include "gpu/pixel_store.h"

// Alignment first; everything else is 0 for tight rows.
static const GLenum names[2][PIXEL_STORE_VALUES] = {
    {GL_PACK_ALIGNMENT, GL_PACK_ROW_LENGTH, GL_PACK_IMAGE_HEIGHT, GL_PACK_SKIP_PIXELS,
     GL_PACK_SKIP_ROWS, GL_PACK_SKIP_IMAGES, GL_PACK_SWAP_BYTES, GL_PACK_LSB_FIRST},
    {GL_UNPACK_ALIGNMENT, GL_UNPACK_ROW_LENGTH, GL_UNPACK_IMAGE_HEIGHT, GL_UNPACK_SKIP_PIXELS,
     GL_UNPACK_SKIP_ROWS, GL_UNPACK_SKIP_IMAGES, GL_UNPACK_SWAP_BYTES, GL_UNPACK_LSB_FIRST},
};
static const GLenum bindings[2] = {GL_PIXEL_PACK_BUFFER_BINDING, GL_PIXEL_UNPACK_BUFFER_BINDING};
static const GLenum targets[2] = {GL_PIXEL_PACK_BUFFER, GL_PIXEL_UNPACK_BUFFER};

void pixel_store_tight(struct pixel_store *saved, enum pixel_direction direction, GLuint buffer)
{
    saved->direction = direction;
    glGetIntegerv(bindings[direction], &saved->buffer);
    glBindBuffer(targets[direction], buffer);
    for (int i = 0; i < PIXEL_STORE_VALUES; i++) {
        glGetIntegerv(names[direction][i], &saved->values[i]);
        glPixelStorei(names[direction][i], i == 0);
    }
}

void pixel_store_restore(const struct pixel_store *saved)
{
    for (int i = 0; i < PIXEL_STORE_VALUES; i++)
        glPixelStorei(names[saved->direction][i], saved->values[i]);
    glBindBuffer(targets[saved->direction], (GLuint)saved->buffer);
}
