// Least and greatest of the heights of a rectangle in each cell of clipmap/bounds.h: 32 texels of a row. A pass of its own,
// because a group that waits for itself costs software drivers more than the heights.
layout(local_size_x = 1, local_size_y = 16) in;

layout(binding = 0) uniform sampler2DArray height_windows;

layout(std430, binding = 0) writeonly buffer Ranges { vec2 ranges[]; };

layout(location = 0) uniform ivec4 rect; // texture row and column of the first sample; rows, columns
layout(location = 1) uniform int level;

#define CELL 32

void main()
{
    ivec2 at = ivec2(gl_GlobalInvocationID.xy); // cell, row
    if (at.y >= rect.z) return;
    int row = (rect.x + at.y) % textureSize(height_windows, 0).y;
    int first = (rect.y / CELL + at.x) * CELL, end = min(first + CELL, rect.y + rect.w);
    vec2 range = vec2(3.4e38, -3.4e38);
    for (int c = max(first, rect.y); c < end; c++) {
        float h = texelFetch(height_windows, ivec3(c, row, level), 0).r;
        range = vec2(min(range.x, h), max(range.y, h));
    }
    ranges[uint(at.y) * gl_NumWorkGroups.x + uint(at.x)] = range;
}
