// The last step of an import with a bound on the error of heights: tiles in the canonical order,
// coarse to fine, each coded by what it adds to its parent as that will be decoded. Workers code;
// what is written depends on the order alone. One thread calls.
#ifndef PERIGEE_PLANET_IMPORT_BOUNDED_H
#define PERIGEE_PLANET_IMPORT_BOUNDED_H

#include <pthread.h>

#include "planet/planet_part.h"
#include "planet/planet_writer.h"

struct bounder;

// `writer` takes the tiles and is borrowed; nobody else may use it before bounder_flush or
// bounder_destroy. threads: 0: one for each processor.
struct bounder *bounder_create(struct planet_writer *writer, double max_error, int threads);
void bounder_destroy(struct bounder **bounder);

// A tile of heights as the parts hold it; the ranges of tiles become wider by the bound.
status bounder_put(struct bounder *bounder, const planet_row *row);

// A tile whose body and range stay as they are.
status bounder_keep(struct bounder *bounder, const planet_row *row);

// Writes what is still under way. Before other layers' tiles are put.
status bounder_flush(struct bounder *bounder);

// A file being written, to be read from. lock: of several threads; NULL: there is one.
typedef struct bounded_source {
    struct planet_writer *writer;
    pthread_mutex_t *lock;
} bounded_source;

// The heights of a tile, of either kind of body. Errors as planet_writer_get; ERR_FORMAT is logged.
status bounded_read(const bounded_source *source, tile_id id, float *heights);

#endif
