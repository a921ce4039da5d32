// The input cases of the shared functions (shaders/shared), the same for the CPU's test and the
// GPU's: ring vertices of levels 1 to 21 around focuses from the equator to both poles. Plain C,
// deterministic, any order.
#ifndef PERIGEE_TESTS_SHARED_CASES_H
#define PERIGEE_TESTS_SHARED_CASES_H

#include "geo/ellipsoid.h"
#include "geo/focus.h"
#include "geo/rings.h"

enum {
    SHARED_COLATITUDES = 7, // of the focus; each in both hemispheres
    SHARED_LEVELS = 21,     // 1 .. 21
    SHARED_RINGS = 5,       // in a level
    SHARED_COLUMNS = 50,
    SHARED_CASES = SHARED_COLATITUDES * 2 * SHARED_LEVELS * SHARED_RINGS * SHARED_COLUMNS
};

static const ring_params shared_case_rings = {SHARED_COLUMNS - 2, 40, SHARED_LEVELS + 1};

// What a shared function is given, floats in the order of its arguments, and what the truth is made
// from.
struct shared_case {
    float n, e, v;             // ring vertex
    float cb, sb, r, lat;      // focus
    float stretch, dlat_db, w; // paper's forms
    float h;
    struct place_frame_f place;          // the camera hangs over the focus at href
    int level, ring, column, hemisphere; // hemisphere: +1 or -1
    double colatitude;                   // reduced, of the focus
    double href;
    geo_ellipsoid ellipsoid;
};

// index in [0, SHARED_CASES).
static inline struct shared_case shared_case_at(int index)
{
    static const double colatitudes[SHARED_COLATITUDES] = {M_PI / 2, M_PI / 4, M_PI / 8, M_PI / 48,
                                                           1e-3,     1e-6,     0};
    static const int rings[SHARED_RINGS] = {0, 7, 20, 33, 40};
    static const float heights[] = {-418, 0, 1235, 8848};
    struct shared_case c = {.ellipsoid = GEO_WGS84, .href = 1235.6789};
    int i = index;
    c.column = i % SHARED_COLUMNS;
    i /= SHARED_COLUMNS;
    int ring = rings[i % SHARED_RINGS];
    i /= SHARED_RINGS;
    c.level = 1 + i % SHARED_LEVELS;
    i /= SHARED_LEVELS;
    c.hemisphere = i % 2 ? -1 : 1;
    c.colatitude = colatitudes[i / 2];
    c.ring = c.level * shared_case_rings.rings_per_level + ring;
    float vertex[3];
    ring_vertex(&shared_case_rings, c.ring, c.column, vertex);
    c.n = vertex[0];
    c.e = vertex[1];
    c.v = vertex[2];
    c.h = heights[index % 4];
    geo_ellipsoid e = c.ellipsoid;
    double lat = geo_geodetic_from_reduced(e, c.hemisphere * (M_PI / 2 - c.colatitude));
    dvec3 camera = geo_ecef_from_geodetic(e, (geodetic){lat, 0, c.href});
    struct geo_focus f = geo_focus_make(e, lat, 0, camera, c.href);
    c.cb = (float)f.cb;
    c.sb = (float)f.sb;
    c.r = (float)f.r;
    c.lat = (float)lat;
    c.stretch = (float)f.stretch;
    c.dlat_db = (float)f.dlat_db;
    c.w = (float)(index % 5) / 4;
    c.place = geo_place_frame_rounded(&f);
    return c;
}

#endif
