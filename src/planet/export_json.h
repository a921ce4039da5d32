// The document of an exported planet. Inside the planet room.
#ifndef PERIGEE_PLANET_EXPORT_JSON_H
#define PERIGEE_PLANET_EXPORT_JSON_H

#include "planet/planet_file.h"

// The tiles of a layer, in the order of planet_file_list.
typedef struct export_list {
    tile_id *ids;
    size_t count, room;
    bool out_of_memory;
} export_list;

// On the heap; NULL when memory is out.
char *export_json(const struct planet_meta *meta, const export_list lists[LAYER_COUNT]);

#endif
