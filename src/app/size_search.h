// Looks for the size at which a measure of it has a wanted value: of a mesh, say, whose triangles
// grow and whose error falls with it, by steps and not quite steadily. Sizes and values are
// positive and looked at by their logarithms: secants inside the bracket that is known, else
// bounded steps towards it. Main only.
#ifndef PERIGEE_APP_SIZE_SEARCH_H
#define PERIGEE_APP_SIZE_SEARCH_H

#include <stdbool.h>

#include "base/status.h"

typedef struct size_search_params {
    double low, high; // sizes looked at, with 1, the first one, in between
    double goal;      // of the measure
    double tolerance; // share of the goal that it may be off
    double exponent;  // the measure goes roughly like size^exponent; its sign must be right
    int tries;        // measurements at most
    // The measure of a size; NaN when it has none there. Its failure ends the search.
    status (*measure)(void *user, double size, double *value);
    void *user;
} size_search_params;

// The nearest of what was measured; value NaN: nothing could be.
typedef struct size_search_result {
    double size, value;
    bool met; // within the tolerance
    int tries;
} size_search_result;

status size_search(const size_search_params *params, size_search_result *out);

#endif
