// The border of finer data in a planet that is being joined. What an import blends a seam into is
// what the coarser sources say; what is shown beyond the border is what coarser tiles say: the
// filter has carried some of the finer data there, and samples are rounded and interpolated from
// zoom to zoom. So the tiles on a border are mended as they are gathered, coarse to fine: what was
// blended in of coarser sources is taken out, and what the finished tiles of the zoom below show is
// put in its place; and zooms between the two say nothing of the finer data where they would show
// beyond the border. Mended are outer borders, as import_outline.h knows them. One thread.
#ifndef PERIGEE_PLANET_IMPORT_BORDER_H
#define PERIGEE_PLANET_IMPORT_BORDER_H

#include "planet/import_tile.h"
#include "planet/planet_part.h"
#include "planet/planet_writer.h"

struct border;

// workshop: of the heights, borrowed, one worker of it.
struct border *border_create(struct workshop *workshop);
void border_destroy(struct border **border);

// May the tile need it? Silent about how; cheap.
bool border_meets(const struct border *border, tile_id id);

// A tile of heights as the parts hold it. `writer` holds all tiles of coarser zooms. *mended: it
// has another body now, freed by the caller with codec_blob_deinit; its range, and those of the
// writer's tiles above, have become as wide as it takes, those by `wider` metres more.
status border_mend(struct border *border, struct planet_writer *writer, double wider,
                   planet_row *row, bool *mended);

#endif
