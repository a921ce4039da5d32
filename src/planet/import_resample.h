// One raster onto the samples of one tile.
//
// In latitude the raster is interpolated (a tile is never made coarser than the raster's own zoom
// asks). In longitude the kernel is defined on the ground: where the raster's columns are farther
// apart than the tile's rows it is interpolated, where they are closer, as towards the poles, it is
// averaged by a cubic B-spline of standard deviation 0.45 tile rows, the width of the pyramid's
// filter; between 1 and 1.5 columns a row one goes over into the other. Interpolation is
// Catmull-Rom's cubic, held between the two samples around the point: it neither lowers a coast
// below the sea nor lifts it, and a flat sea stays flat. A sample whose nearest sample has no data
// has none.
#ifndef PERIGEE_PLANET_IMPORT_RESAMPLE_H
#define PERIGEE_PLANET_IMPORT_RESAMPLE_H

#include "planet/import_raster.h"

// Room that grows as needed; zero to begin with. One thread at a time.
struct resample_room {
    float *planes, *line, *column;
    size_t planes_size, line_size, column_size;
};

void resample_room_deinit(struct resample_room *room);

// planes: channels x 256 x 256, NaN where the raster has no data.
status resample_tile(struct raster *raster, tile_id id, struct resample_room *room, float *planes);

// Can any sample of the tile lie on the raster?
bool resample_touches(const raster_grid *grid, tile_id id);

#endif
