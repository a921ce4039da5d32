// The noise is evaluated row by row: positions in double (zoom 24 has 2^30 cells around the globe),
// within a cell in float. Built of + - * /, square roots and integers in a fixed order, so that
// every machine makes the same terrain from the same sines.
#include "planet/synthesis.h"

#include <math.h>

#include "geo/shared.h"
#include "planet/upsample.h"

// Added to lattice coordinates, times the zoom plus one: apart in every zoom, because noise is
// steeper across the planes of its lattice, and planes common to all zooms would show (the
// antimeridian is one). Fractions of the low-discrepancy sequence in three dimensions.
static const double zoom_shift[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
static const double lattice_offset = 0x1p30; // makes every lattice coordinate positive

static const uint32_t prime_x = 0x9e3779b1u, prime_y = 0x85ebca77u, prime_z = 0xc2b2ae3du;

void synthesis_columns_of(const region *r, synthesis_columns *out)
{
    int64_t circle = 2 * (int64_t)TILE_SIZE * grid_rows(r->zoom) / r->coalesce;
    double step = grid_step_lat(r->zoom) * r->coalesce;
    for (int i = 0; i < r->cols; i++) {
        int64_t col = ((r->col + i) % circle + circle) % circle;
        double lon = ((double)(col - circle / 2) + 0.5) * step;
        out->cos_lon[i] = cos(lon);
        out->sin_lon[i] = sin(lon);
    }
}

// Sides of a cell, in sample spacings.
static const double noise_cell = 2.0, stripe_cell = 4.0;

enum { RUN = 256 };

// At most RUN points of one latitude, as cells of the lattice and places in them.
struct run {
    uint32_t hx[RUN], hy[RUN];
    float x[RUN], y[RUN];
};

// Splits positions in cells into the lattice point's hash and the offset from it.
static void split(const double *direction, int count, double scale, double shift, uint32_t prime,
                  uint32_t *hash, float *offset)
{
    for (int i = 0; i < count; i++) {
        double p = direction[i] * scale + shift;
        int32_t cell = (int32_t)p;
        hash[i] = (uint32_t)cell * prime;
        offset[i] = (float)(p - cell);
    }
}

// Where the lattice's coordinate of an axis is 0, in cells.
static double shift_of(int zoom, int axis)
{
    return lattice_offset + (zoom + 1) * zoom_shift[axis];
}

synthesis_lattice synthesis_lattice_of(enum synthesis kind, int zoom, double lat)
{
    double cell = kind == SYNTHESIS_ERODED ? stripe_cell : noise_cell;
    double frequency = 1.0 / (cell * grid_step_lat(zoom));
    double z = sin(lat) * frequency + shift_of(zoom, 2);
    int32_t whole = (int32_t)z;
    return (synthesis_lattice){.scale = cos(lat) * frequency,
                               .shift = {shift_of(zoom, 0), shift_of(zoom, 1)},
                               .hz = (uint32_t)whole * prime_z + (uint32_t)zoom * 0x27d4eb2fu,
                               .z = (float)(z - whole)};
}

static void split_run(const synthesis_columns *columns, int first, int count,
                      const synthesis_lattice *l, struct run *out)
{
    split(columns->cos_lon + first, count, l->scale, l->shift[0], prime_x, out->hx, out->x);
    split(columns->sin_lon + first, count, l->scale, l->shift[1], prime_y, out->hy, out->y);
}

void synthesis_noise(const synthesis_columns *columns, int count, int zoom, double lat, float *out)
{
    struct run r;
    synthesis_lattice l = synthesis_lattice_of(SYNTHESIS_PLAIN, zoom, lat);
    for (int first = 0; first < count; first += RUN) {
        int run = count - first < RUN ? count - first : RUN;
        split_run(columns, first, run, &l, &r);
        for (int i = 0; i < run; i++)
            out[first + i] = gradient_noise_f(r.hx[i], r.hy[i], l.hz, r.x[i], r.y[i], l.z);
    }
}

void synthesis_stripes(const synthesis_columns *columns, int count, int zoom, double lat,
                       const float *east, const float *north, float *out)
{
    struct run r;
    synthesis_lattice l = synthesis_lattice_of(SYNTHESIS_ERODED, zoom, lat);
    float kx[RUN], ky[RUN], kz[RUN], sin_lat = (float)sin(lat), cos_lat = (float)cos(lat);
    for (int first = 0; first < count; first += RUN) {
        int run = count - first < RUN ? count - first : RUN;
        split_run(columns, first, run, &l, &r);
        for (int i = 0; i < run; i++) {
            float c = (float)columns->cos_lon[first + i], s = (float)columns->sin_lon[first + i];
            float e = east[first + i], n = north[first + i], inward = n * sin_lat;
            kx[i] = -e * s - inward * c;
            ky[i] = e * c - inward * s;
            kz[i] = n * cos_lat;
        }
        for (int i = 0; i < run; i++)
            out[first + i] =
                stripe_noise_f(r.hx[i], r.hy[i], l.hz, r.x[i], r.y[i], l.z, kx[i], ky[i], kz[i]);
    }
}

static void add_plain(const float *amplitude, const synthesis_columns *columns, const region *child,
                      int row, float *change)
{
    synthesis_noise(columns, child->cols, child->zoom, grid_lat(child->zoom, child->row + row),
                    change);
    for (int i = 0; i < child->cols; i++) change[i] *= amplitude[i];
}

static void add_eroded(const synthesis_ground *ground, const float *amplitude,
                       const synthesis_columns *columns, const region *parent, const region *child,
                       int row, float *change)
{
    float east[REGION_MAX_COLS], north[REGION_MAX_COLS];
    upsample_linear_row(parent, ground->east, child, row, east);
    upsample_linear_row(parent, ground->north, child, row, north);
    synthesis_stripes(columns, child->cols, child->zoom, grid_lat(child->zoom, child->row + row),
                      east, north, change);
    upsample_linear_row(parent, ground->bend, child, row, east);
    for (int i = 0; i < child->cols; i++)
        change[i] = synthesis_eroded_f(east[i], amplitude[i], change[i]);
}

void synthesis_add_row(const synthesis_ground *ground, const synthesis_columns *columns,
                       const region *parent, const region *child, int row, const bool *flat,
                       const float *share, float *out)
{
    float amplitude[REGION_MAX_COLS], change[REGION_MAX_COLS], base[REGION_MAX_COLS];
    bool any = false;
    upsample_linear_row(parent, ground->amplitude, child, row, amplitude);
    for (int i = 0; i < child->cols; i++) {
        if (share) amplitude[i] *= share[i];
        amplitude[i] = flat[i] || !(amplitude[i] > 0.0f) ? 0.0f : amplitude[i];
        any |= amplitude[i] > 0.0f;
    }
    if (!any) return;
    if (ground->bend) add_eroded(ground, amplitude, columns, parent, child, row, change);
    else add_plain(amplitude, columns, child, row, change);
    upsample_least_row(parent, child, row, base);
    for (int i = 0; i < child->cols; i++) {
        float limited = synthesis_limited_f(out[i], base[i], change[i]);
        out[i] = amplitude[i] > 0.0f ? limited : out[i];
    }
}
