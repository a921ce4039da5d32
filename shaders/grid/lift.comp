// Lifts the grid's vertices to the terrain, each at the level of detail that its neighbours allow: the mean of those along and
// across the ray, of which towards the limb the former are many times as far, or the farthest (Livny et al. 2008, 3.4).
#include "lib/map.glsl"
#include "lib/windows.glsl"
#include "lib/grid.glsl"
#include "lib/place_frame.glsl"

layout(local_size_x = 64) in;

layout(std430, binding = 2) readonly buffer Ring { float ring[]; };
layout(std430, binding = 3) writeonly buffer Place { float place[]; }; // up, east, north (m), tangent frame, from the camera

layout(location = 0) uniform ivec2 size; // rows, columns

vec3 ring_of(int row, int column)
{
    int vertex = row * size.y + column;
    return vec3(ring[3 * vertex], ring[3 * vertex + 1], ring[3 * vertex + 2]);
}

float apart(vec3 at, int row, int column)
{
    if (row < 0 || column < 0 || row >= size.x || column >= size.y) return 0.0;
    return distance(at, ring_of(row, column));
}

void main()
{
    int vertex = int(gl_GlobalInvocationID.x);
    if (vertex >= size.x * size.y) return;
    int row = vertex / size.y, column = vertex % size.y;
    vec3 r = ring_of(row, column);
    float along = max(apart(r, row - 1, column), apart(r, row + 1, column)),
          across = max(apart(r, row, column - 1), apart(r, row, column + 1));
#ifdef FARTHEST_NEIGHBOUR
    float spacing = max(along, across);
#else
    float spacing = sqrt(along * across);
#endif
    float level = log2(3.14159265358979 / ring_angle(length(r.xy), 1.0 - r.z));
    float reaches = min(level - float(view.layers.z), float(view.layers.x));
    int sampled;
    float coarser;
    grid_level(2.0 / (levels.height_map[0].x * max(spacing, 1e-12)), reaches, sampled, coarser);
    float h = chain_height(map_of_ring(r, level), sampled, coarser);
    float up, east, north;
    relative_position(place_frame_of_view(), r.x, r.y, r.z, h, up, east, north);
    place[3 * vertex] = up;
    place[3 * vertex + 1] = east;
    place[3 * vertex + 2] = north;
}
