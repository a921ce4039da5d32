// Which tiles of a layer are stored: a sorted array of keys, 8 bytes a tile. Any thread.
#ifndef PERIGEE_PLANET_TILE_INDEX_H
#define PERIGEE_PLANET_TILE_INDEX_H

#include <stdbool.h>

#include "planet/planet_file.h"

struct tile_index;

status tile_index_create(struct planet_file *file, enum tile_layer layer, struct tile_index **out);
void tile_index_destroy(struct tile_index **index);

// Finest zoom with a tile, -1 when there is none.
int tile_index_max_zoom(const struct tile_index *index);

bool tile_index_has(const struct tile_index *index, tile_id id);

// Zoom of the tile itself or of its nearest stored ancestor, -1 when none is stored.
int tile_index_data_zoom(const struct tile_index *index, tile_id id);

// Notes that a stored tile cannot be read. True the first time.
bool tile_index_mark_bad(struct tile_index *index, tile_id id);

// Is the tile stored, and not noted as bad?
bool tile_index_readable(const struct tile_index *index, tile_id id);

#endif
