// The persistent grid's buffers and rays.
#define BLOCK_DVEC4(name) dvec4 name;
#define BLOCK_DVEC4_ARRAY(name, count) dvec4 name[count];
layout(std430, binding = 0) readonly buffer Grid {
#include "shared/grid_block.glsl"
} grid;
layout(std430, binding = 1) readonly buffer Columns { dvec4 columns[]; }; // two each: struct grid_column

#define GRID_SHARED
#define GRID_OUT(t) out t
#define GRID_SET(n) n
#define GRID_PARAM
#define GRID_PASS
#define GRID(member) grid.member
#define double_of(x) double(x)
#define int_of(x) int(x)
#include "shared/grid_rays.glsl"
