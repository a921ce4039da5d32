// Gathers values and says what their distribution is. One thread.
#ifndef PERIGEE_REFERENCE_COMPARE_STAT_H
#define PERIGEE_REFERENCE_COMPARE_STAT_H

#include <stdbool.h>

#include "reference/compare.h"

struct stat_sum {
    float *values;
    size_t count, room;
    double sum, squares, max;
    int x, y;
    bool failed; // memory was refused; nothing more is gathered
};

// Counts |value| of pixel x, y. A NaN is left out.
void stat_add(struct stat_sum *s, double value, int x, int y);

// The distribution, and the memory freed. ERR_MEMORY, logged, when it was refused.
status stat_finish(struct stat_sum *s, compare_stat *out);

#endif
