// Terrain heights for the camera without waiting for the disk where that can be helped: a worker
// looks up the place the camera is over, and until it answers a neighbouring answer does for a
// camera far enough above it. Main only.
#ifndef PERIGEE_APP_WINDOW_GROUND_H
#define PERIGEE_APP_WINDOW_GROUND_H

#include <stdbool.h>

#include "perigee.h"

struct window_ground;

// planet is borrowed.
struct window_ground *window_ground_create(perigee_planet *planet);
void window_ground_destroy(struct window_ground **ground); // waits for the worker

// Terrain height at a place (rad), for one who is `room` metres above what was last known there:
// exact when the terrain could be met, from near by when it cannot, 0 from orbit. With infinite
// room never waits; NaN while nothing is known.
double window_ground_at(struct window_ground *ground, double lat, double lon, double room);

// true once after the worker has answered.
bool window_ground_take_news(struct window_ground *ground);

#endif
