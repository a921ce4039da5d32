// Reference systems of import sources: which need no warp, and the warp of those that do. GDAL's
// handles are void * here.
#ifndef PERIGEE_PLANET_IMPORT_WARP_H
#define PERIGEE_PLANET_IMPORT_WARP_H

#include <stdbool.h>

#include "planet/import_raster.h"

// Is the dataset a north-up or south-up grid of degrees, columns from west to east, that lies
// within a tenth of a sample of the planet's longitude and latitude? (GDALDatasetH with a
// geotransform and a reference system.)
bool warp_is_geographic(void *dataset, geo_ellipsoid ellipsoid);

// A virtual dataset (GDALDatasetH, to be closed before `dataset`) of float bands on longitude and
// latitude in degrees, NaN outside, whose samples are the planet's at the zoom of the source's own
// sample distance: the median over the raster of the square root of a sample's area on the ground.
// A raster that holds a pole or spans all meridians gets the full circle. outline: its edges; none
// when it spans all meridians without a pole, or when some edge has no place. Logs and returns
// ERR_ARGUMENT when the raster cannot be placed on the planet.
status warp_to_geographic(void *dataset, const char *path, geo_ellipsoid ellipsoid, void **out,
                          raster_outline *outline);

#endif
