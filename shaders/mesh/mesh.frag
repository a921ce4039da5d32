#ifdef TEXCOORD_VERTEX
layout(location = 1) in vec2 map_dlonlat;
layout(location = 1) out vec2 out_dlonlat;
#endif
layout(location = 0) in vec2 ring_ne;
layout(location = 0) out vec2 out_ring;

void main()
{
    out_ring = ring_ne;
#ifdef TEXCOORD_VERTEX
    out_dlonlat = map_dlonlat;
#endif
}
