#include "clipmap/bounds.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"

// `old` covers every texel as it was when `rewritten` was last empty, `new` all that was written
// since.
struct cell {
    clip_range old, new;
    uint32_t rewritten;
};

struct clip_bounds {
    int rows, cells;
    struct cell *cell; // rows x cells
    clip_range *row;   // of all cells of a row
};

struct clip_bounds *clip_bounds_create(int rows, int cols)
{
    struct clip_bounds *b = NEW(struct clip_bounds);
    b->rows = rows;
    b->cells = cols / CLIP_CELL;
    size_t count = (size_t)rows * (size_t)b->cells;
    b->cell = NEW_ARRAY(struct cell, count);
    for (size_t i = 0; i < count; i++)
        b->cell[i] = (struct cell){CLIP_RANGE_EMPTY, CLIP_RANGE_EMPTY, 0};
    b->row = NEW_ARRAY(clip_range, (size_t)rows);
    for (int i = 0; i < rows; i++) b->row[i] = CLIP_RANGE_EMPTY;
    return b;
}

void clip_bounds_destroy(struct clip_bounds **bounds)
{
    if (!*bounds) return;
    free((*bounds)->cell);
    free((*bounds)->row);
    free(*bounds);
    *bounds = NULL;
}

int clip_bounds_cells(int tex_col, int cols)
{
    return (tex_col + cols - 1) / CLIP_CELL - tex_col / CLIP_CELL + 1;
}

static clip_range range_join(clip_range a, clip_range b)
{
    return (clip_range){a.min < b.min ? a.min : b.min, a.max > b.max ? a.max : b.max};
}

// A comparison with NaN is false: it leaves the range as it was.
static clip_range range_of(const float *samples, int count)
{
    clip_range r = CLIP_RANGE_EMPTY;
    for (int i = 0; i < count; i++) {
        r.min = samples[i] < r.min ? samples[i] : r.min;
        r.max = samples[i] > r.max ? samples[i] : r.max;
    }
    return r;
}

// The end, at most `end`, of the cell in which `col` lies.
static int cell_end(int col, int end)
{
    int e = (col / CLIP_CELL + 1) * CLIP_CELL;
    return e < end ? e : end;
}

void clip_bounds_reduce(const float *samples, int rows, int tex_col, int cols, clip_range *out)
{
    int end = tex_col + cols;
    for (int row = 0; row < rows; row++, samples += cols)
        for (int col = tex_col; col < end; col = cell_end(col, end))
            *out++ = range_of(samples + (col - tex_col), cell_end(col, end) - col);
}

static void cell_write(struct cell *c, clip_range range, int first, int count)
{
    uint32_t texels = (count == CLIP_CELL ? 0 : UINT32_C(1) << count) - 1;
    c->new = range_join(c->new, range);
    c->rewritten |= texels << first;
    if (c->rewritten != UINT32_MAX) return;
    *c = (struct cell){c->new, CLIP_RANGE_EMPTY, 0};
}

static clip_range range_of_cells(const struct cell *cells, int count)
{
    clip_range r = CLIP_RANGE_EMPTY;
    for (int i = 0; i < count; i++) r = range_join(r, range_join(cells[i].old, cells[i].new));
    return r;
}

void clip_bounds_write(struct clip_bounds *b, int tex_row, int rows, int tex_col, int cols,
                       const clip_range *ranges)
{
    int end = tex_col + cols;
    for (int row = tex_row; row < tex_row + rows; row++) {
        struct cell *line = b->cell + (size_t)row * (size_t)b->cells;
        for (int col = tex_col; col < end; col = cell_end(col, end))
            cell_write(&line[col / CLIP_CELL], *ranges++, col % CLIP_CELL,
                       cell_end(col, end) - col);
        b->row[row] = range_of_cells(line, b->cells);
    }
}

clip_range clip_bounds_of(const struct clip_bounds *b, int64_t row0, int64_t row1)
{
    clip_range r = CLIP_RANGE_EMPTY;
    for (int64_t row = row0; row < row1; row++)
        r = range_join(r, b->row[window_texel(row, b->rows)]);
    return r;
}
