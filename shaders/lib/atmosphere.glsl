// A thin exponential atmosphere in closed form: a limb glow from space, a sky and haze from within.
// Lengths in planet radii of the scaled space, where the ellipsoid is the unit sphere; H is the scale height there.
// Optical depth by the Chapman function in Schueler's approximation (GPU Pro 3, 2012), 1 for the vertical at the surface.
#include "lib/blocks.glsl"

#define RAYLEIGH vec3(0.046, 0.108, 0.265) /* vertical optical depth at 680, 550, 440 nm */
#define AIR_RADIANCE 0.40 /* of a thick layer; 3/16 of the sun's 1.6 for single scattering, raised for the multiple */

// From a point at `height` (radii above the surface) towards a direction of cosine mu to the vertical, to infinity.
float optical_depth(float height, float mu)
{
    float x = view.atmosphere.y, hh = height * view.atmosphere.x;
    float c = sqrt(x + hh);
    float down = c / (c * abs(mu) + 1.0) * exp(-hh);
    if (mu >= 0.0) return down;
    float x0 = sqrt(max(1.0 - mu * mu, 0.0)) * (x + hh);
    return 2.0 * sqrt(x0) * exp(clamp(x - x0, -80.0, 10.0)) - down;
}

float daylight(vec3 up, vec3 sun)
{
    return smoothstep(-0.12, 0.2, dot(up, sun));
}

// Light scattered into the ray and what it lets through. `dir` unit in scaled space, `t` its length (< 0: infinite);
// `lit` is the daylight where the ray is densest. Before terrain the air is thinned by TERRAIN_AIR, clearer than in nature,
// so that the ground is seen.
#define TERRAIN_AIR 0.35
vec3 air_scatter(vec3 dir, float t, float lit, float cos_sun, out vec3 through)
{
    float h = view.camera.w;
    float r = 1.0 + h;
    float mu = dot(view.camera.xyz, dir) / r;
#ifdef FLAT
    // Air in level layers. Below the horizon and beyond the map's edge it is as bright as on the horizon.
    float depth = optical_depth(h, max(mu, 0.0)), climb = t * mu * view.atmosphere.x;
    if (t >= 0.0) {
        float thin = exp(-h * view.atmosphere.x), share = abs(climb) < 1e-3 ? 1.0 - 0.5 * climb : (1.0 - exp(-max(climb, -80.0))) / climb;
        depth = t * view.atmosphere.x * thin * share;
    }
#else
    float depth = optical_depth(h, mu);
    if (t >= 0.0) {
        float q = h * (2.0 + h) + t * (2.0 * r * mu + t); // r_end^2 - 1
        float r_end = sqrt(max(1.0 + q, 1e-6));
        float mu_end = (r * mu + t) / r_end;
        float h_end = q / (r_end + 1.0);
        float away = optical_depth(max(h_end, 0.0), mu_end);
        depth = mu_end < 0.0 && mu < 0.0 ? optical_depth(max(h_end, 0.0), -mu_end) - optical_depth(h, -mu) : depth - away;
    }
#endif
    depth = max(depth, 0.0) * view.atmosphere.z * (t >= 0.0 ? TERRAIN_AIR : 1.0);
    through = exp(-RAYLEIGH * depth);
    return AIR_RADIANCE * (1.0 + cos_sun * cos_sun) * lit * (1.0 - through);
}
