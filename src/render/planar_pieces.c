#include "render/planar_pieces.h"

#include <stdlib.h>

#include "base/memory.h"

struct writer {
    planar_pieces *p;
    planar_footprint *piece;
};

static struct writer begin(planar_pieces *p, enum planar_piece piece)
{
    planar_footprint *f = &p->piece[piece];
    f->first_index = (uint32_t)p->index_count;
    f->first_vertex = (uint32_t)p->vertex_count;
    return (struct writer){p, f};
}

static void end(struct writer w)
{
    w.piece->indices = (uint32_t)w.p->index_count - w.piece->first_index;
    w.piece->vertices = (uint32_t)w.p->vertex_count - w.piece->first_vertex;
}

static uint16_t add_vertex(struct writer w, int row, int column)
{
    uint16_t *v = w.p->vertices + 2 * w.p->vertex_count++;
    v[0] = (uint16_t)row;
    v[1] = (uint16_t)column;
    return (uint16_t)(w.p->vertex_count - 1 - w.piece->first_vertex);
}

static void add_triangle(struct writer w, int a, int b, int c)
{
    uint16_t *i = w.p->indices + w.p->index_count;
    i[0] = (uint16_t)a;
    i[1] = (uint16_t)b;
    i[2] = (uint16_t)c;
    w.p->index_count += 3;
}

// A grid of quads with vertices of its own.
static void add_grid(struct writer w, int row, int column, int rows, int columns)
{
    int first = (int)(w.p->vertex_count - w.piece->first_vertex), across = columns + 1;
    for (int r = 0; r <= rows; r++)
        for (int c = 0; c <= columns; c++) add_vertex(w, row + r, column + c);
    for (int r = 0; r < rows; r++) {
        for (int c = 0; c < columns; c++) {
            int nw = first + r * across + c, ne = nw + 1, sw = nw + across, se = sw + 1;
            add_triangle(w, se, ne, nw);
            add_triangle(w, sw, se, nw);
        }
    }
}

static void add_border_side(struct writer w, int n, int row, int column, int down, int right)
{
    uint16_t before = add_vertex(w, row, column);
    for (int i = 1; i < n - 1; i += 2) {
        uint16_t middle = add_vertex(w, row + i * down, column + i * right);
        uint16_t after = add_vertex(w, row + (i + 1) * down, column + (i + 1) * right);
        add_triangle(w, before, after, middle);
        before = after;
    }
}

static void add_trims(planar_pieces *p, int m)
{
    int low = m - 1, side = 2 * m;
    for (int i = 0; i < 4; i++) {
        int row_last = i >> 1, column_last = i & 1;
        struct writer w = begin(p, (enum planar_piece)(PLANAR_TRIM + i));
        add_grid(w, row_last ? low + side - 1 : low, low, 1, side);
        add_grid(w, row_last ? low : low + 1, column_last ? low + side - 1 : low, side - 1, 1);
        end(w);
    }
}

static void add_all(planar_pieces *p, int n)
{
    int m = (n + 1) / 4, far = 3 * m - 1, middle = 2 * m - 2;
    struct writer w = begin(p, PLANAR_BLOCK);
    add_grid(w, 0, 0, m - 1, m - 1);
    end(w);
    w = begin(p, PLANAR_FIXUP);
    add_grid(w, 0, middle, m - 1, 2);
    add_grid(w, far, middle, m - 1, 2);
    add_grid(w, middle, 0, 2, m - 1);
    add_grid(w, middle, far, 2, m - 1);
    end(w);
    w = begin(p, PLANAR_CROSS);
    add_grid(w, m - 1, middle, 2 * m, 2);
    add_grid(w, middle, m - 1, 2, m - 1);
    add_grid(w, middle, 2 * m, 2, m - 1);
    end(w);
    w = begin(p, PLANAR_BORDER);
    add_border_side(w, n, 0, 0, 0, 1);
    add_border_side(w, n, n - 1, 0, 0, 1);
    add_border_side(w, n, 0, 0, 1, 0);
    add_border_side(w, n, 0, n - 1, 1, 0);
    end(w);
    w = begin(p, PLANAR_CLOSING);
    add_grid(w, 0, n - 1, n - 1, 2);
    end(w);
    add_trims(p, m);
}

planar_pieces planar_pieces_make(int n)
{
    size_t m = (size_t)(n + 1) / 4, most = m * m + 64 * (size_t)n + 256;
    planar_pieces p = {.vertices = NEW_ARRAY(uint16_t, 2 * most),
                       .indices = NEW_ARRAY(uint16_t, 6 * most)};
    add_all(&p, n);
    return p;
}

void planar_pieces_free(planar_pieces *p)
{
    free(p->vertices);
    free(p->indices);
    *p = (planar_pieces){0};
}

void planar_block_offset(int n, int block, int offset[2])
{
    // Of the rows and columns of blocks, clockwise from the first; then the interior.
    static const uint8_t at[PLANAR_BLOCKS][2] = {{0, 0}, {0, 1}, {0, 2}, {0, 3}, {1, 3}, {2, 3},
                                                 {3, 3}, {3, 2}, {3, 1}, {3, 0}, {2, 0}, {1, 0},
                                                 {1, 1}, {1, 2}, {2, 1}, {2, 2}};
    int m = (n + 1) / 4;
    const int starts[4] = {0, m - 1, 2 * m, 3 * m - 1};
    offset[0] = starts[at[block][0]];
    offset[1] = starts[at[block][1]];
}
