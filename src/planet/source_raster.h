// Any raster that GDAL opens as a source, without an import: each tile is warped when it is asked
// for, from the window of the raster that it needs and from the overview that is fine enough.
#ifndef PERIGEE_PLANET_SOURCE_RASTER_H
#define PERIGEE_PLANET_SOURCE_RASTER_H

#include "planet/plane_map.h"
#include "planet/source.h"

// `layer`: LAYER_HEIGHT or LAYER_COLOR; LAYER_COUNT: by its bands (three or more, a palette or one
// of bytes: colour). Heights: metres above the ellipsoid, whatever the vertical datum; feet and the
// like are converted. Heights finer than the tile are averaged, coarser ones interpolated; colour
// likewise, as it is encoded. The ellipsoid is that of the raster's reference system. Each thread
// that reads has a handle of its own. ERR_NOT_FOUND, ERR_FORMAT, ERR_ARGUMENT (no georeference),
// all logged.
status source_raster_open(const char *path, enum tile_layer layer, struct source **out);

// The same laid on the map of a projected raster; `map` outlives the source.
status source_raster_open_on(const char *path, enum tile_layer layer, const struct plane_map *map,
                             struct source **out);

#endif
