// What of the parent's shape decides the residual. Every field at a sample is made of the 3 x 3
// heights around it, so it is the same whatever rectangle it is made in.
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "geo/shared.h"
#include "planet/synthesis.h"

// Share of the tempered relief that each zoom far below the data adds, and the largest that the
// first one does.
#define STEADY_GAIN    0.16
#define FIRST_GAIN_MAX 0.55

// Spacing at which the steady share is halved: what water carves, soil and plants cover again.
// Lidar of 0.6 m has more (bench/RESULTS-synthesis.md); without an end, a viewer's own footing
// would bristle.
#define SMOOTH_M 0.5

// No land is smoother than this at any scale: rise over run, less over more than FLOOR_SCALE_M.
#define FLOOR_SLOPE   0.03
#define FLOOR_SCALE_M 100.0

// Rise over run beyond which steeper ground bears less detail beside its slope: measured on SRTM
// and on lidar (bench/RESULTS-synthesis.md).
#define TEMPER_SLOPE 0.15

synthesis_shape synthesis_shape_of(int zoom, int coalesce, int64_t row)
{
    double shape = coalesce * fabs(cos(grid_lat(zoom, row)));
    return (synthesis_shape){.shape = (float)shape,
                             .weight = (float)fmin(4.0 * shape * shape, 1.0),
                             .factor = (float)fmin(1.0 / (shape * shape), 4.0)};
}

static synthesis_shape shape_of(const region *r, int row)
{
    return synthesis_shape_of(r->zoom, r->coalesce, r->row + row);
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
        synthesis_shape sa = shape_of(r, y - 1), sb = shape_of(r, y), sc = shape_of(r, y + 1);
        float inverse = 1.0f / (6.0f + 2.0f * (sa.weight + sb.weight + sc.weight));
        for (int i = 0; i < n - 1; i++)
            across[i] = sa.factor * square(a[i + 1] - a[i]) + sb.factor * square(b[i + 1] - b[i]) +
                        sc.factor * square(c[i + 1] - c[i]);
        for (int i = 0; i < n; i++) down[i] = square(b[i] - a[i]) + square(c[i] - b[i]);
        float *out = relief + (size_t)y * (size_t)n;
        for (int i = 1; i < n - 1; i++)
            out[i] =
                sqrtf((across[i - 1] + across[i] + down[i - 1] + down[i] + down[i + 1]) * inverse);
    }
}

synthesis_scale synthesis_scale_of(int parent_zoom, double gain, int data_zoom, double radius)
{
    double spacing = radius * grid_step_lat(parent_zoom);
    int below = parent_zoom + 1 - data_zoom;
    double excess = fmin(gain, FIRST_GAIN_MAX) - STEADY_GAIN;
    if (excess > 0.0) excess = below >= 1 ? ldexp(excess, 2 - 2 * below) : 0.0;
    return (synthesis_scale){
        .steep = (float)(TEMPER_SLOPE * spacing),
        .least = (float)(FLOOR_SLOPE * spacing / sqrt(1.0 + spacing / FLOOR_SCALE_M)),
        .share = (float)(STEADY_GAIN * spacing / (spacing + SMOOTH_M) + fmax(excess, 0.0))};
}

void synthesis_temper(const region *r, double radius, float *relief)
{
    synthesis_scale scale = synthesis_scale_of(r->zoom, 0.0, 0, radius);
    for (int i = 0; i < r->rows * r->cols; i++)
        relief[i] = synthesis_tempered_f(relief[i], scale.steep, scale.least);
}

// Bend and wave vectors; in `ground->amplitude` is the relief.
static void shape_fields(const region *r, float least, synthesis_ground *ground)
{
    int n = r->cols;
    for (int y = 1; y < r->rows - 1; y++) {
        const float *b = r->data + (size_t)y * (size_t)n, *a = b - n, *c = b + n;
        size_t line = (size_t)y * (size_t)n;
        const float *relief = ground->amplitude + line;
        float *bend = ground->bend + line, *east = ground->east + line,
              *north = ground->north + line;
        synthesis_shape shape = shape_of(r, y);
        float slope = 0.5f / (shape.shape > 0.5f ? shape.shape : 0.5f);
        for (int i = 1; i < n - 1; i++) {
            float up = 0.5f * (a[i] - c[i]), right = slope * (b[i + 1] - b[i - 1]);
            float k = stripe_number_f(up, right, relief[i], least);
            east[i] = -k * up;
            north[i] = k * right;
            bend[i] = 0.25f * ((a[i] - b[i]) + (c[i] - b[i]) +
                               shape.weight * ((b[i - 1] - b[i]) + (b[i + 1] - b[i])));
        }
    }
}

status synthesis_ground_create(const region *parent, enum synthesis kind, double gain,
                               int data_zoom, double radius, synthesis_ground *out)
{
    size_t samples = (size_t)parent->rows * (size_t)parent->cols;
    bool eroded = kind == SYNTHESIS_ERODED;
    synthesis_scale scale = synthesis_scale_of(parent->zoom, gain, data_zoom, radius);
    *out = (synthesis_ground){.amplitude = malloc((eroded ? 4 : 1) * samples * sizeof(float))};
    if (!out->amplitude) return ERR_MEMORY;
    synthesis_relief(parent, out->amplitude);
    if (eroded) {
        out->bend = out->amplitude + samples;
        out->east = out->bend + samples;
        out->north = out->east + samples;
        memset(out->bend, 0, 3 * samples * sizeof(float));
        shape_fields(parent, scale.least, out);
    }
    for (size_t i = 0; i < samples; i++)
        out->amplitude[i] =
            scale.share * synthesis_tempered_f(out->amplitude[i], scale.steep, scale.least);
    return OK;
}

void synthesis_ground_destroy(synthesis_ground *ground)
{
    free(ground->amplitude);
    *ground = (synthesis_ground){0};
}
