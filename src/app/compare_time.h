// How long the frames of modes take beside one another. Main only.
#ifndef PERIGEE_APP_COMPARE_TIME_H
#define PERIGEE_APP_COMPARE_TIME_H

#include "app/compare_side.h"

// GPU time (timestamps from before the first vertex is placed to after the shading) of a frame of a
// camera that turns by a tenth of a degree a frame: the median of `repeats` frames, over that of
// the first side. The sides take turns, so that what else the machine does falls on all. NaN where
// the driver tells no time. ERR_TIMEOUT, ERR_CANCELLED.
status compare_time(const struct compare_side *sides, int count, const struct compare_stage *stage,
                    const perigee_camera *camera, int repeats, double *ratios);

#endif
