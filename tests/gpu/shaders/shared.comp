// Every shared function over a list of cases, in the GPU's own floats (tests/gpu/test_shared.c).
#include "shared/atan.glsl"
#include "shared/position.glsl"
#include "shared/transform.glsl"

layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer Inputs { float inputs[]; };
layout(std430, binding = 1) writeonly buffer Outputs { float outputs[]; };

layout(location = 0) uniform uint count;

void main()
{
    uint id = gl_GlobalInvocationID.x;
    if (id >= count) return;
    uint i = id * INPUTS, o = id * OUTPUTS;
    float n = inputs[i], e = inputs[i + 1u], v = inputs[i + 2u];
    float cb = inputs[i + 3u], sb = inputs[i + 4u], r = inputs[i + 5u], lat = inputs[i + 6u];
    float stretch = inputs[i + 7u], dlat_db = inputs[i + 8u], w = inputs[i + 9u];
    float dlon, dlat, x, y, z;
    map_transform_stable(n, e, v, cb, sb, r, dlon, dlat);
    outputs[o] = dlon;
    outputs[o + 1u] = dlat;
    map_transform_exact(n, e, v, cb, sb, r, lat, dlon, dlat);
    outputs[o + 2u] = dlon;
    outputs[o + 3u] = dlat;
    map_transform_approx(n, e, v, stretch, dlat_db, dlon, dlat);
    outputs[o + 4u] = dlon;
    outputs[o + 5u] = dlat;
    map_transform_blend(n, e, v, cb, sb, r, lat, stretch, dlat_db, w, dlon, dlat);
    outputs[o + 6u] = dlon;
    outputs[o + 7u] = dlat;
    uint p = i + 13u;
    place_frame f = place_frame(inputs[p], inputs[p + 1u], inputs[p + 2u], inputs[p + 3u], inputs[p + 4u], inputs[p + 5u],
                                inputs[p + 6u], inputs[p + 7u], inputs[p + 8u], inputs[p + 9u], inputs[p + 10u],
                                inputs[p + 11u], inputs[p + 12u], inputs[p + 13u], inputs[p + 14u], inputs[p + 15u]);
    relative_position(f, n, e, v, inputs[i + 10u], x, y, z);
    outputs[o + 8u] = x;
    outputs[o + 9u] = y;
    outputs[o + 10u] = z;
    outputs[o + 11u] = atan_ratio(inputs[i + 11u], inputs[i + 12u]);
}
