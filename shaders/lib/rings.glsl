// The static rings (src/geo/rings.h), as rows and columns of vertices.
#include "shared/rings.glsl"

layout(std430, binding = 2) readonly buffer RingRows { float ring_rows[]; };      // struct ring_row
layout(std430, binding = 3) readonly buffer RingColumns { vec4 ring_columns[]; }; // struct ring_column

const float RING_SEAM = 1e-30; // as in src/geo/rings.h

// n~, e~, v~; of the seam's columns e~ has the sign of its side.
vec3 ring_at(int row, int column)
{
    float radius = ring_rows[3 * row], radius_low = ring_rows[3 * row + 1];
    vec4 c = ring_columns[column];
    float n = ring_coordinate(radius, radius_low, c.x, c.y), e = ring_coordinate(radius, radius_low, c.z, c.w);
    bool west = column > int(view.rings.w) / 2 - 1;
    return vec3(n, west ? min(e, -RING_SEAM) : max(e, RING_SEAM), ring_rows[3 * row + 2]);
}
