// Light of a pixel that shows no planet: black, with the glow of the air that the ray passes.
#include "lib/atmosphere.glsl"

vec4 sky(vec3 ray)
{
    vec3 dir = normalize(ray / vec3(view.axes.x, view.axes.x, view.axes.y));
    float along = -dot(view.camera.xyz, dir);
    vec3 densest = view.camera.xyz + max(along, 0.0) * dir;
    vec3 through;
#ifdef FLAT
    float lit = daylight(vec3(1.0, 0.0, 0.0), view.sun.xyz);
#else
    float lit = daylight(normalize(densest), view.sun.xyz);
#endif
    return vec4(air_scatter(dir, -1.0, lit, dot(normalize(ray), view.sun.xyz), through), 0.0);
}
