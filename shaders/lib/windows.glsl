// Sampling the clipmap windows: bilinear in full float precision inside a level, a chain of levels from fine to coarse.
// A level's weight falls to zero at the border of what it holds, so that a late level is never a hole and never an edge.
#include "lib/blocks.glsl"
#include "lib/layers.glsl"

layout(binding = 0) uniform sampler2DArray height_windows;

#define RAMP_TEXELS 4.0
#define RAMP_EDGE 1.5          /* texels that a fetch of four by four reaches out */
#define TRANSITION 0.2 /* outer share of a level (in levels) blended with the next coarser */

// Window coordinates (row, column) of a place given relative to the focus.
vec2 window_place(vec4 map, vec2 dlonlat)
{
    return vec2(map.z - dlonlat.y * map.x, map.w + dlonlat.x * map.y);
}

float window_weight(vec4 valid, float fade, vec2 place)
{
    float inside = min(min(place.x - valid.x, valid.y - place.x), min(place.y - valid.z, valid.w - place.y));
    return fade * clamp((inside - RAMP_EDGE) / RAMP_TEXELS, 0.0, 1.0);
}

// Texel (column, row) of a window sample; rows may lie one window before or after.
ivec2 window_texel(ivec2 sample_rc, vec4 torus, ivec2 size)
{
    int row = sample_rc.x + int(torus.x);
    row = row >= size.y ? row - size.y : row < 0 ? row + size.y : row;
    return ivec2((sample_rc.y + int(torus.y)) & (size.x - 1), row);
}

float window_height(int level, vec2 place)
{
    vec4 torus = levels.height_torus[level];
    ivec2 size = textureSize(height_windows, 0).xy;
#ifdef HARDWARE_FILTER
    return textureLod(height_windows, vec3((place.yx + torus.yx) / vec2(size), float(window_layer(level))), 0.0).r;
#else
    // From the nearest sample, so that only what the others differ by is weighed, by a half at most: one rounding at the
    // height's own size, and level ground stays level to the last bit.
    vec2 nearest = floor(place), f = place - nearest - 0.5;
    int layer = window_layer(level);
    ivec2 rc = ivec2(nearest), aside = ivec2(f.x < 0.0 ? -1 : 1, f.y < 0.0 ? -1 : 1);
    f = abs(f);
    float h = texelFetch(height_windows, ivec3(window_texel(rc, torus, size), layer), 0).r;
    float h_row = texelFetch(height_windows, ivec3(window_texel(rc + ivec2(aside.x, 0), torus, size), layer), 0).r;
    float h_col = texelFetch(height_windows, ivec3(window_texel(rc + ivec2(0, aside.y), torus, size), layer), 0).r;
    float h_both = texelFetch(height_windows, ivec3(window_texel(rc + aside, torus, size), layer), 0).r;
    precise float d_row = h_row - h, d_col = h_col - h;
    precise float between = h + (f.x * d_row + f.y * (d_col + f.x * (h_both - h_col - d_row)));
    return between;
#endif
}

// What a height has lost, in second differences of the samples along an axis. The pyramid's filter has a variance of 0.42^2
// samples a zoom (planet/filter.h), all zooms together 4/3 of that, and takes half of it from a parabola: 0.118; straight
// lines between samples take 1/12 in the mean.
#define TAKEN 0.2

// Weights of four samples along an axis at f in [0, 1] between the middle two: linear, of samples that have back what was taken.
vec4 sharp_weights(float f)
{
    float b = 1.0 - f;
    return vec4(-TAKEN * b, b + TAKEN * (2.0 * b - f), f + TAKEN * (2.0 * f - b), -TAKEN * f);
}

// As window_height, sharpened: so that triangles between vertices a sample apart lie on the ground in the mean, not under
// its ridges and over its valleys.
float sharp_height(int level, vec2 place)
{
    vec2 size = vec2(textureSize(height_windows, 0).yx), base = floor(place - 0.5), f = place - 0.5 - base;
    // Gathers about the corner of four samples, far from where their choice would be in doubt.
    vec2 first = (base + levels.height_torus[level].xy) / size, next = first + 2.0 / size;
    float layer = float(window_layer(level));
    vec4 a = textureGather(height_windows, vec3(first.y, first.x, layer)), b = textureGather(height_windows, vec3(next.y, first.x, layer)),
         c = textureGather(height_windows, vec3(first.y, next.x, layer)), d = textureGather(height_windows, vec3(next.y, next.x, layer));
    // From the nearest sample, as there.
    float h = f.x < 0.5 ? (f.y < 0.5 ? a.y : b.x) : (f.y < 0.5 ? c.z : d.w);
    vec4 row = sharp_weights(f.x), column = sharp_weights(f.y);
    mat4 rest = mat4(a.w, a.z, b.w, b.z, a.x, a.y, b.x, b.y, c.w, c.z, d.w, d.z, c.x, c.y, d.x, d.y) - h;
    return h + dot(column, rest * row);
}

#ifndef CHAIN_SAMPLE
#define CHAIN_SAMPLE window_height
#endif

// Share of the next coarser level at a fraction f in [0, 1] of the way in from a level's outer ring.
float transition_to_coarser(float f)
{
    return clamp(1.0 - f / TRANSITION, 0.0, 1.0);
}

// Height in metres at a place, `level` whole, `coarser` the share of the next coarser level (level 0 has none).
float chain_height(vec2 dlonlat, int level, float coarser)
{
    // The finest height there is, and what the coarser ones differ by: as in window_height.
    float finest = 0.0, sum = 0.0, rest = 1.0, keep = level == 0 ? 1.0 : 1.0 - coarser;
    for (int i = level; i >= 0; i--) {
        vec2 place = window_place(levels.height_map[i], dlonlat);
        float w = keep * window_weight(levels.height_valid[i], levels.height_torus[i].z, place);
        keep = 1.0;
        if (w > 0.0) {
            float h = CHAIN_SAMPLE(i, place);
            if (rest == 1.0) finest = h;
            sum += rest * w * (h - finest);
            rest *= 1.0 - w;
        }
        if (rest <= 0.0) break;
    }
    return finest + (sum - rest * finest);
}
