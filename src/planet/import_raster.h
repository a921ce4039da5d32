// One source of an import as a grid of longitude and latitude. Samples come as float planes, NaN
// where there is no data (nor are heights that are not finite, or greater than half the planet's
// radius or 5000 km): metres; pixels in linear light [0, 1]. A source in another
// reference system is warped to such a grid, aligned with the planet's samples at the source's own
// zoom. A handle belongs to one thread.
#ifndef PERIGEE_PLANET_IMPORT_RASTER_H
#define PERIGEE_PLANET_IMPORT_RASTER_H

#include <stdbool.h>
#include <stdint.h>

#include "planet/import.h"

// What to open: a file; a file without georeference that covers the globe from 180 W (`global`); or
// a global grid of heights in memory (borrowed), row 0 northmost, whose path is a name only.
typedef struct import_input {
    import_source source;
    bool global;
    const float *memory;
    int width, height;
} import_input;

// A closed line of points of longitude and latitude in rad. count 0: there is none.
enum { OUTLINE_POINTS = 64 };

typedef struct raster_outline {
    int count;
    double lon[OUTLINE_POINTS], lat[OUTLINE_POINTS];
} raster_outline;

// Sample (col, row) covers [west + col dlon, ... + dlon] x [north - (row + 1) dlat, north - row
// dlat], rad.
typedef struct raster_grid {
    int width, height;
    double west, north, dlon, dlat;
    double south, east; // east may exceed pi
    bool full_circle;   // columns wrap after `width`
    int channels;       // heights 1, colour 3, night 1
    int read_planes;    // planes of room that raster_read needs: heights 1, pixels 3
    int zoom;           // the source's finest zoom
    // Where a raster of another reference system ends inside the grid; else it ends with the grid.
    raster_outline outline;
} raster_grid;

struct raster;

// Logs and returns ERR_NOT_FOUND, ERR_FORMAT (not a raster, or one without samples) or ERR_ARGUMENT
// (no georeference); of a vertical datum also ERR_UNSUPPORTED.
status raster_open(const import_input *input, geo_ellipsoid ellipsoid, struct raster **out);
void raster_close(struct raster **raster);

const raster_grid *raster_get_grid(const struct raster *raster);

// Reads a window that lies inside the raster: `channels` planes of rows x cols floats, in room for
// `read_planes`. ERR_FORMAT is not logged, because handles of several workers meet the same fault:
// raster_error tells it.
status raster_read(struct raster *raster, int col, int row, int cols, int rows, float *planes);
const char *raster_error(const struct raster *raster);

// Heights of the raster at a tile's samples (256 x 256) to heights above the ellipsoid. Errors as
// raster_read.
status raster_to_ellipsoid(struct raster *raster, tile_id id, float *heights);

// The coarsest zoom whose latitude step is at most 1.1 `step` (rad), at most GRID_MAX_ZOOM.
int raster_zoom_of_step(double step);

#endif
