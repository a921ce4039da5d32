// shaders/lib/windows.glsl over a list of cases, by readback. Main only, with a current context.
#ifndef PERIGEE_TESTS_FETCH_KERNEL_H
#define PERIGEE_TESTS_FETCH_KERNEL_H

#include "base/status.h"
#include "render/blocks.h"

enum { FETCH_ROWS = 336, FETCH_COLUMNS = 512, FETCH_LEVELS = 3 };

// As the shader has them (std430).
struct fetch_case {
    float map[4], dlonlat[2], place[2];
    float coarser, level, unused[2];
};

struct fetch_result {
    float bilinear, trilinear, place[2];
};

// heights: FETCH_LEVELS x FETCH_ROWS x FETCH_COLUMNS texels of a texture array that repeats.
// defines: put before the shader, or NULL. ERR_GPU when the shader does not build.
status fetch_kernel_run(const float *heights, const struct levels_block *levels,
                        const char *defines, const struct fetch_case *cases,
                        struct fetch_result *results, int count);

#endif
