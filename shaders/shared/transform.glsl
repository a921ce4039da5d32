// Map coordinates of a ring vertex: longitude and geodetic latitude relative to the focus, rad.
// All take the vertex n, e, v (geo/rings.h) on the unit sphere of reduced latitude, cb and sb (cosine and sine of the
// focus's reduced latitude), r = A/B of the ellipsoid.
#ifndef SHARED_TRANSFORM
#define SHARED_TRANSFORM

#include "shared/dialect.glsl"
#include "shared/atan.glsl"

// The default: no cancellation anywhere, so it holds at every latitude and every level.
//   error   in float at levels 1 .. 22, every colatitude: 1.3e-4 texel of the level's window of 256 rows across, in longitude
//           (512 columns) as in latitude; within 8 rows of a pole that holds on the ground (tests/ACCURACY-transforms.md)
//   source  sin(lat - b) = z cb - rho sb = n + sb (x - rho), x - rho = -y y / (rho + x); then to geodetic latitude by
//           the tangent of a difference, tan(lat) = r tan(b) at both ends
//   edges   a pole is right for every azimuth; the sign of e there and beyond tells +pi from -pi
SHARED void SHARED_NAME(map_transform_stable)(real n, real e, real v, real cb, real sb, real r,
                                              OUT(real) dlon, OUT(real) dlat)
{
    real x = cb - cb * v - sb * n;
    real z = sb - sb * v + cb * n;
    real rho = sqrt(x * x + e * e);
    real s;
    if (x >= 0.0f) {
        real sum = rho + x;
        s = n - (sum > 0.0f ? sb * (e * (e / sum)) : REAL(0.0));
    } else {
        s = n + sb * (x - rho);
    }
    SET(dlon) = SHARED_NAME(atan_ratio)(e, x);
    SET(dlat) = SHARED_NAME(atan_ratio)(r * s, rho * cb + r * r * (z * sb));
}

// The paper's eq. 9 and 12 with the built-in functions, whose error is to be seen; `lat` is the focus's geodetic latitude.
//   source  Clasen & Hege 2006, eq. 9, 10, 12, 13; geodetic latitude from tan(lat) = r tan(b)
SHARED void SHARED_NAME(map_transform_exact)(real n, real e, real v, real cb, real sb, real r,
                                             real lat, OUT(real) dlon, OUT(real) dlat)
{
    real x = cb * (1.0f - v) - sb * n;
    real z = sb * (1.0f - v) + cb * n;
    real theta = acos(z > 1.0f ? REAL(1.0) : z < -1.0f ? REAL(-1.0) : z);
    SET(dlon) = ATAN2(e, x);
    SET(dlat) = ATAN2(r * cos(theta), sin(theta)) - lat;
}

// The paper's first-order forms: `stretch` is the factor of eq. 11 at the focus, `dlat_db` the derivative of geodetic by
// reduced latitude there (1 on a sphere).
//   source  Clasen & Hege 2006, eq. 11, 14
SHARED void SHARED_NAME(map_transform_approx)(real n, real e, real v, real stretch, real dlat_db,
                                              OUT(real) dlon, OUT(real) dlat)
{
    SET(dlon) = e * stretch;
    SET(dlat) = n * dlat_db;
}

// approx * w + exact * (1 - w), against gaps where the paper's two forms meet (its fig. 14).
SHARED void SHARED_NAME(map_transform_blend)(real n, real e, real v, real cb, real sb, real r,
                                             real lat, real stretch, real dlat_db, real w,
                                             OUT(real) dlon, OUT(real) dlat)
{
    real lon_exact, lat_exact, lon_approx, lat_approx;
    SHARED_NAME(map_transform_exact)(n, e, v, cb, sb, r, lat, REF(lon_exact), REF(lat_exact));
    SHARED_NAME(map_transform_approx)(n, e, v, stretch, dlat_db, REF(lon_approx), REF(lat_approx));
    SET(dlon) = lon_approx * w + lon_exact * (1.0f - w);
    SET(dlat) = lat_approx * w + lat_exact * (1.0f - w);
}

#endif
