// World-space (ECEF) normals of one level's height window, for a rectangle of its samples, and how convex the ground is
// there at the scale of a sample. Central differences along the meridian and the parallel; the parametrisation runs on
// analytically beyond a pole, so rows there need no special case.
#include "lib/octahedron.glsl"

layout(local_size_x = 16, local_size_y = 4) in;

layout(binding = 0) uniform sampler2DArray height_windows;
layout(binding = 0, rg16_snorm) writeonly uniform image2DArray normal_windows;
layout(binding = 1, r8_snorm) writeonly uniform image2DArray convexity_windows;

layout(location = 0) uniform ivec4 rect;   // first row, rows, first column, columns: window samples from the window's first
layout(location = 1) uniform ivec4 window; // texture row and column of the window's first sample; level; 1: whole circle
layout(location = 2) uniform ivec4 valid;  // rows [x, y), columns [z, w)
layout(location = 3) uniform vec4 grid;    // colatitude and longitude of the first sample; steps (rad)
layout(location = 4) uniform vec2 axes;    // A, B (m)

#define HALF_CONVEX 0.03 /* slope at which convexity reaches half its range */

ivec2 size;

ivec2 texel(int row, int column)
{
    row = (row + window.x) % size.y;
    return ivec2((column + window.y) & (size.x - 1), row);
}

float height(int row, int column)
{
    row = clamp(row, valid.x, valid.y - 1);
    if (window.w == 0) column = clamp(column, valid.z, valid.w - 1);
    return texelFetch(height_windows, ivec3(texel(row, column), window.z), 0).r;
}

void main()
{
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (at.x >= rect.w || at.y >= rect.y) return;
    size = textureSize(height_windows, 0).xy;
    int row = rect.x + at.y, column = rect.z + at.x;
    float colat = grid.x + float(row) * grid.z, lon = grid.y + float(column) * grid.w;
    float sc = sin(colat), cc = cos(colat), sl = sin(lon), cl = cos(lon);
    float e2 = 1.0 - (axes.y * axes.y) / (axes.x * axes.x);
    float w2 = 1.0 - e2 * cc * cc;
    float radius_prime = axes.x * inversesqrt(w2);
    float radius_meridian = radius_prime * (1.0 - e2) / w2;
    float h = height(row, column);
    int n = max(row - 1, valid.x), s = min(row + 1, valid.y - 1);
    int w = column - 1, e = column + 1;
    if (window.w == 0) {
        w = max(w, valid.z);
        e = min(e, valid.w - 1);
    }
    float h_north = height(n, column), h_south = height(s, column), h_west = height(row, w), h_east = height(row, e);
    float south = (h_south - h_north) / (float(max(s - n, 1)) * grid.z * (radius_meridian + h));
    float east = (h_east - h_west) / (float(max(e - w, 1)) * grid.w * sc * (radius_prime + h));
    vec3 up = vec3(sc * cl, sc * sl, cc);
    vec3 normal = up - south * vec3(cc * cl, cc * sl, -sc) - east * vec3(-sl, cl, 0.0);
    float above = (h - 0.25 * (h_north + h_south + h_west + h_east)) / (grid.z * radius_meridian); // in slopes
    ivec3 to = ivec3(texel(row, column), window.z);
    imageStore(normal_windows, to, vec4(octahedron_encode(normalize(normal)), 0.0, 0.0));
    imageStore(convexity_windows, to, vec4(above / (abs(above) + HALF_CONVEX), 0.0, 0.0, 0.0));
}
