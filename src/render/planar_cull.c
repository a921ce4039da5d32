#include "render/planar_cull.h"

#include <math.h>

static double cosine_to(double cb, double sb, double latitude, double aside)
{
    return sb * sin(latitude) + cb * cos(latitude) * cos(aside);
}

// On a parallel the nearest point is that of the nearest meridian; along a meridian the cosine is
// that of the distance from one latitude, and largest there or at an end.
double map_rect_angle(geo_ellipsoid e, double cb, double sb, map_rect r)
{
    double south = geo_reduced_from_geodetic(e, r.south),
           north = geo_reduced_from_geodetic(e, r.north);
    double aside = fmin(fabs(remainder(r.west, 2 * M_PI)), fabs(remainder(r.east, 2 * M_PI)));
    if (floor(r.west / (2 * M_PI)) != floor(r.east / (2 * M_PI))) aside = 0; // the focus's own
    double best = fmax(cosine_to(cb, sb, south, aside), cosine_to(cb, sb, north, aside));
    double peak = atan2(sb, cb * cos(aside));
    if (peak > south && peak < north) best = fmax(best, cosine_to(cb, sb, peak, aside));
    return acos(clamp_double(best, -1, 1));
}

static dvec3 terrain_point(const cell_view *v, double lat, double aside, double height)
{
    if (geo_is_plane(v->ellipsoid)) aside += v->lon;
    dvec3 p = geo_ecef_from_geodetic(v->ellipsoid, (geodetic){lat, aside, height});
    return dvec3_sub(p, v->camera);
}

static double widest_parallel(map_rect r)
{
    return r.south <= 0 && r.north >= 0 ? 1 : fmax(cos(r.south), cos(r.north));
}

// Nothing of the rectangle lies on the plane's map.
static bool off_map(const cell_view *v, map_rect r)
{
    geo_ellipsoid e = v->ellipsoid;
    return r.south > e.north || r.north < e.south || v->lon + r.west > e.east ||
           v->lon + r.east < e.west;
}

// By how much arcs leave the points that bound a rectangle, on the unit sphere.
static double bend_of(map_rect r)
{
    return widest_parallel(r) * (1 - cos((r.east - r.west) / 4)) +
           (1 - cos((r.north - r.south) / 4));
}

bool map_rect_visible(const cell_view *v, map_rect r, double low, double high)
{
    if (r.south >= r.north) return false;
    bool plane = geo_is_plane(v->ellipsoid);
    if (plane ? off_map(v, r)
              : map_rect_angle(v->ellipsoid, v->cb, v->sb, r) > v->horizon + v->nadir_angle)
        return false;
    // 3 x 3 x 2 points, and the sagitta of the arcs between them.
    double bend = plane ? 0 : bend_of(r), a = v->ellipsoid.a, b = v->ellipsoid.b,
           widest = fmax(a * a / b, b * b / a);
    double slack = bend * (widest + fmax(fabs(low), fabs(high)));
    bool inside[5] = {false};
    for (int i = 0; i < 18; i++) {
        dvec3 p = terrain_point(v, r.south + (r.north - r.south) * 0.5 * (i % 3),
                                r.west + (r.east - r.west) * 0.5 * (i / 3 % 3), i < 9 ? low : high);
        for (int k = 0; k < 5; k++)
            if (dvec3_dot(v->plane[k], p) >= -slack) inside[k] = true;
    }
    return inside[0] && inside[1] && inside[2] && inside[3] && inside[4];
}
