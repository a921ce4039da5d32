// Heights above another surface than the ellipsoid (mean sea level by EGM96, say) brought to the
// ellipsoid, through PROJ and its grids. GDAL's handles are void * here. A handle belongs to one
// thread.
#ifndef PERIGEE_PLANET_IMPORT_VERTICAL_H
#define PERIGEE_PLANET_IMPORT_VERTICAL_H

#include "geo/ellipsoid.h"
#include "planet/grid.h"
#include "base/status.h"

struct vertical;

// What the heights of `dataset` (GDALDatasetH) stand above. `said`: "ellipsoid", "egm96", "egm2008"
// or "EPSG:n", a vertical reference system of metres; NULL: what the dataset's reference system
// declares, nothing declared being the ellipsoid. *out is NULL when nothing is to be done. Logs and
// returns ERR_ARGUMENT when the name is none or the planet is not the Earth, ERR_UNSUPPORTED when
// PROJ has no grid for it.
status vertical_open(void *dataset, const char *path, const char *said, geo_ellipsoid ellipsoid,
                     struct vertical **out);
void vertical_close(struct vertical **vertical);

// Adds to heights (metres, 256 x 256 at the tile's samples, NaN kept) how far the surface lies
// above WGS84 there. The surface is taken from PROJ at points at most 0.25' apart and bilinearly
// between, at every sample where those are farther apart; measured against every sample:
// tests/planet/test_import_vertical.c. ERR_FORMAT, not logged, when PROJ refuses a point.
status vertical_to_ellipsoid(struct vertical *vertical, tile_id id, float *heights);

#endif
