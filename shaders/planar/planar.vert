// A vertex of a geometry clipmap wrapped onto the planet: its place from its row and column, its height from its texel,
// blended towards the coarser level's by its distance from the viewer (Asirvatham & Hoppe 2005, 2.3.5).
#include "lib/place_frame.glsl"

layout(location = 0) in uvec2 footprint; // row, column
layout(location = 1) in uvec4 instance;  // row and column added; level; number of the draw

layout(std430, binding = 1) readonly buffer Rows { vec4 rows[]; };       // nest_row (geo/nest.h), by level
layout(std430, binding = 2) readonly buffer Columns { vec4 columns[]; }; // nest_column
layout(std430, binding = 3) readonly buffer Squares { vec4 squares[]; }; // viewer's row and column; least share of the
                                                                         // coarser level; 1: there is a coarser one
layout(binding = 7) uniform sampler2DArray elevation;
layout(location = 0) uniform vec4 size; // rows and columns stored a level; where the transition begins; 1 / its width; n - 1

layout(location = 0) out vec2 ring_ne;
#ifdef TEXCOORD_VERTEX
layout(location = 1) out vec2 map_dlonlat;
#endif
#ifdef IDENTIFY
layout(location = 2) flat out uvec2 quad;
layout(location = 3) flat out float corner;
layout(location = 4) out float across;
#endif

#ifdef PACKED_HEIGHTS
// 2005, 2.4.1: whole metres, and in the fraction the coarser level's difference.
vec2 unpack_heights(vec2 texel)
{
    float fine = floor(texel.x);
    return vec2(fine, fine + ((texel.x - fine) * 512.0 - 256.0));
}
#else
vec2 unpack_heights(vec2 texel)
{
    return texel;
}
#endif

void main()
{
    uvec2 at = footprint + instance.xy;
    uint level = instance.z, stride = uint(size.x);
    vec4 row = rows[level * stride + at.x], column = columns[level * stride + at.y], square = squares[level];

    vec2 away = abs(vec2(at) - square.xy);
    float alpha = clamp((max(away.x, away.y) - size.y) * size.z, square.z, 1.0);
    if (any(equal(at, uvec2(0u))) || any(equal(at, uvec2(size.w)))) alpha = 1.0; // rounded or not
    alpha *= square.w;
    uint wrap = uint(textureSize(elevation, 0).x) - 1u;
    vec2 heights = unpack_heights(texelFetch(elevation, ivec3(at.y & wrap, at.x, level), 0).rg);
    // The border's height is the coarser level's to the last bit.
    float h = alpha == 1.0 ? heights.y : heights.x + alpha * (heights.y - heights.x);

    float fall = row.z * column.y; // cos b (1 - cos dlon)
    vec3 ring = vec3(row.x + view.focus.y * fall, row.z * column.x, row.y + view.focus.x * fall);
    float up, east, north;
    relative_position(place_frame_of_view(), ring.x, ring.y, ring.z, h, up, east, north);
    gl_Position = view.clip_from_tangent * vec4(up, east, north, 1.0);
    ring_ne = ring.xy;
#ifdef TEXCOORD_VERTEX
    map_dlonlat = vec2(column.w, row.w);
#endif
#ifdef IDENTIFY
    quad = uvec2(instance.w + 1u, instance.w * 131072u + uint(gl_VertexID));
    corner = float(at.y) - float(at.x);
    across = corner;
#endif
}
