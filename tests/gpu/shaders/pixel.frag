// Colour 0: a constant; colour 1: where the pixel is.
layout(location = 1) uniform vec4 tint;
layout(location = 0) out vec4 color;
layout(location = 1) out vec2 place;

void main()
{
    color = tint;
    place = gl_FragCoord.xy;
}
