// Places the vertices of the listed cells: static ring coordinates -> map -> height -> position relative to the camera.
#ifdef SHARP_HEIGHTS
#define CHAIN_SAMPLE sharp_height
#endif
#include "lib/map.glsl"
#include "lib/windows.glsl"
#include "lib/place_frame.glsl"
#include "lib/rings.glsl"

layout(local_size_x = 64) in;

// One cell: first ring row, rows, first column, columns (vertices, both ends included); from bit 16 on, the strides.
layout(std430, binding = 0) readonly buffer Cells { uvec4 cells[]; };
layout(std430, binding = 1) writeonly buffer Place { float place[]; }; // up, east, north (m), tangent frame, from the camera

layout(location = 0) uniform uint first_cell;
layout(location = 1) uniform uint fill_row; // first of the fill's rows, after which come, of the last level's first ring, those
                                            // of the outer half of the fill that was there before that level came in, without
                                            // that ring itself. The rings stand before them

void main()
{
    uvec4 cell = cells[first_cell + gl_WorkGroupID.y];
    uint i = gl_GlobalInvocationID.x;
    uint across = cell.w & 0xffffu;
    if (i >= (cell.y & 0xffffu) * across) return;
    uint row = cell.x + i / across * (cell.y >> 16), column = cell.z + i % across * (cell.w >> 16);
    uint columns = view.rings.w, rings = view.rings.z, last = view.rings.y;
    uint vertex = row * columns + column;
    vec3 r = ring_at(int(row), int(column));
    bool before = row > fill_row + FILL_RINGS;
    uint ring_row = row < fill_row ? row : (before ? last : last + 1u) * rings;
    uint level = min(ring_row / rings, last);
    float f = float(ring_row - level * rings) / float(rings);
    vec2 dlonlat = map_of_ring(r, float(level) + f);
    float fine = max(float(level) + f + view.axes.z, 0.0);
    int wanted = int(fine), finest = int(view.layers.x);
    int sampled = min(wanted, finest);
    float coarser = wanted > finest ? 0.0 : transition_to_coarser(fine - float(wanted));
    float h = chain_height(dlonlat, sampled, coarser);
    float up, east, north;
    relative_position(place_frame_of_view(), r.x, r.y, r.z, h, up, east, north);
    place[3u * vertex] = up;
    place[3u * vertex + 1u] = east;
    place[3u * vertex + 2u] = north;
}
