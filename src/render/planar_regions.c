#include "render/planar_regions.h"

#include <math.h>

bool planar_region_empty(planar_region r)
{
    return r.row0 >= r.row1 || r.column0 >= r.column1;
}

static int larger(int a, int b)
{
    return a > b ? a : b;
}

static int smaller(int a, int b)
{
    return a < b ? a : b;
}

static planar_region intersect(planar_region a, planar_region b)
{
    return (planar_region){larger(a.row0, b.row0), smaller(a.row1, b.row1),
                           larger(a.column0, b.column0), smaller(a.column1, b.column1)};
}

static planar_region shrink(planar_region r, int by)
{
    return (planar_region){r.row0 + by, r.row1 - by, r.column0 + by, r.column1 - by};
}

// Inwards to even vertices.
static planar_region even(planar_region r)
{
    return (planar_region){r.row0 + (r.row0 & 1), r.row1 - (r.row1 & 1),
                           r.column0 + (r.column0 & 1), r.column1 - (r.column1 & 1)};
}

planar_region planar_region_wanted(const nest_square *s, double share)
{
    int middle = s->n / 2, half = (int)(share * middle);
    half -= (half & 1) == 0; // the middle is odd
    if (half < 3) half = 3;
    return (planar_region){middle - half, middle + half, middle - half, middle + half};
}

planar_region planar_region_in_coarser(const nest_square *f, const nest_square *c, planar_region r)
{
    int row = (int)(f->row / 2 - c->row), column = (int)(f->column / 2 - c->column);
    return (planar_region){row + r.row0 / 2, row + r.row1 / 2, column + r.column0 / 2,
                           column + r.column1 / 2};
}

static planar_region in_finer(const nest_square *c, const nest_square *f, planar_region r)
{
    int row = (int)(2 * c->row - f->row), column = (int)(2 * c->column - f->column);
    return (planar_region){row + 2 * r.row0, row + 2 * r.row1, column + 2 * r.column0,
                           column + 2 * r.column1};
}

int planar_regions_crop(const nest_square *squares, int first, int last, double share,
                        planar_region *clip, planar_region *active)
{
    active[first] = planar_region_wanted(&squares[first], 1);
    clip[first] = active[first];
    int level = first;
    for (int i = first + 1; i <= last; i++) {
        const nest_square *coarser = &squares[i - 1], *s = &squares[i];
        clip[i] = intersect(clip[i], in_finer(coarser, s, shrink(clip[i - 1], 1)));
        active[i] = even(intersect(planar_region_wanted(s, share), clip[i]));
        active[i] = intersect(active[i], in_finer(coarser, s, shrink(active[i - 1], 2)));
        if (planar_region_empty(active[i])) break;
        level = i;
    }
    return level;
}

double planar_region_transition(int n, planar_region a, planar_region f)
{
    double width = nest_transition_width(n);
    if (planar_region_empty(f)) {
        int least = smaller(a.row1 - a.row0, a.column1 - a.column0) / 2;
        return fmax(2, fmin(width, least));
    }
    int rows = smaller(f.row0 - a.row0, a.row1 - f.row1),
        columns = smaller(f.column0 - a.column0, a.column1 - f.column1);
    return fmax(2, fmin(width, smaller(rows, columns)));
}

static double farthest(const nest_square *s, planar_region r)
{
    double rows = fmax(s->view_row - r.row0, r.row1 - s->view_row),
           columns = fmax(s->view_column - r.column0, r.column1 - s->view_column);
    return fmax(rows, columns);
}

double planar_region_begin(const nest_square *s, planar_region a, planar_region f)
{
    double half = larger(a.row1 - a.row0, a.column1 - a.column0) / 2.0;
    double begin = half - planar_region_transition(s->n, a, f) - 1;
    return planar_region_empty(f) ? begin : fmax(begin, farthest(s, f));
}

int planar_region_frame(planar_region a, planar_region f, planar_region out[4])
{
    if (planar_region_empty(f)) return out[0] = a, !planar_region_empty(a);
    const planar_region parts[4] = {{a.row0, f.row0, a.column0, a.column1},
                                    {f.row0, f.row1, a.column0, f.column0},
                                    {f.row0, f.row1, f.column1, a.column1},
                                    {f.row1, a.row1, a.column0, a.column1}};
    int count = 0;
    for (int i = 0; i < 4; i++)
        if (!planar_region_empty(parts[i])) out[count++] = parts[i];
    return count;
}
