// Every pixel of planet and sky. Graphics cards of data centres have a thirtieth of their processors for fragments, all for this.
#include "shade/ground.glsl"
#include "shade/sky.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0, rgba16f) writeonly uniform image2D light_buffer;

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(light_buffer);
    if (pixel.x >= size.x || pixel.y >= size.y) return;
    vec2 ndc = (2.0 * vec2(pixel) + 1.0) / vec2(size) - 1.0;
    vec3 ray = view.ray_centre.xyz + ndc.x * view.ray_right.xyz + ndc.y * view.ray_up.xyz;
    float depth = texelFetch(depth_buffer, pixel, 0).r;
    vec4 color;
    if (depth == 0.0) color = sky(ray);
    else if (!ground(pixel, ray, depth, color)) return;
    imageStore(light_buffer, pixel, color);
}
