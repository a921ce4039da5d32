// Terrain heights for the camera without ever waiting for the disk: a worker looks up the place the
// camera is over. Until it answers, a neighbouring answer does for a camera far enough above it,
// and for one that is not, what is in memory: all of it, as a rule, of ground that is in view. Main
// only.
#ifndef PERIGEE_APP_WINDOW_GROUND_H
#define PERIGEE_APP_WINDOW_GROUND_H

#include <stdbool.h>

#include "perigee.h"

struct window_ground;

// planet is borrowed.
struct window_ground *window_ground_create(perigee_planet *planet);
void window_ground_destroy(struct window_ground **ground); // waits for the worker

// Terrain height at a place (rad), for one who is `room` metres above what was last known there:
// when the terrain could be met, exact if its tiles are in memory or the worker has read them, else
// as fine as there is; from near by when it could not be met; 0 from orbit. NaN while nothing is
// known.
double window_ground_at(struct window_ground *ground, double lat, double lon, double room);

// true once after the worker has answered.
bool window_ground_take_news(struct window_ground *ground);

#endif
