// Geometry says where: clip position, and the ring coordinates for the full-screen pass.
#ifdef IDENTIFY
#extension GL_ARB_shader_draw_parameters : require
#endif
#include "lib/blocks.glsl"
#include "lib/rings.glsl"
#ifdef TEXCOORD_VERTEX
#include "lib/map.glsl"
#endif

layout(location = 0) in vec3 position; // m, tangent frame, from the camera

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

layout(std430, binding = 1) readonly buffer Place { float place[]; };

// Vertices that go, or have just come, slide onto ones that stay (src/render/stride.h). Rows of a band; the fill's first row, and
// the first but one of the fill before; stride of the columns. Share by which every second column has slid, and by which the
// last level's rings and the fill's have slid to those of the fill before. A band's: stride of its rings, share of every second one; 0 of
// the ring that ends the last of the BANDS.
layout(location = 0) uniform ivec4 cut;
layout(location = 1) uniform vec2 slid;
layout(location = 2) uniform vec2 bands[BANDS + 1];

struct point {
    vec3 position, ring;
};

point vertex_at(int row, int column)
{
    int i = 3 * (row * int(view.rings.w) + column);
    return point(vec3(place[i], place[i + 1], place[i + 2]), ring_at(row, column));
}

point mixed(point a, point b, float t)
{
    return point(mix(a.position, b.position, t), mix(a.ring, b.ring, t));
}

// The ring of the fill before on which a row of the last level or of the fill stood, or the next one outwards.
int row_before(int row, int first)
{
    int half_fill = FILL_RINGS / 2, rows = int(view.rings.z);
    int ring = row >= cut.y ? half_fill + (row - cut.y) / 2
                            : int(float(FILL_RINGS) * (1.0 - exp2(-float(row - first) / float(rows))) + 1e-3);
    if (row == first + rows) return row; // the fill's first
    return ring == 0 ? first : ring < half_fill ? cut.z + ring - 1 : cut.y + 2 * (ring - half_fill);
}

// A vertex of a row slid along its radius. Loops, because software drivers skip one that no vertex is in.
point slid_down(int row, int column)
{
    int first = int(view.rings.y * view.rings.z);
    point p = vertex_at(row, column);
    for (int i = 0; i < (row >= first && slid.y > 0.0 ? 1 : 0); i++) p = mixed(p, vertex_at(row_before(row, first), column), slid.y);
    return p;
}

// This vertex slid along its radius, then along its ring.
point slide()
{
    int columns = int(view.rings.w), row = gl_VertexID / columns, column = gl_VertexID - row * columns;
    vec2 band = row < cut.y ? bands[row / cut.x] : vec2(1.0, 0.0);
    int right = cut.w, down = max(int(band.x), 1);
    float across = (row % cut.x / down & 1) == 1 ? band.y : 0.0;
    // The meridian stands twice.
    float along = ((column - (column > columns / 2 - 1 ? 1 : 0)) / right & 1) == 1 ? slid.x : 0.0;
    bool moves = across + along > 0.0 || (slid.y > 0.0 && row >= int(view.rings.y * view.rings.z));
    point sum = point(position, ring_at(row, column));
    for (int k = 0; k < (along > 0.0 ? 2 : moves ? 1 : 0); k++) {
        int at = column - k * right;
        point p = slid_down(row, at);
        for (int i = 0; i < (across > 0.0 ? 1 : 0); i++) p = mixed(p, slid_down(row - down, at), across);
        sum = k == 0 ? p : mixed(sum, p, along);
    }
    return sum;
}

void main()
{
    point at = slide();
    gl_Position = view.clip_from_tangent * vec4(at.position, 1.0);
    ring_ne = at.ring.xy;
#ifdef TEXCOORD_VERTEX
    uint row = uint(gl_VertexID) / view.rings.w;
    vec3 r = at.ring;
#ifdef SEAM_UNCORRECTED
    r.y = abs(r.y) < 1e-20 ? 1e-30 : r.y; // both copies of the seam on one side
#endif
    map_dlonlat = map_of_ring(r, min(float(row) / float(view.rings.z), float(view.rings.y) + 1.0));
#endif
#ifdef IDENTIFY
    uint vertex = uint(gl_VertexID), columns = view.rings.w;
    quad = uvec2(uint(gl_DrawIDARB) + 1u, vertex);
    uint local = vertex - uint(gl_BaseVertexARB), stride = strides[gl_DrawIDARB];
    corner = float(local % columns / (stride >> 16)) - float(local / columns / (stride & 0xffffu));
    across = corner;
#endif
}
