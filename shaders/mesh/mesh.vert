// Geometry says where: clip position, and the ring coordinates for the full-screen pass.
#ifdef IDENTIFY
#extension GL_ARB_shader_draw_parameters : require
#endif
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
layout(std430, binding = 0) readonly buffer Strides { uint strides[]; }; // of each draw's rings, and of its columns from bit 16 on
#endif

void main()
{
    gl_Position = view.clip_from_tangent * vec4(position, 1.0);
    ring_ne = ring.xy;
#ifdef TEXCOORD_VERTEX
    uint row = uint(gl_VertexID) / view.rings.w;
    vec3 at = ring;
#ifdef SEAM_UNCORRECTED
    at.y = abs(at.y) < 1e-20 ? 1e-30 : at.y; // both copies of the seam on one side
#endif
    map_dlonlat = map_of_ring(at, min(float(row) / float(view.rings.z), float(view.rings.y) + 1.0));
#endif
#ifdef IDENTIFY
    uint vertex = uint(gl_VertexID), columns = view.rings.w;
    quad = uvec2(uint(gl_DrawIDARB) + 1u, vertex);
    uint local = vertex - uint(gl_BaseVertexARB), stride = strides[gl_DrawIDARB];
    corner = float(local % columns / (stride >> 16)) - float(local / columns / (stride & 0xffffu));
    across = corner;
#endif
}
