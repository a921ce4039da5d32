// The tiles of an import under way: what this process writes, and what it may read besides: a
// finished planet that is added to, and the parts that other processes write. A part is a planet
// file of its own; others see what stood in it at the last seal. Any thread.
#ifndef PERIGEE_PLANET_IMPORT_STORE_H
#define PERIGEE_PLANET_IMPORT_STORE_H

#include "planet/import_base.h"
#include "planet/planet_part.h"
#include "planet/planet_writer.h"

struct border;
struct import_cache;
struct import_store;

typedef struct import_store_params {
    const char *part;         // file to write: rank 0's; other ranks write part.1, part.2, ...
    const char *fingerprint;  // of the parts
    struct import_base *base; // a finished planet that is added to, borrowed; NULL: none
    int rank;
    bool resume;
} import_store_params;

// Opens or creates this rank's part, sealed. Errors as planet_writer_open and planet_part_open.
status import_store_open(const import_store_params *params, struct import_store **out);
void import_store_close(struct import_store **store);

// Makes what was put readable by others, and lets go of theirs. Then, when all have sealed:
status import_store_seal(struct import_store *store);
// sees the parts of others as they are now. shared: they see this one, so that its file is kept as
// it is until the next seal.
status import_store_look(struct import_store *store, bool shared);

// Is the tile in any part? The base does not count.
bool import_store_has(struct import_store *store, tile_id id);
status import_store_put(struct import_store *store, tile_id id, const codec_blob *body, float min,
                        float max);

// From the parts, else from the base. As planet_writer_get.
status import_store_get(struct import_store *store, tile_id id, codec_blob *body, float *min,
                        float *max);
status import_store_commit(struct import_store *store);

// A codec_parent for bodies that import_store_get gives: those of a base hold what they add to its
// tiles. user: the store.
status import_store_base_height(void *store, tile_id id, float *heights);

typedef struct import_join {
    const char *path;          // of the finished planet
    struct planet_meta *meta;  // what the tiles say is filled in
    struct border *border;     // mends heights of the parts (import_border.h); NULL: none
    struct import_cache *kept; // heights that need not be decoded; NULL: none
    int threads;               // 0: one for each processor
    bool (*progress)(void *user, double done);
    void *user;
    uint64_t tiles; // out: how many there are
} import_join;

// Gathers all parts and the base (where no part has a tile) in the canonical order: the same tiles
// give the same bytes. With meta->max_error heights are coded anew (import_bounded.h); but tiles
// that the base has too, and those whose parent is not the base's any more, stand without loss,
// lest two errors add up. For one rank, when all have sealed and before any looks.
status import_store_join(struct import_store *store, import_join *join);

// Removes all parts, closed by all. `part` as in the params.
void import_store_remove(const char *part);

#endif
