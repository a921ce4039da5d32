// The focus of the rings: the place on the ellipsoid around which they stand, with all that the
// shared functions (geo/shared.h) take from it, in double; the caller rounds. On a plane n~ and e~
// are the map's latitude and longitude from there, and v~ is 0.
//
// Pure functions. Any thread.
#ifndef PERIGEE_GEO_FOCUS_H
#define PERIGEE_GEO_FOCUS_H

#include "geo/ellipsoid.h"
#include "geo/shared.h"

struct geo_focus {
    geo_ellipsoid ellipsoid;
    double lat, lon; // geodetic, rad
    double reduced;  // latitude, rad
    double cb, sb;   // cosine and sine of `reduced`
    double r;        // A/B
    double stretch;  // the factor of e~ in Clasen & Hege 2006, eq. 11; large but finite at a pole
    double dlat_db;  // derivative of geodetic by reduced latitude here
    double href;     // reference height, m
    dvec3 offset;    // point at height href over the focus minus camera, tangent frame, m
    dmat3 meridian_from_ecef;    // turns about z by -lon
    dmat3 tangent_from_meridian; // turns about y by lat: x up, y east, z north
};

struct geo_focus geo_focus_make(geo_ellipsoid e, double focus_lat, double focus_lon,
                                dvec3 camera_ecef, double href);

// What relative_position takes: its lengths and factors split so that the float members carry about
// 36 bits together.
struct place_frame_d geo_place_frame(const struct geo_focus *f);
// The same, each member rounded to float.
struct place_frame_f geo_place_frame_rounded(const struct geo_focus *f);

#endif
