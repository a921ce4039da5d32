// All angles in the scaled space, where the ellipsoid is the unit sphere and lines stay lines.
#include "geo/horizon.h"

// Terrain at height h over the unit vector u lies, scaled, at u + h D^-1 n, which is not along u:
// the largest angle between u and D^-1 n (along D^-2 u) is half the axes' ratio away, tan = (k - 1)
// / (2 sqrt(k)) with k = (long / short)^2.
static double lean(geo_ellipsoid e, double low, double high)
{
    double ratio = fmax(e.a, e.b) / fmin(e.a, e.b);
    double k = ratio * ratio;
    double sine = sin(atan((k - 1) / (2 * ratio)));
    double reach = fmax(fabs(low), fabs(high));
    return atan2(reach * sine, 1 - fabs(fmin(low, 0)));
}

// From a place to the farthest corner of a plane's map, rad.
static double map_corner(geo_ellipsoid e, double lon, double lat)
{
    return hypot(fmax(lon - e.west, e.east - lon), fmax(lat - e.south, e.north - lat));
}

// The tangent cone of the largest sphere that all terrain covers, and past it the summit's own
// share. The lowest terrain's scaled radius is at least 1 + floor / (short axis), the summit's at
// most 1 + summit / (short axis).
double geo_horizon_angle(geo_ellipsoid e, dvec3 camera, double floor_height, double summit)
{
    if (geo_is_plane(e)) return map_corner(e, camera.y / e.a, camera.z / e.a);
    double shorter = fmin(e.a, e.b);
    double low = fmin(floor_height, 0) / shorter;
    double high = fmax(summit / shorter, low);
    double distance = dvec3_length((dvec3){camera.x / e.a, camera.y / e.a, camera.z / e.b});
    if (!(low > -1 && distance > 1 + low)) return M_PI;
    double limb = acos((1 + low) / distance);
    double behind = acos((1 + low) / (1 + high));
    return fmin(M_PI, limb + behind + lean(e, low, high));
}

double geo_pixel_size(double distance, double fov_y, int height_px)
{
    return 2 * distance * tan(fov_y / 2) / height_px;
}
