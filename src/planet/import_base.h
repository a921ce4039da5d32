// The finished planet that an import adds to, as what lies below all of its sources. Any thread.
#ifndef PERIGEE_PLANET_IMPORT_BASE_H
#define PERIGEE_PLANET_IMPORT_BASE_H

#include <stdbool.h>

#include "planet/planet_file.h"

struct import_base;

// Errors as planet_file_open.
status import_base_open(const char *path, struct import_base **out);
void import_base_close(struct import_base **base);

const char *import_base_path(const struct import_base *base);
const struct planet_meta *import_base_meta(const struct import_base *base);

// Is the tile stored? Is any of those that the next zoom has in its place? No I/O.
bool import_base_has(const struct import_base *base, tile_id id);
bool import_base_has_finer(const struct import_base *base, tile_id id);

// Distance of the samples in latitude of the finest tile stored at a place; rad, 0: there is none.
// No I/O.
double import_base_step(const struct import_base *base, enum tile_layer layer, double lat,
                        double lon);

// planes: 256 x 256 heights, NaN where there is no data, or 3 (colour) or 1 (night) times as many
// of linear light.

// The tile as it is stored. ERR_NOT_FOUND, silently; else as planet_file_read_height.
status import_base_read(struct import_base *base, tile_id id, float *planes);

// Where it has no heights: bit (i % 8) of mask[i / 8]. ERR_NOT_FOUND, silently.
status import_base_gaps(struct import_base *base, tile_id id, unsigned char *mask);

// The same without what the planet's finer tiles made of it (import_tile.h): NaN where that was
// all, the stored value where it cannot be told apart. `step`: of the grid of heights, 0: none.
status import_base_read_alone(struct import_base *base, tile_id id, double step, float *planes);

// What the planet shows at the tile's samples: where none is stored, what coarser tiles make of
// them, without synthesis; NaN where no tile above has data either.
status import_base_show(struct import_base *base, tile_id id, float *planes);

#endif
