// The focus of the rings: the place on the ellipsoid around which they stand, with all that the
// shared functions (geo/shared.h) take from it, in double; the caller rounds.
//
// Pure functions. Any thread.
#ifndef PERIGEE_GEO_FOCUS_H
#define PERIGEE_GEO_FOCUS_H

#include "geo/ellipsoid.h"

struct geo_focus {
    double lat, lon; // geodetic, rad
    double reduced;  // latitude, rad
    double cb, sb;   // cosine and sine of `reduced`
    double r;        // A/B
    double stretch;  // the factor of e~ in Clasen & Hege 2006, eq. 11; large but finite at a pole
    double dlat_db;  // derivative of geodetic by reduced latitude here
    double href;     // reference height, m
    dvec3 offset;    // point at height href over the focus minus camera, meridian frame, m
    dmat3 meridian_from_ecef; // turns about z by -lon
};

struct geo_focus geo_focus_make(geo_ellipsoid e, double focus_lat, double focus_lon,
                                dvec3 camera_ecef, double href);

#endif
