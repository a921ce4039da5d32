// A window whose share of the circle doubles or halves keeps what it has, in place: a column of each pair, their mean; or two
// of each column. A group has a row to itself, and reads all of it before it writes.
#include "lib/layers.glsl"

layout(local_size_x = 128) in;

layout(location = 0) uniform ivec4 rect;   // texture row and column of the first sample made; rows, columns
layout(location = 1) uniform ivec3 source; // texture column of the first it is made of; 1: the second made of that; 1: pairs
layout(location = 2) uniform int level;

#ifdef COLORS
#define PIXEL(x) uvec4(x, 0u, 0u, 0u)
layout(binding = 0, r32ui) uniform uimage2DArray windows; // sRGB, A too: as the workers' means (src/clipmap/fill.c)
shared uint line[COLUMNS];

float linear(float code)
{
    return code <= 0.04045 ? code / 12.92 : pow((code + 0.055) / 1.055, 2.4);
}

float encoded(float light)
{
    return light <= 0.0031308 ? light * 12.92 : 1.055 * pow(light, 1.0 / 2.4) - 0.055;
}

uint pair(uint a, uint b)
{
    vec4 p = unpackUnorm4x8(a), q = unpackUnorm4x8(b);
    for (int i = 0; i < 4; i++) p[i] = encoded(0.5 * (linear(p[i]) + linear(q[i])));
    return packUnorm4x8(p);
}

// Pairs of columns are what is shown where the share is about to change (window_color of shade/ground.glsl).
uint quarter_on(uint before, uint at, uint next, uint after)
{
    return at;
}

int layer()
{
    return level;
}
#else
#define PIXEL(x) vec4(x, 0.0, 0.0, 0.0)
layout(binding = 0, r32f) uniform image2DArray windows;
shared float line[COLUMNS];

float pair(float a, float b)
{
    return 0.5 * (a + b);
}

// The cubic through four samples, a quarter on from the second.
float quarter_on(float before, float at, float next, float after)
{
    return at + (-9.0 * (before - at) + 29.0 * (next - at) - 3.0 * (after - at)) / 128.0;
}

int layer()
{
    return window_layer(level);
}
#endif

void main()
{
    int row = (rect.x + int(gl_WorkGroupID.x)) % imageSize(windows).y, last = COLUMNS - 1;
    for (int i = int(gl_LocalInvocationID.x); i < COLUMNS; i += 128) line[i] = imageLoad(windows, ivec3(i, row, layer())).r;
    barrier();
    for (int i = int(gl_LocalInvocationID.x); i < rect.w; i += 128) {
        ivec3 to = ivec3((rect.y + i) & last, row, layer());
        int second = source.y + i, from = source.x + (source.z != 0 ? 2 * i : second / 2), east = (second & 1) != 0 ? 1 : -1;
        imageStore(windows, to,
                   PIXEL(source.z != 0 ? pair(line[from & last], line[(from + 1) & last])
                                       : quarter_on(line[(from - east) & last], line[from & last], line[(from + east) & last],
                                                    line[(from + 2 * east) & last])));
    }
}
