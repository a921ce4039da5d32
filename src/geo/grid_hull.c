// Andrew's monotone chain.
#include "geo/grid_hull.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void grid_hull_add(struct grid_hull *h, double x, double y)
{
    if (h->count == GRID_HULL_MAX) return;
    h->point[h->count][0] = x;
    h->point[h->count][1] = y;
    h->count++;
}

static int left_first(const void *a, const void *b)
{
    const double *p = a, *q = b;
    if (p[0] != q[0]) return (p[0] > q[0]) - (p[0] < q[0]);
    return (p[1] > q[1]) - (p[1] < q[1]);
}

// Positive when c lies to the left of the way from a to b.
static double turn(const double a[2], const double b[2], const double c[2])
{
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

static int chain(const struct grid_hull *h, double side, double out[][2])
{
    int n = 0;
    for (int i = 0; i < h->count; i++) {
        while (n > 1 && side * turn(out[n - 2], out[n - 1], h->point[i]) <= 0) n--;
        memcpy(out[n++], h->point[i], sizeof h->point[i]);
    }
    return n;
}

void grid_hull_close(struct grid_hull *h)
{
    qsort(h->point, (size_t)h->count, sizeof h->point[0], left_first);
    h->lower_count = chain(h, 1, h->lower);
    h->upper_count = chain(h, -1, h->upper);
}

static double chain_at(const double chain_points[][2], int count, double x)
{
    int i = 1;
    while (i < count - 1 && chain_points[i][0] < x) i++;
    if (count < 2) return chain_points[0][1];
    const double *a = chain_points[i - 1], *b = chain_points[i];
    double wide = b[0] - a[0];
    return wide > 0 ? a[1] + (b[1] - a[1]) * ((x - a[0]) / wide) : a[1];
}

// Lowest of a lower chain (side 1) or highest of an upper one (side -1).
static double extreme(const double points[][2], int count, double side, double left, double right)
{
    double a = chain_at(points, count, left), b = chain_at(points, count, right);
    double most = side * fmin(side * a, side * b);
    for (int i = 0; i < count; i++)
        if (points[i][0] > left && points[i][0] < right)
            most = side * fmin(side * most, side * points[i][1]);
    return most;
}

bool grid_hull_between(const struct grid_hull *h, double left, double right, double *low,
                       double *high)
{
    if (!h->count) return false;
    left = fmax(left, h->point[0][0]);
    right = fmin(right, h->point[h->count - 1][0]);
    if (!(left <= right)) return false;
    *low = extreme(h->lower, h->lower_count, 1, left, right);
    *high = fmax(*low, extreme(h->upper, h->upper_count, -1, left, right));
    return true;
}
