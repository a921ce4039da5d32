// Where a ring vertex is, by the plain formulas in long double: the oracle of the map transforms
// and of placing. It knows nothing of the stable forms: a rotation, arc tangents, and differences
// of places, whose cancellation long double has digits for.
//
// Pure functions. Any thread.
#ifndef PERIGEE_TESTS_RING_TRUTH_H
#define PERIGEE_TESTS_RING_TRUTH_H

#include <stdbool.h>

#include "geo/ellipsoid.h"
#include "geo/rings.h"

typedef long double exact;

#define PI_EXACT 3.14159265358979323846264338327950288L

// A focus by its distance from the nearer pole, reduced, rad; hemisphere +1 (north) or -1. So
// places near a pole keep their digits.
struct truth_focus {
    geo_ellipsoid ellipsoid;
    double colatitude;
    int hemisphere;
};

struct ring_truth {
    exact u[3];       // on the unit sphere of reduced latitude, meridian frame of the focus
    exact rho;        // distance of u from the axis
    exact dlon, dlat; // longitude and geodetic latitude from the focus, rad
};

// The vertex as it is meant: ring and column, nothing rounded. With rounded attributes compared to
// this, their rounding is part of the error.
struct ring_truth ring_truth_ideal(const struct truth_focus *f, const ring_params *p, int ring,
                                   int column);

// The place that given ring coordinates name: the direction (n, e, 1 - v) seen from the focus.
struct ring_truth ring_truth_stored(const struct truth_focus *f, const float nev[3]);

// Terrain at height h over u, ECEF turned about z by -lon of the focus, m.
void ring_truth_point(geo_ellipsoid e, const exact u[3], exact h, exact p[3]);
// A vector of the meridian frame (ECEF turned about z) in the tangent frame of the focus: up along
// its normal, east, north.
void ring_truth_tangent(const struct truth_focus *f, const exact p[3], exact out[3]);
// The focus itself as u.
void ring_truth_focus(const struct truth_focus *f, exact u[3]);

// At a pole there is no longitude: a vertex within a millionth of its ring's radius has none.
bool ring_truth_has_longitude(const struct ring_truth *t, int level);

// Texels of a level's window of 256 rows across and 512 columns, rad. In longitude the window is
// the narrowest power-of-two share of the circle that holds the level's outer ring, at most as
// narrow as the rows allow.
exact ring_truth_lat_texel(int level);
exact ring_truth_lon_texel(const struct truth_focus *f, int level);

#endif
