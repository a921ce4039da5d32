// Everything is computed in double from integers, so that mirrored columns are mirrored to the last
// bit.
#include "geo/rings.h"

#include <math.h>

#include "base/vec.h"
#include "geo/shared.h"

int ring_columns(const ring_params *p)
{
    return p->azimuth_steps + 2;
}

int ring_count(const ring_params *p)
{
    return p->levels * p->rings_per_level + 1;
}

double ring_angle(const ring_params *p, double ring)
{
    return M_PI * exp2(-ring / p->rings_per_level);
}

double ring_level_of_angle(double angle)
{
    return log2(M_PI / angle);
}

// Past all corners of a map.
#define PLANE_RADIUS_MAX 64.0

double ring_plane_radius(double angle)
{
    return angle < 3 ? fmin(2 * tan(angle / 2), PLANE_RADIUS_MAX) : PLANE_RADIUS_MAX;
}

double ring_plane_angle(double distance)
{
    return 2 * atan(distance / 2);
}

static int is_west(const ring_params *p, int column)
{
    return column > p->azimuth_steps / 2;
}

void ring_direction(const ring_params *p, int column, double out[2])
{
    int n = p->azimuth_steps, k = column;
    double east = 1, north = 1;
    if (is_west(p, column)) {
        k = n - (column - 1);
        east = -1;
    }
    if (4 * k > n) {
        k = n / 2 - k;
        north = -1;
    }
    double s, c;
    if (8 * k <= n) {
        s = k ? sin(2 * M_PI * k / n) : 0;
        c = k ? cos(2 * M_PI * k / n) : 1;
    } else {
        int from_east = n - 4 * k;
        s = from_east ? cos(M_PI * from_east / (2.0 * n)) : 1;
        c = from_east ? sin(M_PI * from_east / (2.0 * n)) : 0;
    }
    out[0] = c == 0 ? 0 : north * c;
    out[1] = s == 0 ? 0 : east * s;
}

static void split(double x, float *leading, float *rest)
{
    *leading = leading_bits_f((float)x);
    *rest = (float)(x - (double)*leading);
}

ring_row ring_row_at(double angle)
{
    double half = sin(angle / 2);
    ring_row row = {.drop = (float)(2 * half * half)};
    split(angle < M_PI ? sin(angle) : 0, &row.radius, &row.radius_low);
    return row;
}

ring_row ring_plane_row_at(double angle)
{
    ring_row row = {0};
    split(ring_plane_radius(angle), &row.radius, &row.radius_low);
    return row;
}

ring_column ring_column_at(const ring_params *p, int column)
{
    double direction[2];
    ring_column c;
    ring_direction(p, column, direction);
    split(direction[0], &c.north, &c.north_low);
    split(direction[1], &c.east, &c.east_low);
    return c;
}

void ring_vertex(const ring_params *p, int ring, int column, float out[3])
{
    ring_row r = ring_row_at(ring_angle(p, ring));
    ring_column c = ring_column_at(p, column);
    float east = ring_coordinate_f(r.radius, r.radius_low, c.east, c.east_low);
    out[0] = ring_coordinate_f(r.radius, r.radius_low, c.north, c.north_low);
    out[1] = is_west(p, column) ? fminf(east, -RING_SEAM) : fmaxf(east, RING_SEAM);
    out[2] = r.drop;
}
