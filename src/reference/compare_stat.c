#include "reference/compare_stat.h"

#include <math.h>
#include <stdlib.h>

#include "base/log.h"

enum { FIRST_ROOM = 4096 };

static bool grow(struct stat_sum *s)
{
    size_t room = s->room ? 2 * s->room : FIRST_ROOM;
    float *values = realloc(s->values, room * sizeof *values);
    if (!values) {
        s->failed = true;
        return false;
    }
    s->values = values;
    s->room = room;
    return true;
}

void stat_add(struct stat_sum *s, double value, int x, int y)
{
    value = fabs(value);
    if (isnan(value) || s->failed || (s->count == s->room && !grow(s))) return;
    if (s->count == 0 || value > s->max) {
        s->max = value;
        s->x = x;
        s->y = y;
    }
    s->values[s->count++] = (float)value;
    s->sum += value;
    s->squares += value * value;
}

static int compare_floats(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

static double ranked(const struct stat_sum *s, double share)
{
    double rank = ceil(share * (double)s->count);
    return (double)s->values[rank < 1 ? 0 : (size_t)rank - 1];
}

status stat_finish(struct stat_sum *s, compare_stat *out)
{
    *out = (compare_stat){0, NAN, NAN, NAN, NAN, NAN, -1, -1, NAN, NAN};
    status result = s->failed ? ERR_MEMORY : OK;
    if (s->failed) log_error("compare: out of memory for the statistics of %zu values", s->room);
    else if (s->count > 0) {
        double count = (double)s->count;
        qsort(s->values, s->count, sizeof *s->values, compare_floats);
        *out = (compare_stat){.count = s->count,
                              .mean = s->sum / count,
                              .rms = sqrt(s->squares / count),
                              .median = ranked(s, 0.5),
                              .rank_999 = ranked(s, 0.999),
                              .max = s->max,
                              .x = s->x,
                              .y = s->y,
                              .lat_deg = NAN,
                              .lon_deg = NAN};
    }
    free(s->values);
    *s = (struct stat_sum){0};
    return result;
}
