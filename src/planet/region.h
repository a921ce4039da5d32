// A rectangle of samples of one zoom, and how it is made from the zoom before when tiles of it are
// not at hand: upsampled from the rectangle of half the size that lies around it there, which may
// be made in turn. The rectangles shrink to a few samples, so a tile far below the data costs about
// one and a half tiles and needs no other tile of its zoom.
//
// Rectangles run across tiles, over the antimeridian and, by the opposite meridian, beyond a pole.
// Where a tile row has tiles of another width, its samples are brought to the rectangle's columns
// by a four-point filter. Every sample is a function of place, zoom and stored tiles alone,
// whatever rectangle it is made in, to the bit.
#ifndef PERIGEE_PLANET_REGION_H
#define PERIGEE_PLANET_REGION_H

#include "base/status.h"
#include "planet/grid.h"

// Widest rectangle: the 8 tiles of a polar row, and two columns for each zoom on either side.
enum { REGION_MAX_COLS = 9 * TILE_SIZE, REGION_MAX_CHANNELS = 4 };

typedef struct region {
    enum tile_layer layer;
    int channels; // floats a sample: 1 or 4
    int zoom;
    int64_t row; // first global sample row; negative or past the last: beyond a pole
    int rows;
    int coalesce; // of the tile rows whose columns these are
    int64_t col;  // first global sample column of such rows, any integer; columns wrap
    int cols;
    int stride; // floats from a row to the next
    float *data;
} region;

// Rows and columns of one tile.
typedef struct region_block {
    tile_id tile;
    int row, rows, col, cols;
    float *out;
    int stride;
} region_block;

typedef struct region_source {
    void *user;
    // Copies a block of a tile at hand. `stored`: only if it is stored; otherwise any tile that
    // costs nothing will do, and zoom 0 must be given. *found is false when nothing was copied.
    // ERR_PENDING does not stop the others from being asked for.
    status (*fetch)(void *user, const region_block *block, bool stored, bool *found);
    // Makes `child`, which lies in one or two tile rows of one width, from the samples around it.
    status (*make)(void *user, const region *parent, const region *child);
    // Of one channel: rows brought to other columns stay no lower than what they are made of.
    bool floored;
} region_source;

// All of one tile, into or from `data`.
region region_of_tile(tile_id id, int channels, float *data);

// Fills r->data.
status region_fill(const region_source *source, const region *r);

// As region_fill for rows of one tile row, but from the zoom before even if tiles are at hand.
// Needs zoom > 0.
status region_make(const region_source *source, const region *r);

// The rectangle of the zoom before from which `r` is made; its data is NULL. All of r's tile rows
// must have one width, and their parents too.
region region_parent(const region *r);

// In either direction, sample x is made of samples region_first_tap(x) and the three after it of
// the zoom before.
int64_t region_first_tap(int64_t x);

#endif
