// The static rings of the spherical clipmap (Clasen & Hege 2006, 3.4), on the unit sphere of
// reduced latitude. Azimuth 0 points NORTH and grows towards EAST. Ring r lies at the angle pi
// 2^(-r/m) from the focus; level i owns rings i m .. (i + 1) m (both ends shared with its
// neighbours). A vertex column c in [0, n + 2): the two meridian lines (azimuth 0 and azimuth pi)
// stand twice, once with e~ = +SEAM, once with e~ = -SEAM, so that each half of the disc has its
// own copy whose longitude has the right sign beyond a pole (the paper's 4.4). Columns 0 .. n/2 run
// from north by east to south, columns n/2 + 1 .. n + 1 from south by west to north.
//
// Pure functions. Any thread.
#ifndef PERIGEE_GEO_RINGS_H
#define PERIGEE_GEO_RINGS_H

// |e~| of the seam columns: tells the two copies apart, far below any coordinate.
#define RING_SEAM 1e-30f

typedef struct ring_params {
    int azimuth_steps;   // n, a multiple of 2 * sectors
    int rings_per_level; // m
    int levels;          // rings exist for levels 0 .. levels - 1
} ring_params;

// Vertex columns in one ring: n + 2. Rings in all: levels * m + 1.
int ring_columns(const ring_params *p);
int ring_count(const ring_params *p);

// Angle from the focus of ring r (r may be fractional), rad: pi 2^(-r/m).
double ring_angle(const ring_params *p, double ring);

// Continuous level at an angle from the focus: log2(pi / angle); 0 at the antipode, +infinity at
// the focus.
double ring_level_of_angle(double angle);

// On a plane a ring has the radius 2 tan(angle / 2), its stereographic image: from the focus on
// nearly the angle, and out of any map at level 0. And the angle at a distance.
double ring_plane_radius(double angle);
double ring_plane_angle(double distance);

// Direction (cos az, sin az) of a column: exact zeros and signs on the axes, +-RING_SEAM not
// included.
void ring_direction(const ring_params *p, int column, double out[2]);

// What the shaders make vertices of (shaders/lib/rings.glsl): of a ring sin(t) and v~ = 1 - cos(t),
// of a column the cosine and sine of its azimuth. Sine and cosine are sums of 12 bits and a rest.
typedef struct ring_row {
    float radius, radius_low, drop;
} ring_row;

typedef struct ring_column {
    float north, north_low, east, east_low;
} ring_column;

// Of a ring at an angle from the focus; the same on a plane, where nothing drops.
ring_row ring_row_at(double angle);
ring_row ring_plane_row_at(double angle);
ring_column ring_column_at(const ring_params *p, int column);

// n~ = sin(t) cos(az), e~ = sin(t) sin(az), v~ = 1 - cos(t) of a ring vertex as they make it: each
// rounded once, to 0.503 ulp.
void ring_vertex(const ring_params *p, int ring, int column, float out[3]);

#endif
