#include "app/compare_time.h"

#include <math.h>
#include <stdlib.h>

#include "app/interrupt.h"
#include "base/memory.h"

enum { WARM_UP = 4 }; // frames until the timer tells those of this camera

#define TURN_DEG 0.1

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values, int count)
{
    qsort(values, (size_t)count, sizeof *values, ascending);
    return 0.5 * (values[count / 2] + values[(count - 1) / 2]);
}

status compare_time(const struct compare_side *sides, int count, const struct compare_stage *stage,
                    const perigee_camera *camera, int repeats, double *ratios)
{
    double *ms = NEW_ARRAY(double, (size_t)count *(size_t)repeats);
    status s = OK;
    for (int i = -WARM_UP; i < repeats && !s; i++) {
        perigee_camera turned = *camera;
        turned.heading_deg += TURN_DEG * (i + WARM_UP + 1);
        if (interrupt_requested()) s = ERR_CANCELLED;
        for (int k = 0; k < count && !s; k++) {
            perigee_stats stats;
            s = compare_side_frame(&sides[k], stage, &turned);
            perigee_view_get_stats(sides[k].view, &stats);
            if (i >= 0) ms[k * repeats + i] = stats.gpu_ms < 0 ? (double)NAN : stats.gpu_ms;
        }
    }
    for (int k = 0; k < count && !s; k++) ratios[k] = median(ms + k * repeats, repeats);
    for (int k = count - 1; k >= 0 && !s; k--) ratios[k] /= ratios[0];
    free(ms);
    return s;
}
