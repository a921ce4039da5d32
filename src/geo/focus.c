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

// All frames have the plane's axes. No transform is ever taken from the rest.
static void set_plane(struct geo_focus *f, dvec3 camera)
{
    const dmat3 same = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    f->reduced = f->lat;
    f->cb = f->stretch = f->dlat_db = 1;
    f->meridian_from_ecef = f->tangent_from_meridian = same;
    f->offset = dvec3_sub(geo_ecef_from_geodetic(f->ellipsoid, (geodetic){f->lat, f->lon, f->href}),
                          camera);
}

struct geo_focus geo_focus_make(geo_ellipsoid e, double focus_lat, double focus_lon,
                                dvec3 camera_ecef, double href)
{
    struct geo_focus f = {
        .ellipsoid = e, .lat = focus_lat, .lon = focus_lon, .href = href, .r = e.a / e.b};
    if (geo_is_plane(e)) {
        set_plane(&f, camera_ecef);
        return f;
    }
    double c = cos(focus_lon), s = sin(focus_lon);
    f.reduced = geo_reduced_from_geodetic(e, focus_lat);
    f.cb = cos(f.reduced);
    f.sb = sin(f.reduced);
    f.stretch = paper_stretch(M_PI / 2 - f.reduced);
    f.dlat_db = f.r / (f.cb * f.cb + f.r * f.r * (f.sb * f.sb));
    f.meridian_from_ecef = (dmat3){{{c, s, 0}, {-s, c, 0}, {0, 0, 1}}};
    dvec3 reference = geo_ecef_from_geodetic(e, (geodetic){focus_lat, 0, href});
    double cl = cos(focus_lat), sl = sin(focus_lat);
    f.tangent_from_meridian = (dmat3){{{cl, 0, sl}, {0, 1, 0}, {-sl, 0, cl}}};
    dvec3 offset = dvec3_sub(reference, dmat3_mul(f.meridian_from_ecef, camera_ecef));
    f.offset = dmat3_mul(f.tangent_from_meridian, offset);
    return f;
}

static void split(double whole, float high, double *head, double *low)
{
    *head = high;
    *low = whole - high;
}

struct place_frame_d geo_place_frame(const struct geo_focus *f)
{
    double q = 1 / f->r, grade = hypot(q * f->cb, f->sb);
    double east = f->ellipsoid.a, north = f->ellipsoid.a * grade;
    struct place_frame_d p = {.drop = f->ellipsoid.b / grade, .grade = grade, .q = q};
    p.skew = (1 - q * q) * f->cb * f->sb / grade;
    if (geo_is_plane(f->ellipsoid)) p.drop = p.q = 0; // nothing drops, and no normal turns
    split(east, leading_bits_f((float)east), &p.east, &p.east_low);
    split(north, leading_bits_f((float)north), &p.north, &p.north_low);
    split(f->href, (float)round(f->href), &p.href, &p.href_low);
    split(f->offset.x, (float)f->offset.x, &p.up_offset, &p.up_offset_low);
    split(f->offset.y, (float)f->offset.y, &p.east_offset, &p.east_offset_low);
    split(f->offset.z, (float)f->offset.z, &p.north_offset, &p.north_offset_low);
    return p;
}

struct place_frame_f geo_place_frame_rounded(const struct geo_focus *f)
{
    struct place_frame_d d = geo_place_frame(f);
    struct place_frame_f p;
    enum { MEMBERS = sizeof d / sizeof(double) };
    _Static_assert(sizeof p == MEMBERS * sizeof(float), "one member each");
    double from[MEMBERS];
    float to[MEMBERS];
    memcpy(from, &d, sizeof d);
    for (int i = 0; i < MEMBERS; i++) to[i] = (float)from[i];
    memcpy(&p, to, sizeof p);
    return p;
}
