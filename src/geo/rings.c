// Everything is computed in double from integers, so that mirrored columns are mirrored to the last
// bit.
#include "geo/rings.h"

#include <math.h>

#include "base/vec.h"

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

static void set_vertex(const ring_params *p, int column, double radius, double drop, float out[3])
{
    double direction[2];
    ring_direction(p, column, direction);
    out[0] = (float)(radius * direction[0]);
    out[1] = (float)(radius * direction[1]);
    out[2] = (float)drop;
    if (out[1] == 0) out[1] = is_west(p, column) ? -RING_SEAM : RING_SEAM;
}

void ring_vertex(const ring_params *p, int ring, int column, float out[3])
{
    double angle = ring_angle(p, ring), half = sin(angle / 2);
    set_vertex(p, column, ring ? sin(angle) : 0, 2 * half * half, out);
}

void ring_plane_vertex(const ring_params *p, int ring, int column, float out[3])
{
    set_vertex(p, column, ring_plane_radius(ring_angle(p, ring)), 0, out);
}
