// From ring coordinates to the map: longitude and geodetic latitude relative to the focus, by the chosen transform.
#include "lib/blocks.glsl"
#include "shared/transform.glsl"

#define TRANSFORM_STABLE 0u
#define TRANSFORM_EXACT 1u
#define TRANSFORM_APPROX 2u
#define TRANSFORM_BLEND 3u

// `level`: continuous level of the point; the blend is exact up to level 9, approximate from 11 on (the paper: from 10).
vec2 map_of_ring(vec3 ring, float level)
{
    float dlon, dlat;
    if (view.mode.x == TRANSFORM_STABLE) {
        map_transform_stable(ring.x, ring.y, ring.z, view.focus.x, view.focus.y, view.focus.z, dlon, dlat);
    } else if (view.mode.x == TRANSFORM_EXACT) {
        map_transform_exact(ring.x, ring.y, ring.z, view.focus.x, view.focus.y, view.focus.z, view.focus.w, dlon,
                            dlat);
    } else if (view.mode.x == TRANSFORM_APPROX) {
        map_transform_approx(ring.x, ring.y, ring.z, view.focus_paper.y, view.focus_paper.z, dlon, dlat);
    } else {
        map_transform_blend(ring.x, ring.y, ring.z, view.focus.x, view.focus.y, view.focus.z, view.focus.w,
                            view.focus_paper.y, view.focus_paper.z, clamp((level - 9.0) * 0.5, 0.0, 1.0), dlon, dlat);
    }
    return vec2(dlon, dlat);
}
