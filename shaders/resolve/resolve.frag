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

// Edge direction from the lumas of the diagonal neighbours, then an average along it (after Lottes' FXAA, 2009). `taps` is
// 4 on an edge and 0 elsewhere: the software driver runs both sides of an `if`, but skips a loop that no pixel enters.
vec3 smoothed(ivec2 p, vec3 centre, ivec2 last, int taps)
{
    vec2 texel = 1.0 / vec2(last + 1), uv = (vec2(p) + 0.5) * texel;
    float low = luma(centre), high = low, sum = 0.0;
    vec2 dir = vec2(0.0);
    for (int i = 0; i < taps; i++) {
        vec2 corner = vec2((i & 1) * 2 - 1, (i & 2) - 1);
        float l = luma(textureLod(light, uv + corner * texel, 0.0).rgb);
        dir += vec2(-corner.y, corner.x) * l; // along the edge: across the gradient
        low = min(low, l);
        high = max(high, l);
        sum += l;
    }
    if (high - low < max(0.02, 0.1 * high)) taps = 0;
    float reduce = max(sum * 0.03125, 0.0078125);
    dir = clamp(dir / (min(abs(dir.x), abs(dir.y)) + reduce), -8.0, 8.0) * texel;
    vec3 inner = vec3(0.0), outer = vec3(0.0);
    for (int i = 0; i < taps; i++) {
        vec3 c = textureLod(light, uv + dir * ((float(i) - 1.5) / 3.0), 0.0).rgb;
        if (i == 0 || i == 3) outer += c;
        else inner += c;
    }
    if (taps == 0) return centre;
    vec3 wide = 0.25 * (inner + outer);
    float l = luma(wide);
    return l < low || l > high ? 0.5 * inner : wide;
}

float dither(ivec2 p)
{
    uint h = uint(p.x) * 0x9E3779B1u ^ uint(p.y) * 0x85EBCA77u;
    h = (h ^ (h >> 15)) * 0x2C1B3C6Du;
    h = (h ^ (h >> 12)) * 0x297A2D39u;
    return float((h ^ (h >> 15)) >> 8) * (1.0 / 16777216.0) - 0.5;
}

// sRGB encoding by square roots, within 0.25/255 of the power law (the software driver's pow takes half a frame).
vec3 encode(vec3 c)
{
    c = clamp(c, 0.0, 1.0);
    vec3 r2 = sqrt(c), r4 = sqrt(r2), r8 = sqrt(r4);
    vec3 curve = 0.662002687 * r2 + 0.684122060 * r4 - 0.323583601 * r8 - 0.0225411470 * c;
    return mix(12.92 * c, curve, greaterThan(c, vec3(0.0031308)));
}

void main()
{
    ivec2 p = ivec2(gl_FragCoord.xy), last = textureSize(light, 0) - 1;
    vec3 c = texelFetch(light, p, 0).rgb;
    c = smoothed(p, c, last, antialias != 0 && silhouette(p, last) ? 4 : 0);
    color = vec4(encode(c) + dither(p) / 255.0, 1.0);
}
