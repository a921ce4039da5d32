// The uniform blocks as C structs, from the member lists shared with the shaders (std140: only
// 16-byte members).
#ifndef PERIGEE_RENDER_BLOCKS_H
#define PERIGEE_RENDER_BLOCKS_H

#include <stdint.h>

#define BLOCK_MAT4(name)              float name[16];
#define BLOCK_VEC4(name)              float name[4];
#define BLOCK_UVEC4(name)             uint32_t name[4];
#define BLOCK_VEC4_ARRAY(name, count) float name[count][4];

struct view_block {
#include "shared/view_block.glsl"
};

struct levels_block {
#include "shared/levels_block.glsl"
};

#undef BLOCK_MAT4
#undef BLOCK_VEC4
#undef BLOCK_UVEC4
#undef BLOCK_VEC4_ARRAY

#endif
