// The left picture beside the right one, pixel upon pixel; in the lowest rows how far they differ, amplified.
layout(binding = 0) uniform sampler2D left;
layout(binding = 1) uniform sampler2D right;

layout(location = 0) uniform ivec2 edges; // first column of the right picture, rows of the difference
layout(location = 1) uniform float gain;
layout(location = 0) out vec4 color;

void main()
{
    ivec2 p = ivec2(gl_FragCoord.xy);
    vec3 a = texelFetch(left, p, 0).rgb, b = texelFetch(right, p, 0).rgb;
    vec3 c = p.y < edges.y ? min(gain * abs(a - b), 1.0) : p.x < edges.x ? a : b;
    bool line = p.y >= edges.y && (p.x == edges.x || (edges.y > 0 && p.y == edges.y));
    color = vec4(line ? vec3(1.0) : c, 1.0);
}
