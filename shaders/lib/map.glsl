// From ring coordinates to the map: longitude and geodetic latitude relative to the focus, by the chosen transform. With FLAT
// the planet is a plane, and the ring coordinates are the map's.
#include "lib/blocks.glsl"
#include "shared/transform.glsl"

// TRANSFORM is set at compile time to a number of enum perigee_transform (perigee.h): software drivers run every branch of
// an `if`, and the paper's forms are not cheap.
#define TRANSFORM_STABLE 0
#define TRANSFORM_EXACT 1
#define TRANSFORM_APPROX 2
#define TRANSFORM_BLEND 3

// Angle from the focus by which levels count (src/geo/rings.h): from the length of n~, e~ and, on the sphere, the cosine.
float ring_angle(float aside, float cosine)
{
#ifdef FLAT
    return max(2.0 * atan(0.5 * aside), 1e-9);
#else
    return max(atan(aside, cosine), 1e-9);
#endif
}

// `level`: continuous level of the point; the blend is exact up to level 9, approximate from 11 on (the paper: from 10).
vec2 map_of_ring(vec3 ring, float level)
{
    float dlon, dlat;
#ifdef FLAT
    dlon = ring.y;
    dlat = ring.x;
#elif TRANSFORM == TRANSFORM_STABLE
    map_transform_stable(ring.x, ring.y, ring.z, view.focus.x, view.focus.y, view.focus.z, dlon, dlat);
#elif TRANSFORM == TRANSFORM_EXACT
    map_transform_exact(ring.x, ring.y, ring.z, view.focus.x, view.focus.y, view.focus.z, view.focus.w, dlon, dlat);
#elif TRANSFORM == TRANSFORM_APPROX
    map_transform_approx(ring.x, ring.y, ring.z, view.focus_paper.y, view.focus_paper.z, dlon, dlat);
#else
    map_transform_blend(ring.x, ring.y, ring.z, view.focus.x, view.focus.y, view.focus.z, view.focus.w,
                        view.focus_paper.y, view.focus_paper.z, clamp((level - 9.0) * 0.5, 0.0, 1.0), dlon, dlat);
#endif
    return vec2(dlon, dlat);
}
