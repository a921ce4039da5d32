// The footprints that a level of a geometry clipmap is made of (Asirvatham & Hoppe 2005, 2.3.2),
// written once for all levels and frames, with 16-bit indices. The m x m block is placed by an
// offset, the others stand at their rows and columns of the level's n x n square, n = 4 m - 1:
//
//     ring      12 blocks, 4 fix-ups two quads wide in the middle of the sides
//     trim      an L one quad wide, where the finer level leaves a row and a column free
//     interior  4 blocks and a cross of two quads' width, in the finest level
//     border    a triangle for every other vertex of the outer border, which closes the crack to
//               the coarser level: it has no area on a plane, and the arc's sagitta on a planet.
//               It may face either way
//     closing   the last two columns of quads before the circle closes, of level 0
//
// Pure functions. Any thread.
#ifndef PERIGEE_RENDER_PLANAR_PIECES_H
#define PERIGEE_RENDER_PLANAR_PIECES_H

#include <stddef.h>
#include <stdint.h>

enum planar_piece {
    PLANAR_BLOCK,
    PLANAR_FIXUP,
    PLANAR_CROSS,
    PLANAR_BORDER,
    PLANAR_CLOSING,
    PLANAR_TRIM, // + 2 (the row is the last) + (the column is the last): four of them
    PLANAR_PIECES = PLANAR_TRIM + 4,
};

enum { PLANAR_RING_BLOCKS = 12, PLANAR_BLOCKS = 16 }; // the last four: the interior

typedef struct planar_footprint {
    uint32_t first_index, indices; // of 16 bits, counted from first_vertex
    uint32_t first_vertex, vertices;
} planar_footprint;

typedef struct planar_pieces {
    planar_footprint piece[PLANAR_PIECES];
    uint16_t *vertices; // row, column
    uint16_t *indices;
    size_t vertex_count, index_count;
} planar_pieces;

// n: of nest_size_valid. Two triangles a quad, counter-clockwise with rows southward and columns
// eastward; the last vertex of both is that of the smaller row and column (mesh.frag).
planar_pieces planar_pieces_make(int n);
void planar_pieces_free(planar_pieces *pieces);

// Row and column of a block's first vertex in the square.
void planar_block_offset(int n, int block, int offset[2]);

#endif
