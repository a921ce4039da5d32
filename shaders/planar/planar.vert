// A vertex of a geometry clipmap wrapped onto the planet: its place from its row and column, its height from its texel,
// blended towards the coarser level's by its distance from the viewer (Asirvatham & Hoppe 2005, 2.3.5).
#include "lib/layers.glsl"
#include "lib/place_frame.glsl"

layout(location = 0) in uvec2 footprint; // row, column
layout(location = 1) in uvec4 instance;  // row and column added; level, and IS_BORDER; number of the draw
#define IS_BORDER 0x100u

layout(std430, binding = 1) readonly buffer Rows { vec4 rows[]; };       // nest_row (geo/nest.h), by level
layout(std430, binding = 2) readonly buffer Columns { vec4 columns[]; }; // nest_column
struct square {
    vec4 viewer;  // row and column; least share of the coarser level; 1: there is a coarser one
    vec4 active_region; // first and last row, first and last column
    vec4 blend;   // distance from the viewer at which the transition begins; 1 / its width
};
layout(std430, binding = 3) readonly buffer Squares { square squares[]; };
layout(binding = 7) uniform sampler2DArray elevation;
layout(location = 0) uniform uint stride;   // rows and columns stored a level
layout(location = 1) uniform uint vertices; // more than a draw has

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

// By the distance from the viewer; where the region is cropped, by that from its border. 1 at the border, rounded or not.
float alpha_at(square s, vec2 at)
{
    vec2 away = abs(at - s.viewer.xy), sides = min(at - s.active_region.xz, s.active_region.yw - at);
    float from_border = min(sides.x, sides.y);
    float alpha = max((max(away.x, away.y) - s.blend.x) * s.blend.y, 1.0 - from_border * s.blend.y);
    return from_border <= 0.0 ? s.viewer.w : clamp(alpha, s.viewer.z, 1.0) * s.viewer.w;
}

void main()
{
    uvec2 at = footprint + instance.xy;
    uint level = instance.z & (IS_BORDER - 1u);
    vec4 row = rows[level * stride + at.x], column = columns[level * stride + at.y];
    square s = squares[level];
    float alpha = alpha_at(s, vec2(at));
    uint wrap = uint(textureSize(elevation, 0).x) - 1u;
    vec2 heights = unpack_heights(texelFetch(elevation, ivec3(at.y & wrap, at.x, elevation_layer(int(level))), 0).rg);
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
    quad = uvec2(instance.w + 1u, instance.w * vertices + uint(gl_VertexID));
    across = float(at.y) - float(at.x);
    corner = (instance.z & IS_BORDER) != 0u ? -1e9 : across; // one triangle a vertex
#endif
}
