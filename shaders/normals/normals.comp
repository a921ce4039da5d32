// World-space (ECEF) normals of one level's height window, for a rectangle of its samples, and how convex the ground is
// there at the scale of a sample. Central differences along the meridian and the parallel, both over the same length of
// ground whatever the columns' step is, so that nothing shows when a window changes its share of the circle; the
// parametrisation runs on analytically beyond a pole, so rows there need no special case.
#include "lib/octahedron.glsl"

layout(local_size_x = 16, local_size_y = 4) in;

layout(binding = 0) uniform sampler2DArray height_windows;
layout(binding = 0, rg16_snorm) writeonly uniform image2DArray normal_windows;
layout(binding = 1, r8_snorm) writeonly uniform image2DArray convexity_windows;

layout(location = 0) uniform ivec4 rect;   // first row, rows, first column, columns: window samples from the window's first
layout(location = 1) uniform ivec4 window; // texture row and column of the window's first sample; level; 1: whole circle
layout(location = 2) uniform ivec4 valid;  // rows [x, y), columns [z, w)
layout(location = 3) uniform int first_row;      // of the window, from the north pole
layout(location = 4) uniform vec2 axes;          // A, B (m)
layout(location = 5) uniform uvec2 first_column; // of the window, from longitude -pi; columns of the circle
layout(location = 6) uniform vec2 grid;          // steps of latitude and longitude (rad)

#define HALF_CONVEX 0.03 /* slope at which convexity reaches half its range */
#define ROUNDING    2.4e-7 /* of a height, two units in the last place: what lies below is no shape of the ground; at 7 cm
                              a sample and 2000 m it spoke with 5/255 */
#define PI          3.14159265358979
#define REACH_MAX   2.0  /* columns; windows.c recomputes what lies within this and the mean around a strip */

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

// Nothing below counts from the window's first sample where it would be rounded: a normal is the same whatever window it
// is computed in, so frames do not depend on the path that led to them.

// Height about a column and an offset from it (it may lie between two): a mean over as much ground as the columns of twice the step would
// take, when the columns have half the length that a row is high (reach 2), and the sample itself at reach 1.
float height_about(int row, int column, float offset, float reach)
{
    float width = 1.0 + 1.3 * max(reach - 1.0, 0.0), sum = 0.0, weight = 0.0;
    int first = int(ceil(offset - width)), last = int(floor(offset + width));
    for (int c = first; c <= last; c++) {
        float w = max(1.0 - abs(float(c) - offset) / width, 0.0);
        sum += w * height(row, column + c);
        weight += w;
    }
    return sum / weight;
}

void main()
{
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (at.x >= rect.w || at.y >= rect.y) return;
    size = textureSize(height_windows, 0).xy;
    int row = rect.x + at.y, column = rect.z + at.x;
    uint around = (first_column.x + uint(column)) % first_column.y;
    float colat = (float(first_row + row) + 0.5) * grid.x, lon = (float(around) + 0.5) * grid.y - PI;
    float sc = sin(colat), cc = cos(colat), sl = sin(lon), cl = cos(lon);
    float e2 = 1.0 - (axes.y * axes.y) / (axes.x * axes.x);
    float w2 = 1.0 - e2 * cc * cc;
    float radius_prime = axes.x * inversesqrt(w2);
    float radius_meridian = radius_prime * (1.0 - e2) / w2;
    float h = height(row, column);
    int n = max(row - 1, valid.x), s = min(row + 1, valid.y - 1);
    float reach = clamp(grid.x / (grid.y * max(abs(sc), 1e-6)), 0.5, REACH_MAX); // columns as long as a row is high
    float w = -reach, e = reach;
    if (window.w == 0) {
        w = max(w, float(valid.z - column));
        e = min(e, float(valid.w - 1 - column));
    }
    float h_north = height_about(n, column, 0.0, reach), h_south = height_about(s, column, 0.0, reach);
    float h_west = height_about(row, column, w, reach), h_east = height_about(row, column, e, reach);
    float h_here = height_about(row, column, 0.0, reach);
    float south = (h_south - h_north) / (float(max(s - n, 1)) * grid.x * (radius_meridian + h));
    float east = (h_east - h_west) / (max(e - w, 0.5) * grid.y * sc * (radius_prime + h));
    vec3 up = vec3(sc * cl, sc * sl, cc);
    vec3 normal = up - south * vec3(cc * cl, cc * sl, -sc) - east * vec3(-sl, cl, 0.0);
    float above = (h_here - 0.25 * (h_north + h_south + h_west + h_east)) / (grid.x * radius_meridian); // in slopes
    above = sign(above) * max(abs(above) - ROUNDING * abs(h) / (grid.x * radius_meridian), 0.0);
    ivec3 to = ivec3(texel(row, column), window.z);
    imageStore(normal_windows, to, vec4(octahedron_encode(normalize(normal)), 0.0, 0.0));
    imageStore(convexity_windows, to, vec4(above / (abs(above) + HALF_CONVEX), 0.0, 0.0, 0.0));
}
