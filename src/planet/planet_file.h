// The planet file: one SQLite database of tiles of 256 x 256 samples, encoded as in codec.h.
// Identical tile bodies are stored once. A kill at any moment
// loses no committed tile. A height sample is metres above the ellipsoid at a cell centre, row 0
// northmost; NaN where the source had no data (the reader shows the parent's data there). Colour is
// sRGB-encoded, night is one channel of encoded light.
#ifndef PERIGEE_PLANET_PLANET_FILE_H
#define PERIGEE_PLANET_PLANET_FILE_H

#include <stddef.h>

#include "base/status.h"
#include "geo/ellipsoid.h"
#include "planet/grid.h"

enum { PLANET_SCHEMA_VERSION = 3, PLANET_TEXT_SIZE = 512 };

struct planet_meta {
    char name[64];
    char attribution[PLANET_TEXT_SIZE]; // shown with every picture of the planet
    geo_ellipsoid ellipsoid;
    int max_zoom[LAYER_COUNT];     // finest zoom with any tile; -1: layer absent
    double height_min, height_max; // of all stored heights, metres above the ellipsoid
    // Synthesis below the data: rms of what one zoom adds to its parent, as a share of the parent's
    // local relief (0: none), measured on the finest three zooms at import.
    double synthesis_gain;
    // Heights are at most half of this many metres from what the import made; 0: what it made, to
    // the last bit. Each is a multiple of a power of two up to it.
    double quantum;
    double quantum_finest; // the same of the finest zoom alone
    // > 0: heights are at most this many metres from what the import made, and tiles hold what they
    // add to their parents.
    double max_error;
    bool complete; // the import that made it has finished
};

struct planet_file;
struct codec_blob;

// Opens for reading. ERR_NOT_FOUND, ERR_FORMAT (not a planet, truncated), ERR_VERSION; one clear
// line is logged. The handle: any thread, each call opens or reuses a connection of the calling
// thread's slot inside.
status planet_file_open(const char *path, struct planet_file **out);
void planet_file_close(struct planet_file **file);

const struct planet_meta *planet_file_meta(const struct planet_file *file);
const char *planet_file_path(const struct planet_file *file);

// Reads and decodes one tile. ERR_NOT_FOUND (silently) when it is not stored, ERR_FORMAT when it is
// corrupt (logged with path and tile), ERR_IO when the disk fails (logged once until it works
// again). heights: 256 * 256 floats; pixels: 256 * 256 * channels bytes (colour 3, night 1). Any
// thread.
status planet_file_read_height(struct planet_file *file, tile_id id, float *heights);
status planet_file_read_pixels(struct planet_file *file, tile_id id, unsigned char *pixels);

// The body of a tile of pixels as it is stored, checked against its hash (codec.h). Free with
// codec_blob_deinit.
status planet_file_read_body(struct planet_file *file, tile_id id, struct codec_blob *out);

// Smallest and greatest height stored in a tile and in the tiles below it, as far as every tile
// between is stored (an import of version 1: in the tile alone). ERR_NOT_FOUND as above.
status planet_file_read_range(struct planet_file *file, tile_id id, float *min, float *max);

// How many tiles of a layer are stored, and the bytes of their bodies (each once). Reads all of the
// layer's rows, but no body.
status planet_file_size(struct planet_file *file, enum tile_layer layer, uint64_t *tiles,
                        uint64_t *bytes);

// Calls `each` for every stored tile of a layer, coarse to fine, rows from the north, columns from
// the west. Rows of the table that name no tile of the grid are left out. Any thread.
status planet_file_list(struct planet_file *file, enum tile_layer layer,
                        void (*each)(void *user, tile_id id), void *user);

#endif
