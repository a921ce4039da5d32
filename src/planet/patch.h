// The part of the map, at one zoom, from which a tile of the next zoom is made: the quarter (or
// half) of the parent under the child and two samples beyond on each side, put together from the
// parent's neighbours: across the antimeridian, from the opposite meridian beyond a pole, and
// resampled in longitude where the next tile row has tiles of another width.
//
// Everything made from patches is thereby a function of whole tiles alone, so that neighbours agree
// on every sample they share, exactly.
#ifndef PERIGEE_PLANET_PATCH_H
#define PERIGEE_PLANET_PATCH_H

#include "base/status.h"
#include "planet/grid.h"

enum {
    PATCH_MARGIN = 2,
    PATCH_ROWS = TILE_SIZE / 2 + 2 * PATCH_MARGIN,
    PATCH_MAX_COLS = TILE_SIZE + 2 * PATCH_MARGIN
};

// Row-major, `channels` floats a sample. Row 0, column 0 is PATCH_MARGIN samples north and west of
// the first sample under the child's north-west corner.
struct patch {
    tile_id child;
    int channels;   // 1 or 4
    int lon_factor; // child samples to one parent sample in longitude: 2, or 1
    int cols;       // TILE_SIZE / lon_factor + 2 PATCH_MARGIN
    float *data;    // PATCH_ROWS x cols x channels
};

// Copies a block of one tile: rows [row, row + rows), columns [col, col + cols) to `out`, `stride`
// floats a row.
typedef struct patch_block {
    tile_id tile;
    int row, rows, col, cols;
    float *out;
    int stride;
} patch_block;

// Fetches one block, all channels. What it returns is passed up.
typedef status (*patch_fetch)(void *user, const patch_block *block);

// Needs child.zoom > 0. ERR_MEMORY, or what fetch returned. Free with patch_deinit.
status patch_init(struct patch *p, tile_id child, int channels, patch_fetch fetch, void *user);
void patch_deinit(struct patch *p);

#endif
