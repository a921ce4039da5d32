// A cell is bounded by 3 x 3 x 2 points (angles, azimuths, heights) and the sagitta of the arcs
// between them.
#include "render/cells.h"

#include <math.h>

#include "base/vec.h"

int cell_count(const ring_params *rings)
{
    return (rings->levels * CELL_BANDS + 1) * CELL_SECTORS;
}

int cell_index(int level, int band, int sector)
{
    return (level * CELL_BANDS + band) * CELL_SECTORS + sector;
}

int cell_fill_index(const ring_params *rings, int sector)
{
    return cell_index(rings->levels, 0, sector);
}

int cell_level(int cell)
{
    return cell / (CELL_BANDS * CELL_SECTORS);
}

int cell_sector(int cell)
{
    return cell % CELL_SECTORS;
}

cell_span cell_vertices(const ring_params *rings, int cell)
{
    int sector = cell % CELL_SECTORS, band = cell / CELL_SECTORS;
    int width = rings->azimuth_steps / CELL_SECTORS;
    int copy =
        sector >=
        CELL_SECTORS / 2; // the second half of the disc has its own copies of the meridian columns
    cell_span s = {.column = (uint32_t)(sector * width + copy), .columns = (uint32_t)width + 1};
    if (band == rings->levels * CELL_BANDS) {
        s.row = (uint32_t)ring_count(rings);
        s.rows = CELL_FILL_RINGS + 1;
    } else {
        int half = rings->rings_per_level / CELL_BANDS;
        s.row = (uint32_t)(band * half);
        s.rows = (uint32_t)half + 1;
    }
    return s;
}

static dvec3 surface_point(const cell_view *v, double angle, double azimuth, double height)
{
    if (geo_is_plane(v->ellipsoid)) {
        double r = ring_plane_radius(angle);
        geodetic g = {v->lat + r * cos(azimuth), v->lon + r * sin(azimuth), height};
        return dvec3_sub(geo_ecef_from_geodetic(v->ellipsoid, g), v->camera);
    }
    double n = sin(angle) * cos(azimuth), y = sin(angle) * sin(azimuth), c = cos(angle);
    double x = v->cb * c - v->sb * n, z = v->sb * c + v->cb * n;
    dvec3 p = {v->ellipsoid.a * x, v->ellipsoid.a * y, v->ellipsoid.b * z};
    dvec3 normal =
        dvec3_normalize(dvec3_make(x / v->ellipsoid.a, y / v->ellipsoid.a, z / v->ellipsoid.b));
    return dvec3_sub(dvec3_mad(p, normal, height), v->camera);
}

// By how much arcs leave the points that bound a cell, on the unit sphere; on a plane the rays
// from the focus are straight.
static double bend_of(const cell_view *v, double inner, double outer)
{
    double turn = 1 - cos(M_PI / (2 * CELL_SECTORS));
    if (geo_is_plane(v->ellipsoid)) return ring_plane_radius(outer) * turn;
    return sin(fmin(outer, M_PI / 2)) * turn + (1 - cos((outer - inner) / 4));
}

bool cell_visible(const ring_params *rings, const cell_view *v, int cell, int last, double low,
                  double high)
{
    int sector = cell % CELL_SECTORS, band = cell / CELL_SECTORS;
    bool fill = band == rings->levels * CELL_BANDS;
    double per_band = (double)rings->rings_per_level / CELL_BANDS;
    double outer = ring_angle(rings, fill ? (last + 1) * rings->rings_per_level : band * per_band);
    double inner = fill ? 0 : ring_angle(rings, (band + 1) * per_band);
    double nearest = geo_is_plane(v->ellipsoid) ? ring_plane_radius(inner) : inner;
    if (nearest > v->horizon + v->nadir_angle) return false;

    double width = 2 * M_PI / CELL_SECTORS, first = sector * width;
    double slack = bend_of(v, inner, outer) * (v->ellipsoid.a + fmax(fabs(low), fabs(high)));
    bool inside[5] = {false};
    for (int i = 0; i < 18; i++) {
        double angle = inner + (outer - inner) * 0.5 * (i % 3),
               azimuth = first + width * 0.5 * (i / 3 % 3);
        dvec3 p = surface_point(v, angle, azimuth, i < 9 ? low : high);
        for (int k = 0; k < 5; k++)
            if (dvec3_dot(v->plane[k], p) >= -slack) inside[k] = true;
    }
    return inside[0] && inside[1] && inside[2] && inside[3] && inside[4];
}
