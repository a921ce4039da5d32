// A smooth planet whose height is known everywhere, imported through the real path.
#ifndef PERIGEE_TESTS_ANALYTIC_PLANET_H
#define PERIGEE_TESTS_ANALYTIC_PLANET_H

#include <stdbool.h>

#include "base/status.h"
#include "geo/ellipsoid.h"

// Bound of |height| and of its second derivative along any great circle, metres and metres / rad^2.
#define ANALYTIC_HEIGHT_MAX    4000.0
#define ANALYTIC_CURVATURE_MAX 450000.0

// Metres above the ellipsoid at a geodetic latitude and longitude (rad): a sum of plane waves of
// the unit normal, smooth at the poles and the antimeridian.
double analytic_height(double lat, double lon);

// The same field turned: the height at a normal n is that of analytic_height at transpose(rotation)
// * n.
double analytic_height_rotated(const dmat3 *rotation, double lat, double lon);

// Colour at the same place, R, G, B in [0.2, 0.8], sRGB-encoded: plane waves of the unit normal
// that turn along; its steepest change is 2 a rad.
void analytic_color_rotated(const dmat3 *rotation, double lat, double lon, double rgb[3]);

// Writes the planet file: heights only, WGS84, finest zoom `zoom` (0 to 6; the raster of zoom 4
// takes 128 MiB beside `path` while it is imported), sampled at the cell centres of a raster of
// that zoom's step. Replaces an existing file.
status analytic_planet_make(const char *path, int zoom);

typedef struct analytic_params {
    int zoom;
    int color_zoom;          // 0: no colour (0 to 4)
    const dmat3 *rotation;   // NULL: not turned
    geo_ellipsoid ellipsoid; // zero: WGS84
    // true: the tiles of every zoom are written as they should be, without the importer; colour up
    // to `zoom` when color_zoom is not 0, as JPEG of quality 100.
    bool direct;
    bool grey;             // of direct colour: R alone, which JPEG keeps to within its last bit
    double synthesis_gain; // 0: of direct tiles nothing is synthesised
} analytic_params;

// The same with more of it.
status analytic_planet_make_with(const char *path, const analytic_params *params);

// The turned field on any ellipsoid (zero: WGS84); rotation NULL: not turned. Heights only.
status analytic_planet_make_rotated(const char *path, int zoom, const dmat3 *rotation,
                                    geo_ellipsoid ellipsoid);

#endif
