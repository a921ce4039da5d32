// Throws the grid's rays: each vertex's place on the planet, as ring coordinates about the focus.
#include "lib/grid.glsl"

layout(local_size_x = 64) in;

layout(std430, binding = 2) writeonly buffer Ring { float ring[]; }; // n~, e~, v~ of every vertex, row by row

layout(location = 0) uniform ivec2 size; // rows, columns

void main()
{
    int vertex = int(gl_GlobalInvocationID.x);
    if (vertex >= size.x * size.y) return;
    int row = vertex / size.y, column = vertex % size.y;
    dvec4 first = columns[2 * column], second = columns[2 * column + 1];
    double w = grid_row(first.w, second.x, second.y, second.z, row, size.x), ahead, above;
    grid_unwarp(w, grid.row_axis.w, grid.limb.w, ahead, above);
    dvec3 dir = ahead * first.xyz + above * grid.row_axis.xyz;
    grid_direction p = grid_foot(dir.x, dir.y, dir.z);
    double ss = p.n * p.n + p.e * p.e;
    ring[3 * vertex] = float(p.n);
    ring[3 * vertex + 1] = float(p.e);
#ifdef FLAT
    ring[3 * vertex + 2] = 0.0;
#else
    ring[3 * vertex + 2] = float(p.u > 0.0 ? ss / (1.0 + p.u) : 1.0 - p.u);
#endif
}
