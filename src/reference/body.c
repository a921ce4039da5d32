#include "reference/body.h"

#include "reference/geographic.h"

#define RAD       (M_PI / 180)
#define POLE_ROOM 1e-12

dvec3 body_point(geo_ellipsoid e, double lat_deg, double lon_deg, double height)
{
    double xyz[3];
    if (geo_is_plane(e)) return dvec3_make(height, e.a * (lon_deg * RAD), e.a * (lat_deg * RAD));
    reference_ecef(e.a, e.b, lat_deg, lon_deg, height, xyz);
    return dvec3_make(xyz[0], xyz[1], xyz[2]);
}

void body_locate(geo_ellipsoid e, dvec3 point, double *lat_deg, double *lon_deg, double *height)
{
    const double xyz[3] = {point.x, point.y, point.z};
    if (!geo_is_plane(e)) {
        reference_geodetic(e.a, e.b, xyz, lat_deg, lon_deg, height);
        return;
    }
    *lat_deg = point.z / e.a / RAD;
    *lon_deg = point.y / e.a / RAD;
    *height = point.x;
}

body_frame body_frame_at(geo_ellipsoid e, double lat_deg, double lon_deg, double height)
{
    if (geo_is_plane(e))
        return (body_frame){.up = {1, 0, 0},
                            .east = {0, 1, 0},
                            .north = {0, 0, 1},
                            .meridian = e.a,
                            .per_lat = e.a,
                            .per_east = e.a,
                            .per_lon = e.a};
    double sl = sin(lat_deg * RAD), cl = cos(lat_deg * RAD), so = sin(lon_deg * RAD),
           co = cos(lon_deg * RAD);
    double e2 = 1 - (e.b / e.a) * (e.b / e.a), w2 = 1 - e2 * sl * sl;
    double prime = e.a / sqrt(w2), meridian = prime * (1 - e2) / w2;
    return (body_frame){.up = {cl * co, cl * so, sl},
                        .east = {-so, co, 0},
                        .north = {-sl * co, -sl * so, cl},
                        .meridian = meridian,
                        .per_lat = meridian + height,
                        .per_east = prime + height,
                        .per_lon = (prime + height) * fmax(cl, POLE_ROOM)};
}

dvec3 body_noon(geo_ellipsoid e, dvec3 camera)
{
    dvec3 up = geo_is_plane(e) ? dvec3_make(1, 0, 0) : dvec3_normalize(camera);
    return dvec3_normalize(dvec3_add(up, dvec3_make(0.42, -0.65, 0.38)));
}

double body_reach(geo_ellipsoid e, dvec3 point)
{
    double own = 2 * fmax(e.a, e.b);
    if (geo_is_plane(e)) own = e.a * hypot(fmax(-e.south, e.north), fmax(-e.west, e.east));
    return dvec3_length(point) + own;
}

static void cut(double at, double speed, double low, double high, double *from, double *to)
{
    double a = (low - at) / speed, b = (high - at) / speed;
    if (speed == 0) {
        if (at < low || at > high) *from = INFINITY;
        return;
    }
    *from = fmax(*from, fmin(a, b));
    *to = fmin(*to, fmax(a, b));
}

bool body_over_map(geo_ellipsoid e, dvec3 origin, dvec3 dir, double *from, double *to)
{
    if (geo_is_plane(e)) {
        cut(origin.y, dir.y, e.a * e.west, e.a * e.east, from, to);
        cut(origin.z, dir.z, e.a * e.south, e.a * e.north, from, to);
    }
    return *to > *from;
}
