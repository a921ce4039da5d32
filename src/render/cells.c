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

void cell_view_azimuths(cell_view *v)
{
    for (int i = 0; i < 2 * CELL_SECTORS; i++) {
        v->north[i] = cos(M_PI / CELL_SECTORS * i);
        v->east[i] = sin(M_PI / CELL_SECTORS * i);
    }
}

// By how much arcs leave the points that bound a cell, on the unit sphere; on a plane the rays
// from the focus are straight.
static double bend_of(const cell_view *v, double inner, double outer)
{
    double turn = 1 - cos(M_PI / (2 * CELL_SECTORS));
    if (geo_is_plane(v->ellipsoid)) return ring_plane_radius(outer) * turn;
    return sin(fmin(outer, M_PI / 2)) * turn + (1 - cos((outer - inner) / 4));
}

cell_band cell_band_of(const ring_params *rings, const cell_view *v, int cell, int last, double low,
                       double high)
{
    int band = cell / CELL_SECTORS;
    bool fill = band == rings->levels * CELL_BANDS, plane = geo_is_plane(v->ellipsoid);
    double per_band = (double)rings->rings_per_level / CELL_BANDS;
    double outer = ring_angle(rings, fill ? (last + 1) * rings->rings_per_level : band * per_band);
    double inner = fill ? 0 : ring_angle(rings, (band + 1) * per_band);
    double nearest = plane ? ring_plane_radius(inner) : inner;
    cell_band b = {.low = low, .high = high, .beyond = nearest > v->horizon + v->nadir_angle};
    if (b.beyond) return b;
    b.slack = bend_of(v, inner, outer) * (v->ellipsoid.a + fmax(fabs(low), fabs(high)));
    for (int i = 0; i < 3; i++) {
        double angle = inner + (outer - inner) * 0.5 * i;
        b.outward[i] = plane ? ring_plane_radius(angle) : sin(angle);
        b.down[i] = plane ? 0 : cos(angle);
    }
    return b;
}

// The ground at height 0 less the camera, and what a metre of height adds.
static dvec3 surface_point(const cell_view *v, const cell_band *b, int angle, int azimuth,
                           dvec3 *normal)
{
    double n = b->outward[angle] * v->north[azimuth], y = b->outward[angle] * v->east[azimuth];
    if (geo_is_plane(v->ellipsoid)) {
        geodetic g = {v->lat + n, v->lon + y, 0}, above = {g.lat, g.lon, 1};
        dvec3 p = geo_ecef_from_geodetic(v->ellipsoid, g);
        *normal = dvec3_sub(geo_ecef_from_geodetic(v->ellipsoid, above), p);
        return dvec3_sub(p, v->camera);
    }
    double c = b->down[angle], x = v->cb * c - v->sb * n, z = v->sb * c + v->cb * n;
    double a = v->ellipsoid.a, polar = v->ellipsoid.b;
    *normal = dvec3_normalize(dvec3_make(polar * x, polar * y, a * z));
    return dvec3_sub(dvec3_make(a * x, a * y, polar * z), v->camera);
}

bool cell_band_visible(const cell_view *v, const cell_band *b, int sector)
{
    unsigned inside = 0;
    for (int i = 0; i < 9 && !b->beyond && inside != 31; i++) {
        dvec3 normal;
        dvec3 p = surface_point(v, b, i % 3, (2 * sector + i / 3) % (2 * CELL_SECTORS), &normal);
        for (int k = 0; k < 5; k++) {
            double rise = dvec3_dot(v->plane[k], normal);
            double most = dvec3_dot(v->plane[k], p) + fmax(b->low * rise, b->high * rise);
            inside |= (unsigned)(most >= -b->slack) << k;
        }
    }
    return inside == 31;
}
