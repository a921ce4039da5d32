#include "render/stride.h"

#include <math.h>

// What ground of so much relief may hide between two rings seen edge on, as a share of the spacing.
#define RELIEF_SHARE 0.25

// From the camera to ground `reach` metres from the focus. Under the camera the height above the
// ground counts; around a focus aside, of the band's ground what is nearest and still seen.
static double distance_to(const gaze *g, double reach)
{
    if (!g->aside) return hypot(reach, g->distance);
    return fmax(fabs(g->distance - reach), g->nearest);
}

// Bound of the sine between the line of sight and level ground no lower than `low`.
static double steepness(const ring_sight *s, double angle, double low, double distance)
{
    if (s->gaze.aside) return 1;
    double above = (s->radius + s->altitude) * cos(angle) - (s->radius + low);
    return fmin(1, fmax(above, 0) / distance);
}

int ring_stride(const ring_params *rings, const ring_sight *sight, int level, int band, double low,
                double high)
{
    int count = rings->rings_per_level / CELL_BANDS, stride = 1;
    int outer = level * rings->rings_per_level + band * count;
    double reach = ring_angle(rings, outer) * sight->radius;
    double gap = reach - ring_angle(rings, outer + 1) * sight->radius;
    double distance = distance_to(&sight->gaze, reach), pixel = distance * sight->pixel;
    double inner = ring_angle(rings, outer + count);
    double on_edge = steepness(sight, inner, low, distance) * gap / pixel;
    double relief = (high - low) / pixel / RELIEF_SHARE;
    for (; stride < STRIDE_MAX && count % (2 * stride) == 0; stride *= 2) {
        double shown = fmin(2 * stride * gap / pixel, 2 * stride * on_edge + relief);
        if (shown > sight->spacing_px) break;
    }
    return stride;
}

int column_stride(const ring_params *rings, const ring_sight *sight, int first, int last)
{
    int count = rings->azimuth_steps / CELL_SECTORS, stride = 1;
    double widest_px = 0;
    for (int i = first * CELL_BANDS; i < (last + 1) * CELL_BANDS; i++) {
        double angle = ring_angle(rings, (double)i * rings->rings_per_level / CELL_BANDS);
        double width = 2 * M_PI / rings->azimuth_steps * sight->radius * sin(fmin(angle, M_PI / 2));
        double distance = distance_to(&sight->gaze, angle * sight->radius);
        widest_px = fmax(widest_px, width / (distance * sight->pixel));
    }
    while (stride < STRIDE_MAX && count % (2 * stride) == 0 &&
           2 * stride * widest_px <= sight->spacing_px)
        stride *= 2;
    return stride;
}
