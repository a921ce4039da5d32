// Every pixel that shows no planet: black, with the glow of the air that the ray passes.
#include "lib/atmosphere.glsl"

layout(location = 0) in vec2 ndc;
layout(location = 0) out vec4 color;

void main()
{
    vec3 ray = view.ray_centre.xyz + ndc.x * view.ray_right.xyz + ndc.y * view.ray_up.xyz;
    vec3 dir = normalize(ray / vec3(view.axes.x, view.axes.x, view.axes.y));
    float along = -dot(view.camera.xyz, dir);
    vec3 densest = view.camera.xyz + max(along, 0.0) * dir;
    vec3 through;
#ifdef FLAT
    float lit = daylight(vec3(1.0, 0.0, 0.0), view.sun.xyz);
#else
    float lit = daylight(normalize(densest), view.sun.xyz);
#endif
    color = vec4(air_scatter(dir, -1.0, lit, dot(normalize(ray), view.sun.xyz), through), 0.0);
}
