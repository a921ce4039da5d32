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

// By how much vertices so far apart (m) at an angle from the focus are too far apart; they may be
// where it is at most 1.
static double excess(const ring_sight *s, double length, double angle)
{
    if (!(s->spacing_px > 0)) return INFINITY;
    double distance = distance_to(&s->gaze, angle * s->radius), pixel = distance * s->pixel;
    double sag = length * length / (8 * s->radius) * upright(s, angle, distance);
    return fmax(length / (s->spacing_px * pixel), sag / (SAG_PX * pixel));
}

// What is left out next slides away over this factor of the excess.
#define SLIDES_FROM 1.2

static double slid_at(double excess)
{
    return fmax(0, fmin(1, (SLIDES_FROM - excess) / (SLIDES_FROM - 1)));
}

thinning thin_rings(const ring_params *rings, const ring_sight *sight, int level, int band)
{
    int count = rings->rings_per_level / CELL_BANDS;
    int outer = level * rings->rings_per_level + band * count;
    double angle = ring_angle(rings, outer);
    double gap = (angle - ring_angle(rings, outer + 1)) * sight->radius;
    for (thinning t = {1, 0};; t.stride *= 2) {
        if (t.stride == STRIDE_MAX || count % (2 * t.stride)) return t;
        double e = excess(sight, 2 * t.stride * gap, angle);
        t.slid = slid_at(e);
        if (e > 1) return t;
        t.slid = 0;
    }
}

// Of all bands' rings from `last` out to `reach`, the largest excess at a column's step `step`.
static double columns_excess(const ring_params *rings, const ring_sight *sight, double step,
                             double reach, int last)
{
    double most = 0;
    for (int i = (last + 1) * CELL_BANDS - 1; i >= 0; i--) {
        double ring = ring_angle(rings, (double)i * rings->rings_per_level / CELL_BANDS),
               angle = fmin(ring, reach);
        most = fmax(most, excess(sight, step * sin(fmin(angle, M_PI / 2)), angle));
        if (ring >= reach) break;
    }
    return most;
}

thinning thin_columns(const ring_params *rings, const ring_sight *sight, double reach, int last)
{
    int count = rings->azimuth_steps / CELL_SECTORS;
    double step = 2 * M_PI / rings->azimuth_steps * sight->radius;
    for (thinning t = {1, 0};; t.stride *= 2) {
        if (t.stride == STRIDE_MAX || count % (2 * t.stride)) return t;
        double e = columns_excess(rings, sight, 2 * t.stride * step, reach, last);
        t.slid = slid_at(e);
        if (e > 1) return t;
        t.slid = 0;
    }
}
