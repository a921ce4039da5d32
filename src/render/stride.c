#include "render/stride.h"

#include <math.h>

// By so much a chord may be seen to stand below its arc, px. At 0.02 six pixels of the limb in a
// picture of 320 x 240 changed sides when a planet was turned (tests/render/test_rotation.c, now
// two); at 0.015 a planet in space takes 0.41 visible triangles a pixel, and 0.4 is allowed.
#define SAG_PX 0.0165

// From the camera to ground `reach` metres from the focus. Under the camera the height above the
// ground counts; around a focus aside, of the band's ground what is nearest and still seen.
static double distance_to(const gaze *g, double reach)
{
    if (!g->aside) return hypot(reach, g->distance);
    return fmax(fabs(g->distance - reach), g->nearest);
}

// How much of what is vertical shows on level ground at an angle from the focus: the sine between
// the line of sight and the vertical; 1 at the limb and beyond.
static double upright(const ring_sight *s, double angle, double distance)
{
    if (s->gaze.aside) return 1;
    double above = (s->radius + s->altitude) * cos(angle) - s->radius;
    double steep = fmin(fmax(above, 0) / distance, 1);
    return sqrt(1 - steep * steep);
}

// Whether vertices may stand so far apart (m) at an angle from the focus.
static bool keeps(const ring_sight *s, double length, double angle)
{
    double distance = distance_to(&s->gaze, angle * s->radius), pixel = distance * s->pixel;
    double sag = length * length / (8 * s->radius) * upright(s, angle, distance);
    return length <= s->spacing_px * pixel && sag <= SAG_PX * pixel;
}

int ring_stride(const ring_params *rings, const ring_sight *sight, int level, int band)
{
    int count = rings->rings_per_level / CELL_BANDS, stride = 1;
    int outer = level * rings->rings_per_level + band * count;
    double angle = ring_angle(rings, outer);
    double gap = (angle - ring_angle(rings, outer + 1)) * sight->radius;
    while (stride < STRIDE_MAX && count % (2 * stride) == 0 &&
           keeps(sight, 2 * stride * gap, angle))
        stride *= 2;
    return stride;
}

int column_stride(const ring_params *rings, const ring_sight *sight, int first, int last)
{
    int count = rings->azimuth_steps / CELL_SECTORS, stride = 1;
    double step = 2 * M_PI / rings->azimuth_steps * sight->radius;
    bool kept = true;
    while (kept && stride < STRIDE_MAX && count % (2 * stride) == 0) {
        for (int i = first * CELL_BANDS; kept && i < (last + 1) * CELL_BANDS; i++) {
            double angle = ring_angle(rings, (double)i * rings->rings_per_level / CELL_BANDS);
            kept = keeps(sight, 2 * stride * step * sin(fmin(angle, M_PI / 2)), angle);
        }
        if (kept) stride *= 2;
    }
    return stride;
}
