// World-space (ECEF) normals of one level's height window, for a rectangle of its samples, and how convex the ground is
// there at the scale of a sample. Both from the sample and its eight neighbours at the length of a row on the ground,
// whatever the columns' length and however near a pole, so that neither depends on the latitude nor shows when a window
// changes its share of the circle. The parametrisation runs on analytically beyond a pole.
#include "lib/layers.glsl"
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
#define REACH_MAX   8.0  /* columns, unless the window holds the circle; REACH_MAX of windows.c */
#define BETWEEN     0.98 /* a place as near as 1 - this to a row of samples counts as on it */

ivec2 size;
float datum; // the sample's own height; all others are taken from it, so that none is rounded at its own size

ivec2 texel(int row, int column)
{
    row = (row + window.x) % size.y;
    return ivec2((column + window.y) & (size.x - 1), row);
}

float height(int row, int column)
{
    row = clamp(row, valid.x, valid.y - 1);
    if (window.w == 0) column = clamp(column, valid.z, valid.w - 1);
    return texelFetch(height_windows, ivec3(texel(row, column), window_layer(window.z)), 0).r - datum;
}

// Nothing below counts from the window's first sample where it would be rounded: a normal is the same whatever window it
// is computed in, so frames do not depend on the path that led to them.

// Height above the datum at an offset from a sample: between rows linear, along the row a mean over as much ground as the columns of twice
// the step would take, when the columns have half the length that a row is high (reach 2), and linear at reach 1.
float height_about(int row, int column, vec2 offset, float reach)
{
    float width = 1.0 + 1.3 * clamp(reach - 1.0, 0.0, 1.0), sum = 0.0, weight = 0.0;
    int first = int(ceil(offset.y - width)), last = int(floor(offset.y + width));
    for (int r = int(ceil(offset.x - BETWEEN)); r <= int(floor(offset.x + BETWEEN)); r++) {
        for (int c = first; c <= last; c++) {
            float w = (1.0 - abs(float(r) - offset.x)) * max(1.0 - abs(float(c) - offset.y) / width, 0.0);
            sum += w * height(row + r, column + c);
            weight += w;
        }
    }
    return sum / weight;
}

// Rows and columns from a sample to the place that lies `rows` to the south of it on its meridian and from there `east`
// rows along the great circle at a right angle. `pole`: sine and tangent of the sample's colatitude, in rows.
vec2 neighbour(float rows, float east, vec2 pole, float cosine)
{
#ifdef FLAT
    return vec2(rows, grid.x / grid.y);
#endif
    float x = pole.y + rows;
    float bent = sign(x) * east * east / (abs(x) + length(vec2(x, east))); // the great circle off the parallel
    return vec2(rows + bent, atan(east, abs(pole.x + cosine * rows)) / grid.y);
}

void main()
{
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (at.x >= rect.w || at.y >= rect.y) return;
    size = textureSize(height_windows, 0).xy;
    int row = rect.x + at.y, column = rect.z + at.x;
    uint around = (first_column.x + uint(column)) % first_column.y;
    float colat = (float(first_row + row) + 0.5) * grid.x, lon = (float(around) + 0.5) * grid.y - PI;
#ifdef FLAT // as on the equator at longitude 0, where the axes are the plane's
    float sc = 1.0, cc = 0.0, sl = 0.0, cl = 1.0;
#else
    float sc = sin(colat), cc = cos(colat), sl = sin(lon), cl = cos(lon);
#endif
    float e2 = 1.0 - (axes.y * axes.y) / (axes.x * axes.x);
    float w2 = 1.0 - e2 * cc * cc;
    float radius_prime = axes.x * inversesqrt(w2);
    float radius_meridian = radius_prime * (1.0 - e2) / w2;
    datum = 0.0;
    datum = height(row, column);
    float reach = grid.x / (grid.y * abs(sc)); // columns as long as a row is high
    int n = max(row - 1, valid.x), s = min(row + 1, valid.y - 1);
    float h_here = height_about(row, column, vec2(0.0), reach);
    float h_north = height_about(n, column, vec2(0.0), reach), h_south = height_about(s, column, vec2(0.0), reach);
    float edges = h_north + h_south, corners = 0.0, east = 0.0;
    for (int i = -1; i <= 1; i++) {
        vec2 to = neighbour(float(i), radius_meridian / radius_prime, vec2(sc, sc / cc) / grid.x, cc);
        float w = -to.y, e = to.y;
        if (window.w == 0) {
            w = max(max(w, -REACH_MAX), float(valid.z - column));
            e = min(min(e, REACH_MAX), float(valid.w - 1 - column));
        }
        float h_west = height_about(row, column, vec2(to.x, w), reach);
        float h_east = height_about(row, column, vec2(to.x, e), reach);
        if (i != 0) corners += h_west + h_east;
        else {
            edges += h_west + h_east;
            east = sign(sc) * (h_east - h_west) * to.y / max(e - w, 0.5);
        }
    }
#ifdef FLAT
    float row_length = grid.x * radius_meridian;
#else
    float row_length = grid.x * (radius_meridian + datum);
#endif
    float south = (h_south - h_north) / float(max(s - n, 1));
    vec3 up = vec3(sc * cl, sc * sl, cc);
    vec3 normal = row_length * up - south * vec3(cc * cl, cc * sl, -sc) - east * vec3(-sl, cl, 0.0);
    // The nine-point Laplacian, because its error too is alike in all directions, to the fourth order. In slopes.
    float above = (h_here - edges / 5.0 - corners / 20.0) * (5.0 / 6.0) / (grid.x * radius_meridian);
    above = sign(above) * max(abs(above) - ROUNDING * abs(datum) / (grid.x * radius_meridian), 0.0);
    ivec2 to = texel(row, column);
    imageStore(normal_windows, ivec3(to, window_layer(window.z)), vec4(octahedron_encode(normalize(normal)), 0.0, 0.0));
    imageStore(convexity_windows, ivec3(to, convexity_layer(window.z)), vec4(above / (abs(above) + HALF_CONVEX), 0.0, 0.0, 0.0));
}
