// The heights of one level's vertices and, at the same places, those of the next coarser level's triangles: a vertex on the
// coarser lattice has its height, one on an edge or a diagonal the mean of the edge's ends (Asirvatham & Hoppe 2005, 2.3.5).
#include "lib/windows.glsl"

layout(local_size_x = 16, local_size_y = 4) in;

#ifdef PACKED_HEIGHTS
layout(binding = 0, r32f) uniform image2DArray elevation;
#else
layout(binding = 0, rg32f) uniform image2DArray elevation;
#endif
layout(location = 0) uniform ivec4 level;    // of the nest; of the windows; first and last row that is no pole's other side
layout(location = 1) uniform ivec4 origin;   // index in the coarser level of the first row and column; n; 1: there is a coarser
layout(location = 2) uniform vec4 place[24]; // in each level's window: row of the first vertex, rows a row; the same of columns

// As chain_height (lib/windows.glsl), but by whole steps from the window's first sample: nothing here depends on where the
// viewer is, so a vertex has the same height, to the last bit, in whatever frame and level it is computed.
float chain_of_vertex(vec2 at, int finest_level)
{
    float finest = 0.0, sum = 0.0, rest = 1.0;
    for (int i = finest_level; i >= 0; i--) {
        vec4 p = place[i];
        vec2 there = p.xz + at * p.yw;
        float w = window_weight(levels.height_valid[i], levels.height_torus[i].z, there);
        if (w > 0.0) {
            float h = window_height(i, there);
            if (rest == 1.0) finest = h;
            sum += rest * w * (h - finest);
            rest *= 1.0 - w;
        }
        if (rest <= 0.0) break;
    }
    return finest + (sum - rest * finest);
}

float fine_height(ivec2 at)
{
    // A pole is one point: its height is the coarsest level's in one direction.
    if (at.x <= level.z || at.x >= level.w)
        return chain_of_vertex(vec2(float(clamp(at.x, level.z, level.w)), -place[0].z / place[0].w), 0);
    return chain_of_vertex(vec2(at), level.y);
}

float coarse_height(ivec2 at)
{
    ivec3 texel = ivec3(at.y & origin.z, at.x, elevation_layer(level.x - 1));
#ifdef PACKED_HEIGHTS
    return floor(imageLoad(elevation, texel).r);
#else
    return imageLoad(elevation, texel).r;
#endif
}

// Both ends of an edge that runs from smaller to larger rows and columns, as the triangles' diagonals do.
float coarser_triangles(ivec2 at)
{
    ivec2 half_way = at & 1, before = origin.xy + (at >> 1);
    float h = coarse_height(before);
    if (half_way == ivec2(0)) return h;
    return 0.5 * (h + coarse_height(before + half_way));
}

void main()
{
    ivec2 at = ivec2(gl_GlobalInvocationID.yx); // row, column
    if (at.x >= origin.z || at.y > origin.z) return;
    float fine = fine_height(at), coarse = fine;
    if (origin.w != 0) coarse = coarser_triangles(at);
    ivec3 texel = ivec3(at.y, at.x, elevation_layer(level.x));
#ifdef PACKED_HEIGHTS
    fine = floor(fine + 0.5);
    imageStore(elevation, texel, vec4(fine + clamp((coarse - fine + 256.0) / 512.0, 0.0, 0.998)));
#else
    imageStore(elevation, texel, vec4(fine, coarse, 0.0, 0.0));
#endif
}
