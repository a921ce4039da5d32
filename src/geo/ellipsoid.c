// Closed forms but for the foot point of an ECEF position, a root found by Newton's method from the
// side where it converges monotonically.
#include "geo/ellipsoid.h"

enum { FOOT_STEPS = 40 };

static dvec3 not_a_point(void)
{
    return (dvec3){NAN, NAN, NAN};
}

geo_ellipsoid geo_plane_of(geo_ellipsoid e)
{
    return (geo_ellipsoid){e.a, e.a, -M_PI / 2, M_PI / 2, -M_PI, M_PI};
}

dvec3 geo_ecef_from_geodetic(geo_ellipsoid e, geodetic p)
{
    if (geo_is_plane(e)) return (dvec3){p.height, e.a * p.lon, e.a * p.lat};
    if (!(fabs(p.lat) <= M_PI / 2)) return not_a_point();
    double c = cos(p.lat), s = sin(p.lat);
    double w = hypot(e.a * c, e.b * s);
    double ring = (e.a * (e.a / w) + p.height) * c;
    return (dvec3){ring * cos(p.lon), ring * sin(p.lon), (e.b * (e.b / w) + p.height) * s};
}

// The parameter t of the foot point (a^2 p / (t + a^2), b^2 z / (t + b^2)) of the meridian point
// (p, z), p, z >= 0: the root of F(t) = (a p / (t + a^2))^2 + (b z / (t + b^2))^2 - 1, convex and
// falling.
//   source  Eberly, "Distance from a Point to an Ellipse, an Ellipsoid, or a Hyperellipsoid", 2013
//   edges   start where one term alone is 1, so 0 <= F <= 1 and every step stays left of the root
static double foot_parameter(geo_ellipsoid e, double p, double z)
{
    double a2 = e.a * e.a, b2 = e.b * e.b;
    double t = fmax(e.a * p - a2, e.b * z - b2);
    t = fmax(t, -fmin(a2, b2) * (1 - 1e-12));
    for (int i = 0; i < FOOT_STEPS; i++) {
        double u = e.a * p / (t + a2), v = e.b * z / (t + b2);
        double f = u * u + v * v - 1;
        double step = f / (2 * (u * u / (t + a2) + v * v / (t + b2)));
        if (!(step > 0)) break;
        t += step;
        if (step <= 1e-17 * (t + a2)) break;
    }
    return t;
}

geodetic geo_geodetic_from_ecef(geo_ellipsoid e, dvec3 p)
{
    if (geo_is_plane(e)) return (geodetic){.lat = p.z / e.a, .lon = p.y / e.a, .height = p.x};
    double ring = hypot(p.x, p.y);
    if (!(ring > 0 || fabs(p.z) > 0)) return (geodetic){NAN, NAN, NAN};
    double t = foot_parameter(e, ring, fabs(p.z));
    double ta = t + e.a * e.a, tb = t + e.b * e.b;
    return (geodetic){.lat = atan2(p.z * ta, ring * tb),
                      .lon = ring > 0 ? atan2(p.y, p.x) : 0,
                      .height = t * hypot(ring / ta, p.z / tb)};
}

double geo_reduced_from_geodetic(geo_ellipsoid e, double lat)
{
    return atan2(e.b * sin(lat), e.a * cos(lat));
}

double geo_geodetic_from_reduced(geo_ellipsoid e, double reduced)
{
    return atan2(e.a * sin(reduced), e.b * cos(reduced));
}

dvec3 geo_normal(double lat, double lon)
{
    double c = cos(lat);
    return (dvec3){c * cos(lon), c * sin(lon), sin(lat)};
}

dmat3 geo_ecef_from_enu(double lat, double lon)
{
    double cp = cos(lat), sp = sin(lat), cl = cos(lon), sl = sin(lon);
    return (dmat3){{{-sl, -sp * cl, cp * cl}, {cl, -sp * sl, cp * sl}, {0, cp, sp}}};
}

dvec3 geo_up_at(geo_ellipsoid e, double lat, double lon)
{
    return geo_is_plane(e) ? geo_normal(0, 0) : geo_normal(lat, lon);
}

dmat3 geo_frame_at(geo_ellipsoid e, double lat, double lon)
{
    return geo_is_plane(e) ? geo_ecef_from_enu(0, 0) : geo_ecef_from_enu(lat, lon);
}

double geo_wrap_lon(double lon)
{
    if (lon >= -M_PI && lon < M_PI) return lon;
    double w = lon - 2 * M_PI * floor((lon + M_PI) / (2 * M_PI));
    if (w >= M_PI) return -M_PI;
    return w < -M_PI ? -M_PI : w;
}

static double ray_plane(double height, dvec3 origin, dvec3 dir)
{
    double t = (height - origin.x) / dir.x;
    return t >= 0 && isfinite(t) ? t : NAN;
}

double geo_ray_ellipsoid(geo_ellipsoid e, double height, dvec3 origin, dvec3 dir)
{
    if (geo_is_plane(e)) return ray_plane(height, origin, dir);
    double a = e.a + height, b = e.b + height;
    if (!(a > 0 && b > 0)) return NAN;
    dvec3 o = {origin.x / a, origin.y / a, origin.z / b};
    dvec3 d = {dir.x / a, dir.y / a, dir.z / b};
    double dd = dvec3_dot(d, d), od = dvec3_dot(o, d);
    double outside = (dvec3_length(o) - 1) * (dvec3_length(o) + 1);
    dvec3 nearest = dvec3_mad(o, d, -od / dd);
    double room = 1 - dvec3_dot(nearest, nearest);
    if (!(room >= 0)) return NAN;
    double root = sqrt(dd * room);
    if (outside <= 0) return (root - od) / dd;
    if (od >= 0) return NAN;
    return outside / (root - od);
}
