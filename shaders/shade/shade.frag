// Every pixel of the planet, or with SKY every other, by full-screen triangles that the depth test cuts out.
layout(location = 0) in vec2 ndc;
layout(location = 0) out vec4 color;

#ifdef SKY
#include "shade/sky.glsl"
#else
#include "shade/ground.glsl"
#endif

void main()
{
    vec3 ray = view.ray_centre.xyz + ndc.x * view.ray_right.xyz + ndc.y * view.ray_up.xyz;
#ifdef SKY
    color = sky(ray);
#else
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    if (!ground(pixel, ray, texelFetch(depth_buffer, pixel, 0).r, color)) discard;
#endif
}
