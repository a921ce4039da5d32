// Nested squares of vertices about a viewer over a map of longitude and latitude (geometry
// clipmaps: Losasso & Hoppe 2004; Asirvatham & Hoppe 2005). Level l has n x n vertices, n = 2^k - 1
// = 4 m - 1, at a step of 2 pi / ((n + 1) 2^l) in latitude as in longitude. Vertices stand on the
// lattice of all multiples of the step: row K at latitude pi/2 - K step, column J at longitude -pi
// + J step, so that those of a level are every other one of the next finer level. The pyramid's
// samples are cell centres, which nest in no such way: a vertex stands in the middle of four.
//
// A level begins at even indices, which makes its border lie on the coarser lattice, and is never
// more than a step off the viewer; within the coarser level it begins at index m - 1 or m.
//
// Over a plane level 0 spans 2^NEST_PLANE_LEVELS turns, so that it holds the whole map from any
// place of it, every step is as many times longer, and rows go on beyond the poles.
//
// Pure functions. Any thread.
#ifndef PERIGEE_GEO_NEST_H
#define PERIGEE_GEO_NEST_H

#include <stdbool.h>
#include <stdint.h>

#include "geo/focus.h"

enum { NEST_N_MIN = 31, NEST_N_MAX = 1023, NEST_PLANE_LEVELS = 2 };

bool nest_size_valid(int n); // 31, 63, 127, 255, 511 or 1023

// A level's square for a viewer.
typedef struct nest_square {
    int n, level;
    bool plane;
    int64_t circle;               // columns of a turn
    double step;                  // rad
    int64_t row, column;          // of its first vertex; columns count on from turn to turn
    double view_row, view_column; // of the viewer, in steps from the first vertex: n/2 -+ 1
} nest_square;

// The viewer's geodetic latitude in [-pi/2, pi/2] and any finite longitude, rad.
nest_square nest_square_at(int n, int level, double lat, double lon);
// The same over any body; on a plane any finite latitude.
nest_square nest_square_over(geo_ellipsoid e, int n, int level, double lat, double lon);

// The level whose step on the globe a level has over a plane.
int nest_globe_level(bool plane, int level);

// Half of the side that is covered in every direction whatever the snapping, rad.
double nest_half_side(int n, int level);

// Share of the next coarser level at a vertex (row, column of the square; 2005, 2.3.5): 0 inside, 1
// at the border, in between linear over n/10 steps, by the viewer's place and not the square's.
double nest_alpha(const nest_square *s, double row, double column);
double nest_transition_width(int n);

// The finest level worth drawing `above` metres over the ground (2005, 2.3.1): its side is at least
// 2.5 times that long on a planet of this radius; at most levels - 1. share: how far it has come in
// since, 0 when it just has, 1 from half a level on, so that it need not appear at once.
int nest_finest_level(int n, double radius, double above, int levels, double *share);

// The coarsest level needed: its square holds all that lies within `angle` (rad, on the unit sphere
// of reduced latitude) of the focus. 0 when a pole does: then no square does but the whole map.
int nest_coarsest_level(int n, const struct geo_focus *focus, double angle, int levels);
// A pole of the map lies within `angle` of the focus.
bool nest_holds_pole(const struct geo_focus *focus, double angle);

// What a row and a column contribute to a vertex's ring coordinates about the focus (geo/rings.h),
// made in double and rounded once. With the row's (s, c, w) and the column's (t, d):
//     n~ = s + sin b w d,  e~ = w t,  v~ = c + cos b w d,  b the focus's reduced latitude.
// One vertex has the same numbers in every level that has it.
typedef struct nest_row {
    float s, c; // sine and 1 - cosine of the reduced latitude less the focus's
    float w;    // cosine of the reduced latitude; 0 at a pole, and for rows beyond one
    float dlat; // geodetic, from the focus, rad
} nest_row;

typedef struct nest_column {
    float t, d; // sine and 1 - cosine of the longitude less the focus's
    float spare;
    float dlon; // from the focus, rad; not wrapped
} nest_column;

// i: from the square's first; rows beyond a pole are at it.
nest_row nest_row_at(const nest_square *s, const struct geo_focus *focus, int i);
nest_column nest_column_at(const nest_square *s, const struct geo_focus *focus, int i);

// Geodetic latitude of a row, on the globe limited to the poles.
double nest_latitude(const nest_square *s, double row);

#endif
