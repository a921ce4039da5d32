// Where stored tiles come from: a planet file, a tile server, a raster. One small interface: which
// tiles it may have, and a tile's samples for the asking, without ever waiting for a network.
// Everything above (pyramid.h) knows sources by this header alone. Any thread.
#ifndef PERIGEE_PLANET_SOURCE_H
#define PERIGEE_PLANET_SOURCE_H

#include <stdint.h>

#include "planet/planet_file.h"
#include "planet/want.h"

struct source;

struct source_counters {
    uint64_t corrupt; // tiles that could not be read, each counted once
    uint64_t failed;  // answers that were given up for now
};

struct source_ops {
    bool (*has)(const struct source *source, tile_id id);
    status (*read)(struct source *source, tile_id id, struct want *want, void *samples,
                   double *until_s);
    void (*counters)(struct source *source, struct source_counters *out); // may be NULL
    void (*close)(struct source *source);
};

// The first member of every source. `meta`: name, attribution, ellipsoid (zero: not said),
// max_zoom of each layer, bounds of heights (may be wide), gain of the synthesis.
struct source {
    const struct source_ops *ops;
    struct planet_meta meta;
    const char *path; // in messages
    // What a tile has no data for has none: it is not filled from coarser tiles, of which a sample
    // at the border may hold more than there is.
    bool gaps_final;
};

// May the tile be stored? No I/O. False for ever, or true for ever but for tiles found unreadable.
bool source_has(const struct source *source, tile_id id);

// The samples of a tile, into the caller's room, 256 x 256, row 0 northmost:
//   LAYER_HEIGHT  float metres above the ellipsoid, NaN where there is no data
//   LAYER_COLOR   R, G, B, A bytes: sRGB-encoded, multiplied by A / 255; A 0 where there is no data
//   LAYER_NIGHT   one byte of encoded light
// *until_s: the answer holds until then (clock_now_s); INFINITY but for a stand-in.
// OK; ERR_NOT_FOUND: no such tile; ERR_PENDING: on its way, the want has a share in it; ERR_IO:
// given up until *until_s; ERR_FORMAT: it is there but is no tile (logged); ERR_MEMORY.
// `want` must not be NULL.
status source_read(struct source *source, tile_id id, struct want *want, void *samples,
                   double *until_s);

void source_counters(struct source *source, struct source_counters *out);
void source_close(struct source **source);

// A planet file as a source. The first takes the file over, also when it fails; the other borrows.
status source_file_open_take(struct planet_file *file, struct source **out);
status source_file_open(struct planet_file *file, struct source **out);

#endif
