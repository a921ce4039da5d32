#include "reference/flicker.h"

#include <math.h>

#include "reference/compare_stat.h"

static bool is_plain(const flicker_moment *m, size_t at)
{
    return !m->kind || m->kind[at] == COMPARE_GROUND;
}

static double error_at(const flicker_moment *m, size_t at)
{
    return m->geometric_px ? (double)m->geometric_px[at] : 0;
}

static double encoded(const float *plane, size_t at)
{
    return plane ? 255 * compare_encoded((double)plane[at]) : 0;
}

static double color_change(const flicker_moment *before, const flicker_moment *after, size_t at)
{
    const float *const a1[3] = {before->r, before->g, before->b};
    const float *const a2[3] = {after->r, after->g, after->b};
    const float *const b1[3] = {before->true_r, before->true_g, before->true_b};
    const float *const b2[3] = {after->true_r, after->true_g, after->true_b};
    double change = 0;
    for (int i = 0; i < 3; i++) {
        if (!a1[i] || !a2[i]) return NAN;
        double own = encoded(a2[i], at) - encoded(a1[i], at);
        change = fmax(change, fabs(own - (encoded(b2[i], at) - encoded(b1[i], at))));
    }
    return change;
}

status flicker_measure(const flicker_moment *before, const flicker_moment *after, int width,
                       int height, flicker_result *out)
{
    struct stat_sum moved = {0}, color = {0};
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            size_t at = (size_t)y * (size_t)width + (size_t)x;
            double change = error_at(after, at) - error_at(before, at);
            if (!is_plain(before, at) || !is_plain(after, at) || isnan(change)) continue;
            stat_add(&moved, change, x, y);
            stat_add(&color, color_change(before, after, at), x, y);
        }
    status s = stat_finish(&moved, &out->moved_px);
    status of_color = stat_finish(&color, &out->color);
    return s ? s : of_color;
}
