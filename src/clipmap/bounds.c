#include "clipmap/bounds.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"

// The range of a block: the one that lies `turn` textures east of the map's first column.
struct block {
    clip_range range;
    int32_t turn; // -1: of none
};

struct row {
    int64_t row;         // of the map
    int64_t first, last; // blocks that `range` is of
    clip_range range;
    bool known; // `range` is
};

// Blocks of neighbouring turns, which a window's first and last columns can bring into one cell,
// have places of their own.
struct clip_bounds {
    int rows, cells, share;
    struct block *block; // rows x cells x 2, by the turn's last bit
    struct row *row;
};

static void row_clear(struct clip_bounds *b, int tex_row, int64_t row)
{
    struct block *line = b->block + 2 * (size_t)tex_row * (size_t)b->cells;
    for (int i = 0; i < 2 * b->cells; i++) line[i] = (struct block){CLIP_RANGE_EMPTY, -1};
    b->row[tex_row] = (struct row){.row = row};
}

struct clip_bounds *clip_bounds_create(int rows, int cols)
{
    struct clip_bounds *b = NEW(struct clip_bounds);
    b->rows = rows;
    b->cells = cols / CLIP_CELL;
    b->block = NEW_ARRAY(struct block, 2 * (size_t)rows * (size_t)b->cells);
    b->row = NEW_ARRAY(struct row, (size_t)rows);
    for (int i = 0; i < rows; i++) row_clear(b, i, INT64_MIN);
    return b;
}

void clip_bounds_destroy(struct clip_bounds **bounds)
{
    if (!*bounds) return;
    free((*bounds)->block);
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

static int64_t floor_div(int64_t a, int64_t b)
{
    return a / b - (a % b < 0);
}

// Where a block's range has its place in a row; its turn.
static struct block *place_of(const struct clip_bounds *b, int tex_row, int64_t block,
                              int32_t *turn)
{
    int64_t turns = floor_div(block, b->cells), circle = INT64_C(1) << b->share;
    *turn = (int32_t)(turns - floor_div(turns, circle) * circle);
    int64_t cell = block - turns * b->cells;
    return &b->block[2 * ((size_t)tex_row * (size_t)b->cells + (size_t)cell) + (*turn & 1)];
}

void clip_bounds_write(struct clip_bounds *b, int share, window_rect rect, const clip_range *ranges,
                       bool whole)
{
    int64_t first = floor_div(rect.col0, CLIP_CELL), last = floor_div(rect.col1 - 1, CLIP_CELL);
    for (int i = 0; share != b->share && i < b->rows; i++) row_clear(b, i, INT64_MIN);
    b->share = share;
    for (int64_t row = rect.row0; row < rect.row1; row++) {
        int tex_row = window_texel(row, b->rows);
        if (b->row[tex_row].row != row) row_clear(b, tex_row, row);
        b->row[tex_row].known = false;
        for (int64_t k = first; k <= last; k++, ranges++) {
            int32_t turn;
            struct block *at = place_of(b, tex_row, k, &turn);
            bool add = !whole && at->turn == turn;
            *at = (struct block){add ? range_join(at->range, *ranges) : *ranges, turn};
        }
    }
}

static clip_range range_of_row(const struct clip_bounds *b, int tex_row, int64_t first,
                               int64_t last)
{
    clip_range r = CLIP_RANGE_EMPTY;
    for (int64_t k = first; k <= last; k++) {
        int32_t turn;
        const struct block *at = place_of(b, tex_row, k, &turn);
        if (at->turn == turn) r = range_join(r, at->range);
    }
    return r;
}

clip_range clip_bounds_of(struct clip_bounds *b, int share, window_rect rect)
{
    clip_range r = CLIP_RANGE_EMPTY;
    int64_t first = floor_div(rect.col0, CLIP_CELL), last = floor_div(rect.col1 - 1, CLIP_CELL);
    if (share != b->share) return r;
    for (int64_t row = rect.row0; row < rect.row1; row++) {
        int tex_row = window_texel(row, b->rows);
        struct row *line = &b->row[tex_row];
        if (line->row != row) continue;
        if (!line->known || line->first != first || line->last != last)
            *line = (struct row){row, first, last, range_of_row(b, tex_row, first, last), true};
        r = range_join(r, line->range);
    }
    return r;
}
