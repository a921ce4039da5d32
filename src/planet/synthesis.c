// The noise is evaluated row by row: positions in double (zoom 24 has 2^30 cells around the globe),
// within a cell in float. Built of + - * and integers in a fixed order, so that every machine makes
// the same terrain from the same sines.
#include "planet/synthesis.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "base/vec.h"

// 1 / rms of the raw noise below, whose gradients have components uniform in [-511.5, 511.5].
#define NOISE_SCALE (1.0f / 93.4f)

// Share of the relief that each zoom far below the data adds, and the largest that the first one
// does. Measured on 200 waves of Hurst exponent 0.85: the rms slope after 14 zooms
// is 1.0, 1.7 and 2.1 times the data's with a measured gain of 0.02, 0.25 and 0.6.
#define STEADY_GAIN    0.13
#define FIRST_GAIN_MAX 0.4

// Slope (rise over run) that detail grows towards ever more slowly: debris rests at 30 to 40
// degrees.
#define TALUS_SLOPE 0.8

// No land is smoother than this at any scale: rise over run, less over more than FLOOR_SCALE_M.
#define FLOOR_SLOPE   0.03
#define FLOOR_SCALE_M 100.0

// Added to lattice coordinates, times the zoom plus one: apart in every zoom, because gradient
// noise is steeper across the planes of its lattice, and planes common to all zooms would show (the
// antimeridian is one). Fractions of the low-discrepancy sequence in three dimensions.
static const double zoom_shift[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
static const double lattice_offset = 0x1p30; // makes every lattice coordinate positive

void synthesis_columns(const region *r, double *cos_lon, double *sin_lon)
{
    int64_t circle = 2 * (int64_t)TILE_SIZE * grid_rows(r->zoom) / r->coalesce;
    double step = grid_step_lat(r->zoom) * r->coalesce;
    for (int i = 0; i < r->cols; i++) {
        int64_t col = ((r->col + i) % circle + circle) % circle;
        double lon = ((double)(col - circle / 2) + 0.5) * step;
        cos_lon[i] = cos(lon);
        sin_lon[i] = sin(lon);
    }
}

static inline uint32_t mix(uint32_t h)
{
    h ^= h >> 15;
    h *= 0x2c1b3c6du;
    h ^= h >> 13;
    h *= 0x297a2d39u;
    return h;
}

// The hashed lattice gradient times the offset from its corner.
static inline float corner(uint32_t hash, float x, float y, float z)
{
    uint32_t h = mix(hash);
    float gx = (float)(int32_t)(h >> 22) - 511.5f;
    float gy = (float)(int32_t)(h >> 12 & 1023) - 511.5f;
    float gz = (float)(int32_t)(h >> 2 & 1023) - 511.5f;
    return gx * x + gy * y + gz * z;
}

static inline float fade(float t)
{
    return t * t * (3.0f - 2.0f * t);
}

static inline float lerp(float a, float b, float t)
{
    return a + t * (b - a);
}

#define PRIME_X 0x9e3779b1u
#define PRIME_Y 0x85ebca77u
#define PRIME_Z 0xc2b2ae3du

enum { RUN = 256 };

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

// At most RUN points of one height above the equator, `pz` in cells; scale: cells to the axis.
static void noise_run(const double *cos_lon, const double *sin_lon, int count, int zoom,
                      double scale, double pz, float *out)
{
    uint32_t hx[RUN], hy[RUN];
    float fx[RUN], fy[RUN];
    split(cos_lon, count, scale, shift_of(zoom, 0), PRIME_X, hx, fx);
    split(sin_lon, count, scale, shift_of(zoom, 1), PRIME_Y, hy, fy);
    int32_t cell = (int32_t)pz;
    uint32_t hz0 = (uint32_t)cell * PRIME_Z + (uint32_t)zoom * 0x27d4eb2fu, hz1 = hz0 + PRIME_Z;
    float z = (float)(pz - cell), z1 = z - 1.0f, w = fade(z);
    for (int i = 0; i < count; i++) {
        float x = fx[i], y = fy[i], x1 = x - 1.0f, y1 = y - 1.0f, u = fade(x), v = fade(y);
        uint32_t a = hx[i], b = a + PRIME_X, c = hy[i], d = c + PRIME_Y;
        float low =
            lerp(lerp(corner((a ^ c) + hz0, x, y, z), corner((b ^ c) + hz0, x1, y, z), u),
                 lerp(corner((a ^ d) + hz0, x, y1, z), corner((b ^ d) + hz0, x1, y1, z), u), v);
        float high =
            lerp(lerp(corner((a ^ c) + hz1, x, y, z1), corner((b ^ c) + hz1, x1, y, z1), u),
                 lerp(corner((a ^ d) + hz1, x, y1, z1), corner((b ^ d) + hz1, x1, y1, z1), u), v);
        out[i] = NOISE_SCALE * lerp(low, high, w);
    }
}

void synthesis_noise(const double *cos_lon, const double *sin_lon, int count, int zoom, double lat,
                     float *out)
{
    double frequency = 0.5 / grid_step_lat(zoom), scale = cos(lat) * frequency;
    double pz = sin(lat) * frequency + shift_of(zoom, 2);
    for (int i = 0; i < count; i += RUN)
        noise_run(cos_lon + i, sin_lon + i, count - i < RUN ? count - i : RUN, zoom, scale, pz,
                  out + i);
}

// Differences between columns, squared, to differences over the latitude spacing; and what they
// weigh beside differences between rows: less where columns crowd together near a pole, and
// rounding would count as relief. `factor` has the weight in it.
static void column_weight(const region *r, int row, float *factor, float *weight)
{
    double shape = r->coalesce * fabs(cos(grid_lat(r->zoom, r->row + row)));
    *weight = (float)fmin(4.0 * shape * shape, 1.0);
    *factor = (float)fmin(1.0 / (shape * shape), 4.0);
}

static float square(float x)
{
    return x * x;
}

void synthesis_relief(const region *r, float *relief)
{
    int n = r->cols;
    float across[REGION_MAX_COLS], down[REGION_MAX_COLS];
    assert(r->channels == 1 && r->stride == n);
    memset(relief, 0, sizeof *relief * (size_t)r->rows * (size_t)n);
    for (int y = 1; y < r->rows - 1; y++) {
        const float *b = r->data + (size_t)y * (size_t)n, *a = b - n, *c = b + n;
        float fa, fb, fc, wa, wb, wc;
        column_weight(r, y - 1, &fa, &wa);
        column_weight(r, y, &fb, &wb);
        column_weight(r, y + 1, &fc, &wc);
        float inverse = 1.0f / (6.0f + 2.0f * (wa + wb + wc));
        for (int i = 0; i < n - 1; i++)
            across[i] = fa * square(a[i + 1] - a[i]) + fb * square(b[i + 1] - b[i]) +
                        fc * square(c[i + 1] - c[i]);
        for (int i = 0; i < n; i++) down[i] = square(b[i] - a[i]) + square(c[i] - b[i]);
        float *out = relief + (size_t)y * (size_t)n;
        for (int i = 1; i < n - 1; i++)
            out[i] =
                sqrtf((across[i - 1] + across[i] + down[i - 1] + down[i] + down[i + 1]) * inverse);
    }
}

void synthesis_amplitude(const region *r, double gain, int data_zoom, double radius, float *relief)
{
    int below = r->zoom + 1 - data_zoom;
    double excess = fmin(gain, FIRST_GAIN_MAX) - STEADY_GAIN;
    if (excess > 0.0) excess = below >= 1 ? ldexp(excess, 2 - 2 * below) : 0.0;
    double spacing = radius * grid_step_lat(r->zoom);
    float share = (float)(STEADY_GAIN + excess), steep = (float)(TALUS_SLOPE * spacing);
    float least = (float)(FLOOR_SLOPE * spacing / sqrt(1.0 + spacing / FLOOR_SCALE_M));
    float inverse = 1.0f / (steep * steep);
    for (int i = 0; i < r->rows * r->cols; i++) {
        float h = relief[i] > 0.0f ? sqrtf(relief[i] * relief[i] + least * least) : 0.0f;
        relief[i] = share * h / (1.0f + h * h * inverse);
    }
}
