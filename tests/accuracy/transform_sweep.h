// Ring vertices around viewers from the equator to the pole, through the shared functions in float
// on the CPU and on the GPU, against long double. Main only, with a current context.
#ifndef PERIGEE_TESTS_TRANSFORM_SWEEP_H
#define PERIGEE_TESTS_TRANSFORM_SWEEP_H

#include <stdbool.h>

#include "base/status.h"

enum { FIRST_LEVEL = 1, LAST_LEVEL = 23, MAX_COLATITUDES = 40, DISTANCE_BINS = 5 };

enum transform { STABLE, EXACT, APPROX, BLEND, TRANSFORMS };
enum device { CPU, GPU, DEVICES };

// Worst errors of map coordinates: texels of the level's window of 256 rows x 512 columns,
// longitude on the ground in rows, metres on the ground. Within POLE_ROWS rows of a pole, where a
// column is a sliver of a row, longitude in columns stands apart.
struct map_error {
    double lon_texel, lon_texel_at_pole, lon_rows, lat_texel, metres;
};

#define POLE_ROWS 8

// Worst errors of a position by the vertex's distance from the camera: up to 1, 10, 100, 1000 km,
// and beyond.
struct position_error {
    double metres[DISTANCE_BINS], relative[DISTANCE_BINS];
};

enum eye { OVER_FOCUS, BESIDE_FOCUS, EYES };

struct transform_sweep {
    int colatitudes;                    // of the viewer, reduced, each north and south
    double colatitude[MAX_COLATITUDES]; // rad, 0 is the pole; falling
    long vertices;
    struct map_error map[TRANSFORMS][DEVICES][MAX_COLATITUDES][LAST_LEVEL + 1];
    struct map_error pixel[LAST_LEVEL + 1]; // stable, v made from n and e as shade/ground.glsl does
    struct position_error position[EYES][DEVICES];
    // The same against the place that the vertex's floats name: without their rounding, which moves
    // vertex and map coordinate together.
    struct position_error stored[EYES][DEVICES];
};

// dense: every ring and 20 more latitudes, drawn with a fixed seed. ERR_GPU, ERR_MEMORY.
status transform_sweep_run(bool dense, struct transform_sweep *out);

#endif
