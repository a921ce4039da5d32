// The state that pixel transfers depend on, put at tightly packed rows and given back: the context
// may be another program's. Private to the room. Main only.
#ifndef PERIGEE_GPU_PIXEL_STORE_H
#define PERIGEE_GPU_PIXEL_STORE_H

#include <epoxy/gl.h>

enum pixel_direction { PIXEL_PACK, PIXEL_UNPACK }; // reading from GL, writing to it

enum { PIXEL_STORE_VALUES = 8 };

struct pixel_store {
    enum pixel_direction direction;
    GLint values[PIXEL_STORE_VALUES];
    GLint buffer;
};

// Saves the state, then sets tight rows and binds `buffer` (0: client memory).
void pixel_store_tight(struct pixel_store *saved, enum pixel_direction direction, GLuint buffer);
void pixel_store_restore(const struct pixel_store *saved);

#endif
