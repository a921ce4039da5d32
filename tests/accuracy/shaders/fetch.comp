// The fetches of the height windows over a list of cases (tests/accuracy/fetch_kernel.c).
#include "lib/windows.glsl"

layout(local_size_x = 64) in;

struct Case {
    vec4 map;     // of a window, for window_place alone
    vec2 dlonlat; // for window_place and for chain_height
    vec2 place;   // for window_height
    float coarser, level, unused_1, unused_2;
};
layout(std430, binding = 0) readonly buffer Cases { Case cases[]; };
layout(std430, binding = 1) writeonly buffer Results { vec4 results[]; }; // bilinear, trilinear, place

layout(location = 0) uniform uint count;

void main()
{
    uint i = gl_GlobalInvocationID.x;
    if (i >= count) return;
    Case c = cases[i];
    int level = int(c.level);
    float trilinear = chain_height(c.dlonlat, level, c.coarser);
    results[i] = vec4(window_height(level, c.place), trilinear, window_place(c.map, c.dlonlat));
}
