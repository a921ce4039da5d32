// The borders and holes of finer data in a planet that is being joined. What an import blends a
// seam into is what the coarser sources say; what is shown beyond the data is what coarser tiles
// say: the filter has carried some of the finer data there, and samples are rounded and
// interpolated from zoom to zoom. So the tiles there are mended as they are gathered, coarse to
// fine.
//
// At borders, as import_outline.h knows them, what was blended in of coarser sources is taken out,
// and what the finished tiles of the zoom below show is put in its place; and zooms between the two
// say nothing of the finer data where they would show beyond the border.
//
// Inside, at the edge of a hole, a tile ends in what the zoom before it shows there: over the
// feather's rows at the zoom of the finest source, over the outer half of as many at coarser ones,
// so that nothing of these shows within the feather of the next. A hole of a few samples is thus
// filled from the zoom that has none. One thread.
#ifndef PERIGEE_PLANET_IMPORT_BORDER_H
#define PERIGEE_PLANET_IMPORT_BORDER_H

#include "planet/import_tile.h"
#include "planet/planet_part.h"
#include "planet/planet_writer.h"

struct border;

// Where a tile that is to be joined has no heights, as codec_height_gaps; ERR_NOT_FOUND: it is not
// there.
typedef status (*border_gaps)(void *user, tile_id id, unsigned char *mask);

// workshop: of the heights, borrowed, one worker of it.
struct border *border_create(struct workshop *workshop);
void border_destroy(struct border **border);

// Before the first tile is mended.
void border_reads(struct border *border, border_gaps gaps, void *user);

// A tile of heights as the parts hold it, in the order of zooms. `writer` holds all tiles of
// coarser zooms. *mended: it has another body now, freed by the caller with codec_blob_deinit; its
// range, and those of the writer's tiles above, have become as wide as it takes, those by `wider`
// metres more.
status border_mend(struct border *border, struct planet_writer *writer, double wider,
                   planet_row *row, bool *mended);

#endif
