// Heights of a window that come as residuals: the next coarser window's, doubled, and what they add to that, in whole quanta
// (Asirvatham & Hoppe 2005, 2.4.1-2). The same bits as a worker's (src/clipmap/residual.c).
#include "lib/layers.glsl"
#include "shared/residual.glsl"

layout(local_size_x = 32, local_size_y = 4) in;

layout(binding = 0) uniform sampler2DArray height_windows;
layout(binding = 1) uniform isampler2DArray residuals;
layout(binding = 0, r32f) writeonly uniform image2DArray finer_heights;

layout(location = 0) uniform ivec4 rect;   // texture row and column of the first sample; rows, columns
layout(location = 1) uniform ivec4 coarse; // texture row and column of the first tap; 1 where the first row, column is odd
layout(location = 2) uniform int level;    // the finer
layout(location = 3) uniform vec2 quantum; // m, and 1 / m

uint quanta_at(ivec2 at) // row, column from the first tap
{
    ivec2 size = textureSize(height_windows, 0).xy;
    ivec3 texel = ivec3((coarse.y + at.y) & (size.x - 1), (coarse.x + at.x) % size.y, window_layer(level - 1));
    return uint(int(texelFetch(height_windows, texel, 0).r * quantum.y));
}

// In a column of the coarser window.
uint predicted_row(ivec2 first, bool south, int column)
{
    uint h[4];
    for (int i = 0; i < 4; i++) h[i] = quanta_at(first + ivec2(i, column));
    return south ? quarter_past(h[0], h[1], h[2], h[3]) : quarter_past(h[3], h[2], h[1], h[0]);
}

void main()
{
    ivec2 at = ivec2(gl_GlobalInvocationID.xy); // column, row
    if (at.x >= rect.w || at.y >= rect.z) return;
    ivec2 size = textureSize(height_windows, 0).xy;
    ivec2 fine = at.yx + coarse.zw, first = fine / 2 + (fine & 1) - coarse.zw, odd = fine & 1;
    uint h[4];
    for (int i = 0; i < 4; i++) h[i] = predicted_row(first, odd.x != 0, i);
    uint up = odd.y != 0 ? quarter_past(h[0], h[1], h[2], h[3]) : quarter_past(h[3], h[2], h[1], h[0]);
    int sum = int(up + uint(texelFetch(residuals, ivec3(at, 0), 0).r));
    ivec2 to = ivec2((rect.y + at.x) & (size.x - 1), (rect.x + at.y) % size.y);
    imageStore(finer_heights, ivec3(to, window_layer(level)), vec4(float(sum) * quantum.x, 0.0, 0.0, 0.0));
}
