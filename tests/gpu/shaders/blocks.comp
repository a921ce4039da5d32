// Nothing but the uniform blocks of a frame: GL is asked where their members lie.
#include "lib/blocks.glsl"

layout(local_size_x = 1) in;

layout(std430, binding = 0) writeonly buffer Result { vec4 result; };

void main()
{
    result = view.clip_from_tangent[0] + levels.height_map[0];
}
