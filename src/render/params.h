// What a view is made with: defaults, qualities, bounds. Pure functions. Any thread.
#ifndef PERIGEE_RENDER_PARAMS_H
#define PERIGEE_RENDER_PARAMS_H

#include "base/status.h"
#include "perigee.h"

// Fills what is left 0, the rings and windows from `quality` or, when `error_px` is given, from the
// cheapest quality that keeps it. ERR_ARGUMENT, logged, for what cannot be.
status params_complete(perigee_view_params *params);

// Height samples across a level's ring (a power of two, 256 to 1024) that a mesh `size` times as
// fine as the default asks for.
int params_texels_for(double size);

#endif
