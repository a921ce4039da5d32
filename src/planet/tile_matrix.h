// How the tiles of a server lie against the tiles of the planet's grid, and the resampling from the
// one to the other. Pure functions. Any thread.
//
// A planet tile is taken from the coarsest level of the server whose columns are no wider than its
// own. In Web Mercator and in longitude and latitude such columns divide the planet's exactly, so
// only rows are resampled: each is the mean of the rows it covers, with weights about its own
// centre, or where they are wider, the linear interpolation there. Heights are averaged as
// they are; colours in linear light, by their coverage. Near the poles of a grid in longitude and
// latitude, where a planet tile is more than four of the server's wide, a coarser level is taken.
#ifndef PERIGEE_PLANET_TILE_MATRIX_H
#define PERIGEE_PLANET_TILE_MATRIX_H

#include <stdbool.h>
#include <stdint.h>

#include "planet/grid.h"

enum tile_projection {
    MATRIX_MERCATOR,   // Web Mercator: one tile at level 0 (EPSG:3857, spherical development)
    MATRIX_GEOGRAPHIC, // longitude and latitude: 2 x 1 tiles at level 0 (WorldCRS84Quad)
    MATRIX_PLANET,     // the planet's own grid (planet/grid.h); tiles of 256
};

typedef struct tile_matrix {
    enum tile_projection projection;
    int tile_size; // samples: a power of two, 64 to 1024
    int min_level, max_level;
} tile_matrix;

enum { MATRIX_MAX_TILES = 16, MATRIX_MAX_LEVEL = 26 };

// The server's tiles [x0, x1) x [y0, y1) at a level, y from the north, that a planet tile needs:
// at most MATRIX_MAX_TILES. None where there is no data (beyond Mercator's 85 degrees).
typedef struct tile_span {
    int level;
    int x0, x1, y0, y1;
} tile_span;

// False when the server has no level fine enough for the tile, or it would take too many tiles.
bool matrix_span(const tile_matrix *matrix, tile_id id, tile_span *out);

// Finest zoom of the planet with a tile for which matrix_span holds, at the equator; -1: none.
int matrix_max_zoom(const tile_matrix *matrix);

// Bounds of a server's tile, rad.
void matrix_bounds(const tile_matrix *matrix, int level, int x, int y, double *west, double *south,
                   double *east, double *north);

// The span's tiles side by side in one raster, rows (y1 - y0) * tile_size of (x1 - x0) * tile_size:
// heights (NaN where there is none), or R, G, B, A not multiplied. Out: a planet tile as source.h
// has them.
void matrix_resample_heights(const tile_matrix *matrix, tile_id id, const tile_span *span,
                             const float *raster, float *out);
void matrix_resample_pixels(const tile_matrix *matrix, tile_id id, const tile_span *span,
                            const uint8_t *raster, uint8_t *out);

#endif
