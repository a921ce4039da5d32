#include "reference/patch.h"

#include <math.h>

bool field_box_holds(const field_box *o, const field_box *i)
{
    return i->south >= o->south && i->north <= o->north && i->west >= o->west && i->east <= o->east;
}

// Powers of t from samples at t = 0, 1; or at -1, 0, 1, 2, of the curve between 0 and 1.
static void curve_of(int order, const double s[PATCH_MAX], double c[PATCH_MAX])
{
    if (order == PATCH_LINEAR) {
        c[0] = s[0];
        c[1] = s[1] - s[0];
        return;
    }
    c[0] = s[1];
    c[1] = 0.5 * (s[2] - s[0]);
    c[2] = s[0] - 2.5 * s[1] + 2 * s[2] - 0.5 * s[3];
    c[3] = 0.5 * (s[3] - s[0]) + 1.5 * (s[1] - s[2]);
}

// The same curve by v, where t = first + scale v. c has zeros from `order` on.
static void stretch(double first, double scale, double c[PATCH_MAX])
{
    double slope = c[1] + first * (2 * c[2] + first * 3 * c[3]), bend = c[2] + 3 * first * c[3];
    c[0] += first * (c[1] + first * (c[2] + first * c[3]));
    c[1] = scale * slope;
    c[2] = scale * scale * bend;
    c[3] *= scale * scale * scale;
}

field_patch patch_make(const field_box *box, int order, const patch_row *rows)
{
    field_patch p = {.box = *box, .order = order};
    double row[PATCH_MAX][PATCH_MAX] = {{0}}; // [power of v][row]
    for (int i = 0; i < order; i++) {
        double c[PATCH_MAX] = {0}, start = rows[i].lon + (order / 2 - 1) * rows[i].step;
        curve_of(order, rows[i].sample, c);
        stretch((box->west - start) / rows[i].step, (box->east - box->west) / rows[i].step, c);
        for (int j = 0; j < order; j++) row[j][i] = c[j];
    }
    for (int j = 0; j < order; j++) {
        double c[PATCH_MAX] = {0};
        curve_of(order, row[j], c);
        for (int i = 0; i < order; i++) p.c[i][j] = c[i];
    }
    return p;
}

static void place_in(const field_patch *p, double lat, double lon, double *u, double *v)
{
    *u = (p->box.north - lat) / (p->box.north - p->box.south);
    *v = (lon - p->box.west) / (p->box.east - p->box.west);
}

static double value(int order, const double c[PATCH_MAX], double t)
{
    double sum = c[order - 1];
    for (int i = order - 2; i >= 0; i--) sum = sum * t + c[i];
    return sum;
}

static double slope(int order, const double c[PATCH_MAX], double t)
{
    double sum = (order - 1) * c[order - 1];
    for (int i = order - 2; i >= 1; i--) sum = sum * t + i * c[i];
    return sum;
}

double patch_height(const field_patch *p, double lat, double lon)
{
    double u, v, rows[PATCH_MAX] = {0};
    place_in(p, lat, lon, &u, &v);
    for (int i = 0; i < p->order; i++) rows[i] = value(p->order, p->c[i], v);
    return value(p->order, rows, u);
}

void patch_gradient(const field_patch *p, double lat, double lon, double *per_lat, double *per_lon)
{
    double u, v, rows[PATCH_MAX] = {0}, slopes[PATCH_MAX] = {0};
    place_in(p, lat, lon, &u, &v);
    for (int i = 0; i < p->order; i++) {
        rows[i] = value(p->order, p->c[i], v);
        slopes[i] = slope(p->order, p->c[i], v);
    }
    *per_lat = -slope(p->order, rows, u) / (p->box.north - p->box.south);
    *per_lon = value(p->order, slopes, u) / (p->box.east - p->box.west);
}

// The control values of a cubic between 0 and 1: the curve lies between the least and the greatest.
static void control(double c0, double c1, double c2, double c3, double b[4])
{
    b[0] = c0;
    b[1] = c0 + c1 / 3;
    b[2] = c0 + (2 * c1 + c2) / 3;
    b[3] = c0 + c1 + c2 + c3;
}

// Not less than the magnitude anywhere in the patch.
static double magnitude(double c[PATCH_MAX][PATCH_MAX])
{
    double row[4][4], b[4], most = 0;
    for (int i = 0; i < 4; i++) control(c[i][0], c[i][1], c[i][2], c[i][3], row[i]);
    for (int j = 0; j < 4; j++) {
        control(row[0][j], row[1][j], row[2][j], row[3][j], b);
        for (int i = 0; i < 4; i++) most = fmax(most, fabs(b[i]));
    }
    return most;
}

// Of the derivative, `down` times by u and `across` times by v.
static double derivative(const field_patch *p, int down, int across)
{
    static const double factor[3][4] = {{1, 1, 1, 1}, {0, 1, 2, 3}, {0, 0, 2, 6}};
    double c[PATCH_MAX][PATCH_MAX] = {{0}};
    for (int i = down; i < p->order; i++)
        for (int j = across; j < p->order; j++)
            c[i - down][j - across] = factor[down][i] * factor[across][j] * p->c[i][j];
    return magnitude(c);
}

patch_bounds patch_bound(const field_patch *p)
{
    double lat = p->box.north - p->box.south, lon = p->box.east - p->box.west;
    patch_bounds b = {.lat = derivative(p, 1, 0) / lat,
                      .lon = derivative(p, 0, 1) / lon,
                      .lat_lon = derivative(p, 1, 1) / (lat * lon)};
    if (p->order > PATCH_LINEAR) {
        b.lat_lat = derivative(p, 2, 0) / (lat * lat);
        b.lon_lon = derivative(p, 0, 2) / (lon * lon);
    }
    return b;
}

double patch_max(const field_patch *p, const patch_bounds *bounds, const field_box *part)
{
    double west = fmax(patch_height(p, part->north, part->west),
                       patch_height(p, part->south, part->west)),
           east = fmax(patch_height(p, part->north, part->east),
                       patch_height(p, part->south, part->east));
    double lat = part->north - part->south, lon = part->east - part->west;
    return fmax(west, east) + 0.125 * (bounds->lat_lat * lat * lat + bounds->lon_lon * lon * lon);
}

double patch_overshoot(int order)
{
    return order == PATCH_LINEAR ? 0 : 9.0 / 32;
}
