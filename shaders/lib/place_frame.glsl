// What placing takes from the view block (shared/position.glsl).
#include "lib/blocks.glsl"
#include "shared/position.glsl"

place_frame place_frame_of_view()
{
    vec4 scale = view.place_scale, shape = view.place_shape, up = view.place_up, along = view.place_along;
    return place_frame(scale.x, scale.y, scale.z, scale.w, shape.x, shape.y, shape.z, shape.w, up.x, up.y, up.z, up.w,
                       along.x, along.y, along.z, along.w);
}
