// Where the camera looks, without a frame that ever reads a tile: the frame guesses from the tiles
// in memory, and a worker asks for those that it lacks. Main only, one owner; a worker inside.
#ifndef PERIGEE_RENDER_SCOUT_H
#define PERIGEE_RENDER_SCOUT_H

#include "base/pool.h"
#include "render/gaze.h"

struct scout;

// Borrowed, both outlive the scout.
struct scout *scout_create(struct pyramid *pyramid, struct pool *pool);
void scout_destroy(struct scout **scout); // waits for its worker: for the disk, not the network

// The gaze as well as it is known. Never waits. Once exact it stays so for the same camera and
// aspect, whatever the cache lets go meanwhile; until then a worker is after it.
gaze scout_look(struct scout *scout, const geo_camera *camera, double aspect);

// What it knows came from data that have changed: it looks again.
void scout_forget(struct scout *scout);

// Waits until the worker has news or `timeout_s` has passed.
void scout_wait(struct scout *scout, double timeout_s);

#endif
