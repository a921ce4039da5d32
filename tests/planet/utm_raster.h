// A raster in a projected reference system whose height is known everywhere.
#ifndef PERIGEE_TESTS_UTM_RASTER_H
#define PERIGEE_TESTS_UTM_RASTER_H

#include "base/status.h"

// Bounds of the heights, m.
#define UTM_RASTER_LOW  260.0
#define UTM_RASTER_HIGH 540.0
#define UTM_RASTER_STEP 30.0 // m from sample to sample

// Writes a GeoTIFF of UTM zone 32 N: 45 N 9 E, the zone's easting 500,000 m and northing
// 4,982,950.4 m, is the corner between columns width / 2 - 1 and width / 2, rows height / 2 - 1 and
// height / 2. Replaces an existing file.
status utm_raster_write(const char *path, int width, int height);

// Bilinear between the samples of any such raster, metres east and north of that corner. Its slope
// is below 0.4.
double utm_raster_height(double east, double north);

#endif
