// The stored tiles of a planet file as they lie there, undecoded: for imports, which gather parts
// and finished planets into one file. A handle: any thread, one at a time.
#ifndef PERIGEE_PLANET_PLANET_PART_H
#define PERIGEE_PLANET_PLANET_PART_H

#include "planet/codec.h"
#include "planet/planet_file.h"

struct planet_part;

// Sees what the file holds now: nothing a writer commits later, nor what stands in its log. The
// writer must not fold its log into the file while the part is open. Errors as planet_file_open.
status planet_part_open(const char *path, struct planet_part **out);
void planet_part_close(struct planet_part **part);

bool planet_part_has(struct planet_part *part, tile_id id);

// As planet_writer_get.
status planet_part_get(struct planet_part *part, tile_id id, codec_blob *body, float *min,
                       float *max);

// One stored tile of a walk; `body` belongs to the part and stands until the next step.
typedef struct planet_row {
    tile_id id;
    codec_blob body;
    int64_t hash; // store_hash of the body
    float min, max;
} planet_row;

// The next tile in the order of layer, zoom, row, column, from the first on; ERR_NOT_FOUND,
// silently, after the last. Its body is what was written, else ERR_FORMAT, logged.
status planet_part_next(struct planet_part *part, planet_row *row);

// Text and count of tiles; the fingerprint is freed by the caller, NULL when there is none.
char *planet_part_fingerprint(struct planet_part *part);
status planet_part_count(struct planet_part *part, uint64_t *tiles);

#endif
