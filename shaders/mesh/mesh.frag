#ifdef FLAT
#include "lib/blocks.glsl"
#endif
#ifdef TEXCOORD_VERTEX
layout(location = 1) in vec2 map_dlonlat;
layout(location = 1) out vec2 out_dlonlat;
#define IDENTIFIER_LOCATION 2
#else
#define IDENTIFIER_LOCATION 1
#endif
#ifdef IDENTIFY
layout(location = 2) flat in uvec2 quad;   // draw + 1 (0: nothing drawn), vertex of its outer ring and smaller azimuth
layout(location = 3) flat in float corner; // column less row of that vertex; constant along the quad's diagonal
layout(location = 4) in float across;
layout(location = IDENTIFIER_LOCATION) out uvec2 out_identifier; // draw + 1, number of the triangle
#endif
layout(location = 0) in vec2 ring_ne;
layout(location = 0) out vec2 out_ring;

void main()
{
#ifdef FLAT // beyond the map there is nothing
    vec4 inside = vec4(ring_ne - view.map_edge.xz, view.map_edge.yw - ring_ne);
    if (min(min(inside.x, inside.y), min(inside.z, inside.w)) < 0.0) discard;
#endif
    out_ring = ring_ne;
#ifdef TEXCOORD_VERTEX
    out_dlonlat = map_dlonlat;
#endif
#ifdef IDENTIFY
    // Not by gl_PrimitiveID, which Mesa's software driver counts wrongly over a multi-draw.
    out_identifier = uvec2(quad.x, 2u * quad.y + (across >= corner ? 0u : 1u));
#endif
}
