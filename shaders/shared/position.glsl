// Where a ring vertex stands, relative to the camera.
#ifndef SHARED_POSITION
#define SHARED_POSITION

#include "shared/dialect.glsl"

// What placing takes from focus and camera (src/geo/focus.h makes it). Tangent frame: x up along the focus's normal, y east,
// z north; origin at the camera. A factor or length of two members is their sum: the first has 12 bits or is whole.
struct SHARED_NAME(place_frame) {
    real east, east_low;   // m a unit of e: A
    real north, north_low; // m a unit of n: A g
    real drop;             // m a unit of v: B / g
    real grade;            // g = |(q cos b, sin b)| at the focus's reduced latitude b, q = B / A
    real q;
    real skew;             // (1 - q q) cos b sin b / g
    real href, href_low;   // m, a reference height near the camera's
    real up_offset, up_offset_low; // m: (focus on the ellipsoid) + href (normal at the focus) - camera; 0 when the camera
    real east_offset, east_offset_low; // hangs over the focus at height href
    real north_offset, north_offset_low;
};

// scale x + offset + rest: the product of the leading bits is exact, so that where `offset` is 0 only the last sum rounds.
SHARED real SHARED_NAME(place_along)(real scale, real scale_low, real x, real offset, real rest)
{
    real head = LEADING_BITS(x);
    return (scale * head + offset) + (scale * (x - head) + (scale_low * x + rest));
}

// Position of the terrain at height h over ring vertex n, e, v, tangent frame, m.
//   error   in float 1.7e-7 of the distance, 0.86 mm within 10 km (tests/ACCURACY-transforms.md)
//   source  P = D (N n + E e - U v) + (h - href) up + h (normal - up) + offset, D = diag(A, A, B), N = (-sin b, 0, cos b),
//           E = (0, 1, 0), U = (cos b, 0, sin b). In the tangent frame D N = (0, 0, A g), D E = (0, A, 0) and
//           D U = (B / g, 0, -A skew): each axis has one leading product. The normal lies along
//           B D^-1 (U + N n + E e - U v) = (g, 0, 0) + d, and its change is formed from the small vector d
SHARED void SHARED_NAME(relative_position)(TYPE(place_frame) f, real n, real e, real v, real h, OUT(real) up,
                                           OUT(real) east, OUT(real) north)
{
    real d_up = f.skew * n - f.grade * v;
    real d_east = f.q * e;
    real d_north = f.q / f.grade * n;
    real m_up = f.grade + d_up;
    real len = sqrt(m_up * m_up + d_east * d_east + d_north * d_north);
    real grow = d_up * (f.grade + m_up) + d_east * d_east + d_north * d_north;
    real lift = h / len;
    real turn = h * (grow / (len * (len + f.grade)));
    real whole = floor(h + REAL(0.5));
    real rest = (h - whole) - f.href_low + f.up_offset_low - f.drop * v + (lift * d_up - turn);
    SET(up) = ((whole - f.href) + f.up_offset) + rest;
    SET(east) = SHARED_NAME(place_along)(f.east, f.east_low, e, f.east_offset, lift * d_east + f.east_offset_low);
    real skewed = f.skew * (f.east + f.east_low) * v;
    SET(north) = SHARED_NAME(place_along)(f.north, f.north_low, n, f.north_offset,
                                          skewed + (lift * d_north + f.north_offset_low));
}

#endif
