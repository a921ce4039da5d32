// One piece of a height field: a polynomial of latitude and longitude between the samples about it,
// bilinear or bicubic, and what bounds it. Pure functions, degrees and metres. Any thread.
#ifndef PERIGEE_REFERENCE_PATCH_H
#define PERIGEE_REFERENCE_PATCH_H

#include <stdbool.h>

typedef struct field_box {
    double south, north, west, east;
} field_box;

bool field_box_holds(const field_box *outer, const field_box *inner);

// A line of 2 samples, or a curve through the middle two of 4.
enum { PATCH_LINEAR = 2, PATCH_CUBIC = 4, PATCH_MAX = 4 };

// Height = sum of c[i][j] u^i v^j for i, j < order, u = (north - lat) / (north - south),
// v = (lon - west) / (east - west); valid in `box`.
typedef struct field_patch {
    field_box box;
    int order; // PATCH_LINEAR or PATCH_CUBIC
    double c[PATCH_MAX][PATCH_MAX];
} field_patch;

// One row of samples, the first at longitude `lon` (deg), then each `step` farther east.
typedef struct patch_row {
    double lon, step;
    double sample[PATCH_MAX];
} patch_row;

// The patch in `box` of `order` rows, evenly spaced, whose middle two lie on the box's north and
// south edges; the box lies between the middle two samples of each row.
//   source  bilinear; or Catmull & Rom 1974: the cubic through the middle samples whose slopes
//           there are those of the chords beside them. C1, exact for quadratic surfaces
field_patch patch_make(const field_box *box, int order, const patch_row *rows);

double patch_height(const field_patch *patch, double lat, double lon);

// Slopes, metres a degree.
void patch_gradient(const field_patch *patch, double lat, double lon, double *per_lat,
                    double *per_lon);

// What no derivative in the patch exceeds, either way: metres a degree, and a square degree.
typedef struct patch_bounds {
    double lat, lon, lat_lat, lat_lon, lon_lon;
} patch_bounds;

patch_bounds patch_bound(const field_patch *patch);

// Not less than any height in a part of the patch: the highest corner, and as far above the surface
// that is bilinear between the corners as the second derivatives let it be, 1/8 of each times the
// square of its side.
double patch_max(const field_patch *patch, const patch_bounds *bounds, const field_box *part);

// A surface of that order lies between low - s and high + s, s = share * (high - low), where all
// its samples lie between low and high. A Catmull-Rom curve has weights -1/16, 9/16, 9/16, -1/16 in
// its middle, where their magnitudes add up to the most, 5/4; those of a surface to 25/16, of which
// the negative are 9/32.
double patch_overshoot(int order);

#endif
