// The tile grid: OGC WorldCRS84Quad with variable matrix widths (OGC 17-083r4). Zoom z has 2^z tile
// rows, row 0 at the north pole, each of 256 sample rows; a tile row is divided into 2^(z+1) /
// coalesce tiles, tile 0 at longitude -pi. coalesce is the greatest power of two <= 1 /
// cos(latitude) at the row's edge nearest to the equator (and <= 2^(z+1)), so a sample is never
// narrower than half its height on the ground. Samples are cell centres. Pure functions. Any
// thread.
#ifndef PERIGEE_PLANET_GRID_H
#define PERIGEE_PLANET_GRID_H

#include <stdbool.h>
#include <stdint.h>

enum { TILE_SIZE = 256, GRID_MAX_ZOOM = 24 };

enum tile_layer { LAYER_HEIGHT, LAYER_COLOR, LAYER_NIGHT, LAYER_COUNT };

// "height", "color", "night".
const char *tile_layer_name(enum tile_layer layer);

typedef struct tile_id {
    enum tile_layer layer;
    int zoom;
    int row, col;
} tile_id;

bool tile_id_equal(tile_id a, tile_id b);

// The tile at zoom - 1 that holds this one. Needs zoom > 0.
tile_id tile_parent(tile_id id);

int grid_rows(int zoom);              // tile rows: 2^zoom
int grid_coalesce(int zoom, int row); // equator-width tiles merged into one
int grid_cols(int zoom, int row);     // tiles in the row: 2^(zoom + 1) / coalesce

// Sample spacing in radians: in latitude pi / (256 2^zoom); in longitude the same times coalesce.
double grid_step_lat(int zoom);
double grid_step_lon(int zoom, int row);

// Latitude of a sample row's centre (global row in [0, 256 2^zoom), 0 northmost): pi/2 - (row +
// 1/2) step.
double grid_lat(int zoom, int64_t sample_row);

// Bounds of a tile in rad: west < east, south < north.
void grid_bounds(tile_id id, double *west, double *south, double *east, double *north);

#endif
