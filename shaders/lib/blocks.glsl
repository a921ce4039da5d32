// The uniform blocks of a frame, from the member lists shared with C.
#define BLOCK_MAT4(name) mat4 name;
#define BLOCK_VEC4(name) vec4 name;
#define BLOCK_UVEC4(name) uvec4 name;
#define BLOCK_VEC4_ARRAY(name, count) vec4 name[count];
layout(std140, binding = 0) uniform View {
#include "shared/view_block.glsl"
} view;
layout(std140, binding = 1) uniform Levels {
#include "shared/levels_block.glsl"
} levels;
