// A vertex of the persistent grid; what mesh.vert does for the rings.
#include "lib/blocks.glsl"
#ifdef TEXCOORD_VERTEX
#include "lib/map.glsl"
#endif

layout(location = 0) in vec3 position; // m, tangent frame, from the camera
layout(location = 1) in vec3 ring;

layout(location = 0) out vec2 ring_ne;
#ifdef TEXCOORD_VERTEX
layout(location = 1) out vec2 map_dlonlat;
#endif
#ifdef IDENTIFY
layout(location = 2) flat out uvec2 quad;
layout(location = 3) flat out float corner;
layout(location = 4) out float across;
#endif

layout(location = 0) uniform int columns;

void main()
{
    gl_Position = view.clip_from_tangent * vec4(position, 1.0);
    ring_ne = ring.xy;
#ifdef TEXCOORD_VERTEX
    map_dlonlat = map_of_ring(ring, log2(3.14159265358979 / ring_angle(length(ring.xy), 1.0 - ring.z)));
#endif
#ifdef IDENTIFY
    quad = uvec2(1u, uint(gl_VertexID));
    corner = float(gl_VertexID % columns) - float(gl_VertexID / columns);
    across = corner;
#endif
}
