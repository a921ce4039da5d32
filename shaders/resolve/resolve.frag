// Linear light to the screen: silhouettes smoothed along their direction, sRGB encoding, and a dither below one step so
// that neither sky nor night shows bands. The dither is a function of the pixel alone: frames stay deterministic.
layout(binding = 0) uniform sampler2D light;
layout(binding = 1) uniform sampler2D depth_buffer;

layout(location = 0) uniform int antialias;
layout(location = 0) in vec2 ndc;
layout(location = 0) out vec4 color;

float luma(vec3 c)
{
    return sqrt(min(dot(c, vec3(0.2126, 0.7152, 0.0722)), 4.0));
}

bool silhouette(ivec2 p, ivec2 last)
{
    float c = texelFetch(depth_buffer, p, 0).r;
    float a = texelFetch(depth_buffer, min(p + ivec2(1, 0), last), 0).r;
    float b = texelFetch(depth_buffer, max(p - ivec2(1, 0), ivec2(0)), 0).r;
    float d = texelFetch(depth_buffer, min(p + ivec2(0, 1), last), 0).r;
    float e = texelFetch(depth_buffer, max(p - ivec2(0, 1), ivec2(0)), 0).r;
    float low = min(min(a, b), min(min(c, d), e)), high = max(max(a, b), max(max(c, d), e));
    return high > 1.25 * low;
}

// Edge direction from the lumas of the diagonal neighbours, then an average along it (after Lottes' FXAA, 2009).
vec3 smoothed(ivec2 p, vec3 centre, ivec2 last)
{
    vec2 texel = 1.0 / vec2(last + 1), uv = (vec2(p) + 0.5) * texel;
    float nw = luma(textureLod(light, uv + vec2(-1, 1) * texel, 0.0).rgb), ne = luma(textureLod(light, uv + texel, 0.0).rgb);
    float sw = luma(textureLod(light, uv - texel, 0.0).rgb), se = luma(textureLod(light, uv + vec2(1, -1) * texel, 0.0).rgb);
    float m = luma(centre);
    float low = min(m, min(min(nw, ne), min(sw, se))), high = max(m, max(max(nw, ne), max(sw, se)));
    if (high - low < max(0.02, 0.1 * high)) return centre;
    vec2 dir = vec2((sw + se) - (nw + ne), (nw + sw) - (ne + se));
    float reduce = max((nw + ne + sw + se) * 0.03125, 0.0078125);
    dir = clamp(dir / (min(abs(dir.x), abs(dir.y)) + reduce), -8.0, 8.0) * texel;
    vec3 a = 0.5 * (textureLod(light, uv - dir / 6.0, 0.0).rgb + textureLod(light, uv + dir / 6.0, 0.0).rgb);
    vec3 b = 0.5 * a + 0.25 * (textureLod(light, uv - dir * 0.5, 0.0).rgb + textureLod(light, uv + dir * 0.5, 0.0).rgb);
    float l = luma(b);
    return l < low || l > high ? a : b;
}

float dither(ivec2 p)
{
    uint h = uint(p.x) * 0x9E3779B1u ^ uint(p.y) * 0x85EBCA77u;
    h = (h ^ (h >> 15)) * 0x2C1B3C6Du;
    h = (h ^ (h >> 12)) * 0x297A2D39u;
    return float((h ^ (h >> 15)) >> 8) * (1.0 / 16777216.0) - 0.5;
}

vec3 encode(vec3 c)
{
    c = clamp(c, 0.0, 1.0);
    return mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, greaterThan(c, vec3(0.0031308)));
}

void main()
{
    ivec2 p = ivec2(gl_FragCoord.xy), last = textureSize(light, 0) - 1;
    vec3 c = texelFetch(light, p, 0).rgb;
    if (antialias != 0 && silhouette(p, last)) c = smoothed(p, c, last);
    color = vec4(encode(c) + dither(p) / 255.0, 1.0);
}
