// What a view is made with: defaults, qualities, bounds. Pure functions. Any thread.
#ifndef PERIGEE_RENDER_PARAMS_H
#define PERIGEE_RENDER_PARAMS_H

#include "base/status.h"
#include "perigee.h"

// Fills what is left 0, the rings and windows from `quality` or, when `error_px` is given, from the
// cheapest quality that keeps it. ERR_ARGUMENT, logged, for what cannot be.
status params_complete(perigee_view_params *params);

#endif
