// The rings cut into cells, the units of culling, placing and drawing: a level has `bands` x
// `sectors` cells, the fill inside the finest drawn level one band. Vertices stand in rows of
// ring_columns(); the fill's rows stand after the rings'. Pure functions. Any thread.
#ifndef PERIGEE_RENDER_CELLS_H
#define PERIGEE_RENDER_CELLS_H

#include <stdbool.h>
#include <stdint.h>

#include "geo/ellipsoid.h"
#include "geo/rings.h"

enum { CELL_SECTORS = 32, CELL_BANDS = 2, CELL_FILL_RINGS = 16 };

// The vertices of one cell, both ends included.
typedef struct cell_span {
    uint32_t row, rows, column, columns;
} cell_span;

// Cells in all: levels * bands * sectors, then the fill's sectors.
int cell_count(const ring_params *rings);
int cell_index(int level, int band, int sector);
int cell_fill_index(const ring_params *rings, int sector);
// Of a cell: its level (`levels` of the rings: the fill) and sector (clockwise from north).
int cell_level(int cell);
int cell_sector(int cell);
cell_span cell_vertices(const ring_params *rings, int cell);

// What the camera sees, in the meridian frame of the focus: planes through the camera, inward
// normals.
typedef struct cell_view {
    geo_ellipsoid ellipsoid;
    double lat, lon;    // of the focus
    double cb, sb;      // of the focus's reduced latitude
    dvec3 camera;       // m from the planet's centre, or from the plane's origin
    dvec3 plane[5];     // left, right, bottom, top, front
    double horizon;     // angle from the camera's nadir beyond which nothing shows
    double nadir_angle; // angle between the focus and the camera's nadir; on a plane both are
                        // distances in radii
    double north[2 * CELL_SECTORS], east[2 * CELL_SECTORS]; // of the azimuths, half a sector apart
} cell_view;

// Fills in `north` and `east`.
void cell_view_azimuths(cell_view *view);

// What the sectors of a band share: three angles from the focus, and heights in [low, high].
typedef struct cell_band {
    double outward[3], down[3]; // sines and cosines; on a plane distances in radians, and 0
    double low, high, slack;    // slack: by how much arcs leave the points between
    bool beyond;                // the horizon
} cell_band;

// The band of `cell`. `last`: finest drawn level (bounds the fill).
cell_band cell_band_of(const ring_params *rings, const cell_view *view, int cell, int last,
                       double low, double high);

// Can any terrain of the band in that sector be inside the frustum? Conservative: never false for
// what can be seen.
bool cell_band_visible(const cell_view *view, const cell_band *band, int sector);

#endif
