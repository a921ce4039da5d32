// Bounds of the heights a toroidal texture holds, without a copy of them. A block is one row by 32
// columns of the map, beginning at a multiple of 32; a cell the same of the texture, which holds
// one block or, where the window begins and ends, parts of two. Invariant: a block's range covers
// those of its samples that the texture holds and, where it was given so, is that of all 32, so
// that bounds do not depend on what the window held before. Inside the clipmap room. Any thread,
// one at a time.
#ifndef PERIGEE_CLIPMAP_BOUNDS_H
#define PERIGEE_CLIPMAP_BOUNDS_H

#include "clipmap/window.h"

enum { CLIP_CELL = 32 };

typedef struct clip_range {
    float min, max; // +inf, -inf: of nothing
} clip_range;

#define CLIP_RANGE_EMPTY ((clip_range){HUGE_VALF, -HUGE_VALF})

struct clip_bounds;

// cols: a multiple of CLIP_CELL.
struct clip_bounds *clip_bounds_create(int rows, int cols);
void clip_bounds_destroy(struct clip_bounds **bounds);

// Cells that a row of a strip touches; the strip does not wrap.
int clip_bounds_cells(int tex_col, int cols);

// Ranges of a strip's rows, cell by cell: out[rows * clip_bounds_cells(tex_col, cols)]. NaN is
// passed over.
void clip_bounds_reduce(const float *samples, int rows, int tex_col, int cols, clip_range *out);

// A strip of a window with this share, which does not wrap, has been written to the texture.
// ranges: of its rows, block by block; `whole`: of all 32 samples of a block, not only the strip's.
void clip_bounds_write(struct clip_bounds *bounds, int share, window_rect rect,
                       const clip_range *ranges, bool whole);

// Covers what the texture holds of a rectangle of such a window, at most as large as the texture,
// and no block that has nothing in it.
clip_range clip_bounds_of(struct clip_bounds *bounds, int share, window_rect rect);

#endif
