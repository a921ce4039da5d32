#include "geo/focus.h"

// Keeps eq. 11 finite at the poles, where it has no meaning.
#define STRETCH_FLOOR 1e-12

// 1 / sin(colatitude), as the paper fits it.
static double paper_stretch(double colatitude)
{
    double q = colatitude / M_PI - 0.5;
    double pole = fmax(0.25 - q * q, STRETCH_FLOOR);
    return 1 + 1 / (M_PI * pole) - q * q / 6 - 4 / M_PI;
}

struct geo_focus geo_focus_make(geo_ellipsoid e, double focus_lat, double focus_lon,
                                dvec3 camera_ecef, double href)
{
    struct geo_focus f = {.lat = focus_lat, .lon = focus_lon, .href = href, .r = e.a / e.b};
    double c = cos(focus_lon), s = sin(focus_lon);
    f.reduced = geo_reduced_from_geodetic(e, focus_lat);
    f.cb = cos(f.reduced);
    f.sb = sin(f.reduced);
    f.stretch = paper_stretch(M_PI / 2 - f.reduced);
    f.dlat_db = f.r / (f.cb * f.cb + f.r * f.r * (f.sb * f.sb));
    f.meridian_from_ecef = (dmat3){{{c, s, 0}, {-s, c, 0}, {0, 0, 1}}};
    dvec3 reference = geo_ecef_from_geodetic(e, (geodetic){focus_lat, 0, href});
    f.offset = dvec3_sub(reference, dmat3_mul(f.meridian_from_ecef, camera_ecef));
    return f;
}
