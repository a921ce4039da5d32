// What stands behind perigee_planet: its sources and their tiles. Any thread.
#ifndef PERIGEE_RENDER_PLANET_HANDLE_H
#define PERIGEE_RENDER_PLANET_HANDLE_H

#include "perigee.h"
#include "planet/source_set.h"

struct perigee_planet {
    struct source_set *sources;
    struct pyramid *pyramid;
};

#endif
