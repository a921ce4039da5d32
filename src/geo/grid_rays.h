// shaders/shared/grid_rays.glsl in C. Inside the room, and for tests.
//
// Pure functions. Any thread.
#ifndef PERIGEE_GEO_GRID_RAYS_H
#define PERIGEE_GEO_GRID_RAYS_H

#include <math.h>

#include "geo/screen_grid.h"

#define GRID_SHARED  static inline
#define GRID_OUT(t)  t *
#define GRID_SET(n)  (*(n))
#define GRID_PARAM   const struct grid_block *grid,
#define GRID_PASS    grid,
#define GRID(member) grid->member
#define double_of(x) ((double)(x))
#define int_of(x)    ((int)(x))

typedef struct grid_direction grid_direction;

#include "shared/grid_rays.glsl"

#undef GRID_SHARED
#undef GRID_OUT
#undef GRID_SET
#undef GRID_PARAM
#undef GRID_PASS
#undef GRID
#undef double_of
#undef int_of

#endif
