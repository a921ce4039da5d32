// Light of the planet in one pixel: map coordinates from the ring coordinates, exactly here; colour, normal and light from there.
#include "lib/map.glsl"
#include "lib/windows.glsl"
#include "lib/octahedron.glsl"
#include "lib/atmosphere.glsl"

layout(binding = 1) uniform sampler2DArray normal_windows;
layout(binding = 2) uniform sampler2DArray color_windows;
layout(binding = 3) uniform sampler2D ring_buffer;
layout(binding = 4) uniform sampler2D depth_buffer;
#ifdef TEXCOORD_VERTEX
layout(binding = 5) uniform sampler2D map_buffer;
#endif

layout(binding = 6) uniform sampler2DArray convexity_windows;

#ifdef KEPT_LEVELS
layout(location = 0) uniform ivec2 shaded; // first and last level of normals that this pass is for
#endif

#define CONVEX_CONTRAST 0.6
#define LAMP_FLOOR 0.2 /* encoded light of unlit land in night imagery */

const float PI = 3.14159265358979;

vec3 window_normal(int level, vec2 place)
{
    vec4 torus = levels.height_torus[level];
    ivec2 size = textureSize(normal_windows, 0).xy;
    vec2 p = place - 0.5;
    vec2 base = floor(p);
    vec2 f = p - base;
    ivec2 rc = ivec2(base);
    int layer = window_layer(level);
    vec3 n00 = octahedron_decode(texelFetch(normal_windows, ivec3(window_texel(rc, torus, size), layer), 0).rg);
    vec3 n01 = octahedron_decode(texelFetch(normal_windows, ivec3(window_texel(rc + ivec2(0, 1), torus, size), layer), 0).rg);
    vec3 n10 = octahedron_decode(texelFetch(normal_windows, ivec3(window_texel(rc + ivec2(1, 0), torus, size), layer), 0).rg);
    vec3 n11 = octahedron_decode(texelFetch(normal_windows, ivec3(window_texel(rc + ivec2(1, 1), torus, size), layer), 0).rg);
    return mix(mix(n00, n01, f.y), mix(n10, n11, f.y), f.x);
}

// ECEF normal; `up` (ECEF) where no level is there yet.
vec3 chain_normal(vec2 dlonlat, float level, vec3 up)
{
    vec3 sum = vec3(0.0);
    float rest = 1.0;
    float keep = level < 1.0 ? 1.0 : 1.0 - transition_to_coarser(fract(level));
    for (int i = int(level); i >= 0; i--) {
        vec2 place = window_place(levels.height_map[i], dlonlat);
        float w = keep * window_weight(levels.height_valid[i], levels.height_torus[i].z, place);
        keep = 1.0;
        if (w > 0.0) {
            sum += rest * w * window_normal(i, place);
            rest *= 1.0 - w;
        }
        if (rest <= 0.0) break;
    }
    return normalize(sum + rest * up);
}

float window_convexity(int level, vec2 dlonlat)
{
    level = max(level, 0);
    vec2 place = window_place(levels.height_map[level], dlonlat);
    float w = window_weight(levels.height_valid[level], levels.height_torus[level].z, place);
    vec2 uv = (place.yx + levels.height_torus[level].yx) / vec2(textureSize(convexity_windows, 0).xy);
    return w * textureLod(convexity_windows, vec3(uv, float(convexity_layer(level))), 0.0).r;
}

// How convex the ground is, in [-1, 1]: at the scale of the given level and at one eight times coarser, both going over
// to the next coarser level as the heights do. A loop, because software drivers skip a loop that no pixel is in.
float convexity(vec2 dlonlat, float level)
{
    int i = int(level);
    float coarser = transition_to_coarser(fract(level)), sum = 0.0, weight = 1.0 - coarser;
    for (int k = 0; k < (coarser > 0.0 ? 2 : 1); k++) {
        sum += weight * (window_convexity(i - k, dlonlat) + window_convexity(i - k - 3, dlonlat));
        weight = coarser;
    }
    return 0.5 * sum;
}

// As the columns' share of the circle is about to change, the colour goes over to what the window of half as many columns
// will show there: pairs of them, each pair's mean being a texture fetch in its middle. So nothing shows when it changes.
vec4 window_color(int level, vec2 place)
{
    vec4 torus = levels.color_torus[level], valid = levels.color_valid[level];
    vec2 size = vec2(textureSize(color_windows, 0).xy), at = place.yx + torus.yx;
    vec4 color = textureLod(color_windows, vec3(at / size, float(level)), 0.0);
    float pair = 0.5 * at.x - 0.5, first = floor(pair);
    vec4 paired = vec4(0.0);
    for (int k = 0; k < (torus.w > 0.0 ? 2 : 0); k++) { // a loop, because software drivers skip a loop that no pixel is in
        float middle = clamp(2.0 * (first + float(k)) + 1.0 - torus.y, valid.z + 1.0, valid.w - 1.0) + torus.y;
        float share = k == 0 ? 1.0 - (pair - first) : pair - first;
        paired += share * textureLod(color_windows, vec3(vec2(middle, at.y) / size, float(level)), 0.0);
    }
    return mix(color, paired, torus.w);
}

// Linear colour, and in a the night's light.
vec4 chain_color(vec2 dlonlat, float level)
{
    vec4 sum = vec4(0.0);
    float rest = 1.0, keep = level < 1.0 ? 1.0 : fract(level);
    for (int i = int(level); i >= 0; i--) {
        vec2 place = window_place(levels.color_map[i], dlonlat);
        float w = keep * window_weight(levels.color_valid[i], levels.color_torus[i].z, place);
        keep = 1.0;
        if (w > 0.0) {
            sum += rest * w * window_color(i, place);
            rest *= 1.0 - w;
        }
        if (rest <= 0.0) break;
    }
    return sum + rest * vec4(0.12, 0.13, 0.12, 0.0);
}

vec3 scaled(vec3 v)
{
    return v / vec3(view.axes.x, view.axes.x, view.axes.y);
}

vec3 ecef_of_meridian(vec3 v)
{
    float c = view.sun.w, s = view.atmosphere.w;
    return vec3(c * v.x - s * v.y, s * v.x + c * v.y, v.z);
}

// The planet where `ray` meets it; false where its level is not this pass's.
bool ground(ivec2 pixel, vec3 ray, float depth, out vec4 color)
{
    vec3 position = ray * (view.screen.z / depth); // meridian frame, from the camera
    float distance = length(position);
    vec3 unit = view.camera.xyz + scaled(position);
    vec2 ne = texelFetch(ring_buffer, pixel, 0).rg;
#ifdef FLAT
    float v = 0.0, angle = ring_angle(length(ne), 1.0);
#else
    float ss = min(dot(ne, ne), 1.0), cosine = sqrt(1.0 - ss), v = ss / (1.0 + cosine);
    if (dot(unit, vec3(view.focus.x, 0.0, view.focus.y)) < 0.0) {
        cosine = -cosine;
        v = 2.0 - v;
    }
    float angle = ring_angle(sqrt(ss), cosine);
#endif
    float ring_level = log2(PI / angle);
#ifdef TEXCOORD_VERTEX
    vec2 dlonlat = texelFetch(map_buffer, pixel, 0).rg;
#else
    vec2 dlonlat = map_of_ring(vec3(ne, v), ring_level);
#endif
#ifdef FLAT
    vec3 up = vec3(1.0, 0.0, 0.0);
#else
    vec3 up = normalize(unit);
#endif
    vec3 to_eye = -position / distance;
    float footprint = distance * view.screen.w * inversesqrt(clamp(dot(up, to_eye), 0.04, 1.0));
    float fine = log2(2.0 * PI * view.axes.x / footprint); // level of one sample across a turn / footprint
    float height_rows = levels.height_map[0].x * PI, color_rows = levels.color_map[0].x * PI;
    float normal_level = clamp(min(ring_level + view.axes.z, fine - log2(height_rows)), 0.0, float(view.layers.x) + 0.999);
#ifdef KEPT_LEVELS
    if (int(normal_level) < shaded.x || int(normal_level) > shaded.y) return false;
#endif
    float color_level = clamp(min(ring_level, fine - log2(color_rows) + 1.0), 0.0, float(view.layers.y) + 0.999);

    vec3 up_ecef = ecef_of_meridian(up), sun_ecef = ecef_of_meridian(view.sun.xyz);
    vec3 normal = chain_normal(dlonlat, normal_level, up_ecef);
    vec4 texel = chain_color(dlonlat, color_level);
    float steep = 1.0 - dot(normal, up_ecef);
    vec3 albedo = mix(texel.rgb, vec3(0.14, 0.12, 0.10), 0.55 * smoothstep(0.10, 0.45, steep));
    albedo *= 1.0 + CONVEX_CONTRAST * convexity(dlonlat, normal_level); // hollows hold soil and shade, crests are bare

    float lit = daylight(up, view.sun.xyz);
    float direct = max(dot(normal, sun_ecef), 0.0) * lit;
    vec3 light = 1.6 * direct + vec3(0.16, 0.19, 0.25) * lit + 0.004;
    float lamps = max(texel.a - LAMP_FLOOR, 0.0) / (1.0 - LAMP_FLOOR);
    vec3 surface = albedo * light + lamps * lamps * (1.0 - lit) * vec3(1.0, 0.78, 0.45);
    vec3 through;
    vec3 dir = scaled(position);
    float t = length(dir);
    vec3 haze = air_scatter(dir / t, t, lit, dot(-to_eye, view.sun.xyz), through);
    color = vec4(surface * through + haze, 1.0);
    return true;
}
