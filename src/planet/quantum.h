// The step in which heights are stored. Pure. Any thread.
#ifndef PERIGEE_PLANET_QUANTUM_H
#define PERIGEE_PLANET_QUANTUM_H

#include <stdbool.h>

#include "planet/grid.h"

// A quantum for each zoom: the greatest power of two up to 1/2048 of the distance of its samples in
// latitude, from 1/64 m to 1 m. So a height is off by at most 1/4096 of that distance, or 1/128 m,
// and by at most 0.5 m. 1/64 m in the tiles at a pole, where samples come closer and closer along
// their rows, so that a step between two of them would be a cliff, and those beside the pole fans.
#define QUANTUM_AUTO (-1.0)

// 0 (as they are), QUANTUM_AUTO, or what codec_grid.h can hold.
bool quantum_is_good(double quantum);

// Of the power of two; not for 0. quantum > 0: the greatest up to it, at every zoom. radius:
// equatorial, in metres.
int quantum_exponent(double quantum, int zoom, double radius);
int quantum_tile_exponent(double quantum, tile_id id, double radius);

#endif
