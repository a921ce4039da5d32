// As much work a pixel as one likes, which no compiler can leave out.
layout(location = 1) uniform int rounds;
layout(location = 0) out vec4 color;

void main()
{
    float x = gl_FragCoord.x * 0.001 + gl_FragCoord.y;
    for (int i = 0; i < rounds; i++) x = fract(x * 1.7 + 0.3) + sqrt(x + 1.0);
    color = vec4(x);
}
