// A smooth planet whose height is known everywhere, imported through the real path.
#ifndef PERIGEE_TESTS_ANALYTIC_PLANET_H
#define PERIGEE_TESTS_ANALYTIC_PLANET_H

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

// Writes the planet file: heights only, WGS84, finest zoom `zoom` (0 to 6; the raster of zoom 4
// takes 128 MiB beside `path` while it is imported), sampled at the cell centres of a raster of
// that zoom's step. Replaces an existing file.
status analytic_planet_make(const char *path, int zoom);

// The turned field on any ellipsoid (zero: WGS84); rotation NULL: not turned.
status analytic_planet_make_rotated(const char *path, int zoom, const dmat3 *rotation,
                                    geo_ellipsoid ellipsoid);

#endif
