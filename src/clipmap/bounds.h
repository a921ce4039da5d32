// Bounds of the heights a toroidal texture holds, without a copy of them. A cell is one texture row
// by 32 columns. Invariant: a cell's range covers all 32 texels, NaN aside; once each of them has
// been written again, nothing of what was there before is left in it. Inside the clipmap room. Any
// thread, one at a time.
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

// The strip of these ranges has been written to the texture.
void clip_bounds_write(struct clip_bounds *bounds, int tex_row, int rows, int tex_col, int cols,
                       const clip_range *ranges);

// Covers the samples of window rows [row0, row1), at most as many as the texture has, at all
// columns.
clip_range clip_bounds_of(const struct clip_bounds *bounds, int64_t row0, int64_t row1);

#endif
