// What a field holds of its tiles. Private to the field. Filled by field_tiles.c and field.c, then
// read only.
#ifndef PERIGEE_REFERENCE_FIELD_TILES_H
#define PERIGEE_REFERENCE_FIELD_TILES_H

#include <stdatomic.h>

#include "reference/field.h"

// Maxima of blocks of 4 x 4 samples, of 8 x 8, and so on to the whole tile.
enum {
    FIELD_FINEST_BLOCK = 2,
    FIELD_COARSEST_BLOCK = 8,
    FIELD_BLOCKS = 64 * 64 + 32 * 32 + 16 * 16 + 8 * 8 + 4 * 4 + 2 * 2 + 1
};

struct field_tile {
    tile_id id;
    float min, max, bend;
    // In units of field_tile_unit(), rounded away: above min, and below max (bicubic only). NULL
    // when all samples are equal.
    uint16_t *maxima, *minima;
};

// Candidates [first, first + count) of a tile row, columns counted around the circle. index[at + i]
// is the tile of column first + i, or -1: not in sight.
struct field_row {
    int first, count, cols;
    size_t at;
};

struct field {
    field_params params;
    int first_row, rows; // tile rows held
    struct field_row *row;
    int32_t *index;
    struct field_tile *tile;
    size_t tiles;
    double min, max, bend; // of the surface
    _Atomic status error;
};

// Lists the tiles in sight of ground between `low` and `high`; f->params is set. ERR_ARGUMENT,
// not logged, when they are more than FIELD_MAX_TILES or would take too long to list.
status field_list_tiles(struct field *f, double low, double high);
void field_forget_tiles(struct field *f);

// Tile column `col`, any integer, brought to [0, cols).
int field_wrap(int64_t col, int64_t cols);

static inline double field_tile_unit(const struct field_tile *t)
{
    return ((double)t->max - t->min) / 65535 * (1 + 1e-9);
}

#endif
