// Where a ring vertex stands, relative to the camera.
#ifndef SHARED_POSITION
#define SHARED_POSITION

#include "shared/dialect.glsl"

// Position of the terrain at height h over ring vertex n, e, v, relative to the camera, in the focus's meridian frame
// (ECEF turned about z by -lon of the focus), metres.
//   in      cb, sb of the focus's reduced latitude; semi-axes a, b; href_hi + href_lo a reference height near the camera's;
//           o = (focus on the ellipsoid) + href (normal at the focus) - camera, in that frame: 0 when the camera hangs over
//           the focus at height href
//   error   in float 2e-7 of the distance, below 1 mm within 5 km (tests/geo/test_shared.c)
//   source  P = D (N n + E e - U v) + (h - href) nv + h (nrm - nv) + o with D = diag(a, a, b), N = (-sb, 0, cb),
//           E = (0, 1, 0), U = (cb, 0, sb); nv, nrm are the normals at focus and vertex, along b D^-1 of the unit vector,
//           and their difference is formed from the small vector delta = b D^-1 (N n + E e - U v)
SHARED void SHARED_NAME(relative_position)(real n, real e, real v, real h, real cb, real sb,
                                           real a, real b, real href_hi, real href_lo, real ox,
                                           real oy, real oz, OUT(real) x, OUT(real) y, OUT(real) z)
{
    real q = b / a;
    real mx = q * cb;
    real mz = sb;
    real ux = -(sb * n + cb * v);
    real uz = cb * n - sb * v;
    real dx = q * ux;
    real dy = q * e;
    real dz = uz;
    real vx = mx + dx;
    real vz = mz + dz;
    real len_focus = sqrt(mx * mx + mz * mz);
    real len = sqrt(vx * vx + dy * dy + vz * vz);
    real grow = dx * (mx + vx) + dy * dy + dz * (mz + vz);
    real along = grow / (len * len_focus * (len + len_focus));
    real rise = ((h - href_hi) - href_lo) / len_focus;
    real lift = h / len;
    real turn = h * along;
    SET(x) = a * ux + (rise * mx + (lift * dx - turn * mx) + ox);
    SET(y) = a * e + (lift * dy + oy);
    SET(z) = b * uz + (rise * mz + (lift * dz - turn * mz) + oz);
}

#endif
