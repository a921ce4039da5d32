// How far inside its data a sample of a mosaic lies, as the weight it has over what lies below: 0
// at the edge of the data (of a file or of a hole), 1 from the feather's width on, smooth between.
// Distance is taken on the ground, in rows of the mosaic's own zoom, on the samples of that zoom;
// tiles of finer zooms read it bilinearly, so that the weight does not jump at any tile's edge.
#ifndef PERIGEE_PLANET_IMPORT_BLEND_H
#define PERIGEE_PLANET_IMPORT_BLEND_H

#include <stddef.h>

#include "base/status.h"
#include "planet/region.h"

// A sample of a mosaic that lies on its very edge still counts as there.
#define BLEND_LEAST_WEIGHT 1e-3f

enum { BLEND_MAX_ROWS = 255, BLEND_MASK_BYTES = TILE_SIZE * TILE_SIZE / 8 };

// Where a mosaic has data in a tile of its own zoom: bit (i % 8) of mask[i / 8], i row-major.
// ERR_IO: the mask is that of now, and not kept.
typedef status (*blend_read)(void *user, int mosaic, tile_id id, unsigned char *mask);

struct blend;

// `feather`: rows, in [1, BLEND_MAX_ROWS]. Shared by workers, any thread; it keeps as many masks
// read before, 8 KiB each.
struct blend *blend_create(int feather, int masks);
void blend_destroy(struct blend **blend);

// Room of one worker; zero to begin with.
struct blend_room {
    unsigned char *masks, *valid;
    float *square, *distance;
    size_t masks_size, valid_size, square_size, distance_size;
};

void blend_room_deinit(struct blend_room *room);

// weights: 256 x 256 at the samples of `id`, in (0, 1]; of the layer of `id`, mosaic's own zoom
// `own` <= id.zoom. `read` gives masks that are not kept.
status blend_weights(struct blend *blend, int mosaic, int own, tile_id id, blend_read read,
                     void *user, struct blend_room *room, float *weights);

// The same at the samples of a rectangle (region.h; its data is not looked at) inside the planet,
// rows x cols, in [0, 1], 0 up to `margin` rows from the edge, 1 from the feather's width on:
// whatever the rectangle, the same to the bit. Columns count as half a row at least, and what lies
// beyond a pole as data.
status blend_region(struct blend *blend, const region *r, float margin, blend_read read, void *user,
                    struct blend_room *room, float *weights);

// Columns on either side of a rectangle that it looks at; rows: the feather's.
int blend_reach(const struct blend *blend);

#endif
