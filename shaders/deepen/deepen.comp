// Heights of a level below the data, made from the next coarser level's: four-point upsampling and what synthesis adds, as
// src/planet makes its tiles (upsample.c, synthesis.c). Columns of the finer level are half as wide as the coarser's.
#include "lib/layers.glsl"
#include "shared/synthesis.glsl"

layout(local_size_x = 32, local_size_y = 4) in;

layout(binding = 0) uniform sampler2DArray height_windows;
layout(binding = 0, r32f) writeonly uniform image2DArray finer_heights;

struct Row {
    double scale; // cells a unit of the columns' cosines and sines
    uint hz;      // of the lattice, along the axis
    float z;
    float sin_lat, cos_lat; // of the finer row
    float shape[2]; // of a column's length to a row's, on the coarser rows [1, 2] of the four
    float weight[4], factor[4]; // of differences along the four coarser rows: see synthesis_ground.c
};
// By texel of the finer level.
layout(std430, binding = 0) readonly buffer Rows { Row rows[]; };
layout(std430, binding = 1) readonly buffer Columns { dvec2 columns[]; }; // cosine and sine of the longitude

layout(location = 0) uniform ivec4 rect;   // texture row and column of the first sample; rows, columns
layout(location = 1) uniform ivec4 coarse; // texture row and column of the first tap; 1 where the first row, column is odd
layout(location = 2) uniform int level;    // the finer
layout(location = 3) uniform vec3 scale;   // steep, least, share
layout(location = 4) uniform dvec2 shift;  // of the lattice, in cells

float h[16]; // the coarser samples, four rows of four

// Weights of the four-point filter for a point a quarter before the third sample, or after the second.
vec4 taps(bool after)
{
    return after ? vec4(-9.0, 111.0, 29.0, -3.0) / 128.0 : vec4(-3.0, 29.0, 111.0, -9.0) / 128.0;
}

float square(float x)
{
    return x * x;
}

// Amplitude, bend and wave vector at the inner sample (y, x), each 1 or 2.
vec4 signs(Row r, int y, int x)
{
    int i = 4 * y + x;
    float sum = 0.0, weights = 6.0;
    for (int k = -1; k <= 1; k++) {
        int j = i + 4 * k;
        sum += r.factor[y + k] * (square(h[j] - h[j - 1]) + square(h[j + 1] - h[j]));
        weights += 2.0 * r.weight[y + k];
        j = i + k;
        sum += square(h[j] - h[j - 4]) + square(h[j + 4] - h[j]);
    }
    float relief = sqrt(sum / weights);
    float north = 0.5 * (h[i - 4] - h[i + 4]);
    float east = 0.5 / max(r.shape[y - 1], 0.5) * (h[i + 1] - h[i - 1]);
    float bend = 0.25 * ((h[i - 4] - h[i]) + (h[i + 4] - h[i]) +
                         r.weight[y] * ((h[i - 1] - h[i]) + (h[i + 1] - h[i])));
    float k = stripe_number(north, east, relief, scale.y);
    return vec4(scale.z * synthesis_tempered(relief, scale.x, scale.y), bend, -k * north, k * east);
}

float noise(Row r, dvec2 column, vec4 s)
{
    dvec2 p = column * r.scale + shift;
    uvec2 cell = uvec2(p);
    vec2 at = vec2(p - dvec2(cell));
    cell *= uvec2(NOISE_PRIME_X, NOISE_PRIME_Y);
#ifdef ERODED
    vec2 cs = vec2(column);
    float inward = s.w * r.sin_lat;
    return stripe_noise(cell.x, cell.y, r.hz, at.x, at.y, r.z, -s.z * cs.y - inward * cs.x,
                        s.z * cs.x - inward * cs.y, s.w * r.cos_lat);
#else
    return gradient_noise(cell.x, cell.y, r.hz, at.x, at.y, r.z);
#endif
}

float made_at(ivec2 at, ivec2 to)
{
    ivec2 size = textureSize(height_windows, 0).xy;
    ivec2 fine = at + coarse.wz, first = coarse.yx + fine / 2 + (fine & 1);
    for (int y = 0; y < 4; y++)
        for (int x = 0; x < 4; x++) {
            ivec2 texel = ivec2((first.x + x) & (size.x - 1), (first.y + y) % size.y);
            h[4 * y + x] = texelFetch(height_windows, ivec3(texel, window_layer(level - 1)), 0).r;
        }
    if (h[5] == h[6] && h[5] == h[9] && h[5] == h[10]) return h[5];
    bool south = (fine.y & 1) != 0, east = (fine.x & 1) != 0;
    vec4 v = taps(south), u = taps(east);
    vec4 across = v.x * vec4(h[0], h[1], h[2], h[3]) + v.y * vec4(h[4], h[5], h[6], h[7]) +
                  v.z * vec4(h[8], h[9], h[10], h[11]) + v.w * vec4(h[12], h[13], h[14], h[15]);
    float up = u.x * across.x + u.y * across.y + u.z * across.z + u.w * across.w;
    Row r = rows[to.y];
    float b = south ? 0.25 : 0.75, a = east ? 0.25 : 0.75;
    vec4 s = mix(mix(signs(r, 1, 1), signs(r, 1, 2), a), mix(signs(r, 2, 1), signs(r, 2, 2), a), b);
    float n = noise(r, columns[to.x], s);
#ifdef ERODED
    float change = synthesis_eroded(s.y, s.x, n);
#else
    float change = s.x * n;
#endif
    float base = h[0];
    for (int i = 1; i < 16; i++) base = min(base, h[i]);
    return s.x > 0.0 ? synthesis_limited(up, base, change) : up;
}

void main()
{
    ivec2 at = ivec2(gl_GlobalInvocationID.xy); // column, row
    if (at.x >= rect.w || at.y >= rect.z) return;
    ivec2 size = textureSize(height_windows, 0).xy;
    ivec2 to = ivec2((rect.y + at.x) & (size.x - 1), (rect.x + at.y) % size.y);
    imageStore(finer_heights, ivec3(to, window_layer(level)), vec4(made_at(at, to), 0.0, 0.0, 0.0));
}
