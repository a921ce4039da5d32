// What stands behind perigee_planet: the file and its tiles. Any thread.
#ifndef PERIGEE_RENDER_PLANET_HANDLE_H
#define PERIGEE_RENDER_PLANET_HANDLE_H

#include "perigee.h"
#include "planet/pyramid.h"

struct perigee_planet {
    struct planet_file *file;
    struct pyramid *pyramid;
};

#endif
