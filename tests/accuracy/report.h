// What every accuracy program shares: worst values, and bars that are printed and counted.
#ifndef PERIGEE_TESTS_REPORT_H
#define PERIGEE_TESTS_REPORT_H

#include <math.h>
#include <stdio.h>

// The larger; NaN wins, so that a broken result never looks like an exact one.
static inline double worse(double worst, double error)
{
    return isnan(worst) || error <= worst ? worst : error;
}

// Prints one line and returns 1 where the bar is broken, else 0.
static inline int bar_at_most(const char *what, double value, double bound)
{
    int broken = !(value <= bound);
    printf("- %s: %.3g, bar <= %g%s\n", what, value, bound, broken ? " **BROKEN**" : "");
    return broken;
}

static inline int bar_at_least(const char *what, double value, double bound)
{
    int broken = !(value >= bound);
    printf("- %s: %.3g, bar >= %g%s\n", what, value, bound, broken ? " **BROKEN**" : "");
    return broken;
}

#endif
