// Every tile of the planet at every zoom, whether stored or not, through one bounded cache.
// A tile that is not stored, is corrupt, or lies below the data comes from its parent: upsampled by
// the four-point filter and, for heights when synthesis is on, given a residual that depends
// on place and zoom only (synthesis.h) and comes in over eight samples beside stored ones of that
// zoom. Samples a stored tile marks as NaN are filled the same way.
// At zoom 0 what is missing is height 0, a grey ground and no light. Any thread. A tile's samples
// are the same whatever was asked before, by whom, and in which order.
#ifndef PERIGEE_PLANET_PYRAMID_H
#define PERIGEE_PLANET_PYRAMID_H

#include <stdint.h>

#include "planet/source.h"
#include "planet/synthesis.h"

struct pyramid;

typedef struct pyramid_params {
    size_t cache_bytes;       // bound of all tiles held, at least 16 MiB; 0: 256 MiB; besides, of a
                              // source with synthesis up to 4 MiB say where its tiles have gaps
    enum synthesis synthesis; // detail below the data
    bool flat;                // the body is the map as a plane
} pyramid_params;

// One tile held in the cache: heights (LAYER_HEIGHT) or RGBA (LAYER_COLOR: sRGB-encoded R, G, B,
// and in A the night layer's light, 0 where there is none), 256 x 256, row 0 northmost. LAYER_NIGHT
// is not asked for by itself.
typedef struct pyramid_tile {
    tile_id id;
    const float *heights;
    const uint8_t *rgba;
    float min, max; // heights: of these samples
    double until_s; // clock_now_s until which they stand; INFINITY but for a stand-in
} pyramid_tile;

struct pyramid_counters {
    uint64_t decoded, synthesised, upsampled, corrupt, cache_hits, cache_bytes;
    uint64_t failed; // tiles that a source gave up for now
};

// `file` is borrowed and must outlive the pyramid.
status pyramid_create(struct planet_file *file, const pyramid_params *params, struct pyramid **out);

// One source of several: the first is the ground, each further one lies over those before it where
// it has data, mixed with them by its opacity. It is upsampled below its own data before it is
// mixed in, so that its weight is the same at every zoom; its heights end up to four of its own
// samples inside its border.
typedef struct pyramid_layer {
    struct source *source; // borrowed, outlives the pyramid
    float opacity;         // in [0, 1]; of the first: 1
} pyramid_layer;

enum { PYRAMID_MAX_LAYERS = 16 };

// 1 to PYRAMID_MAX_LAYERS layers. ERR_ARGUMENT, logged, when their ellipsoids disagree.
status pyramid_create_stack(const pyramid_layer *layers, int count, const pyramid_params *params,
                            struct pyramid **out);
void pyramid_destroy(struct pyramid **pyramid);

const struct planet_meta *pyramid_meta(const struct pyramid *pyramid);

// Whether heights below the data have synthesised detail.
bool pyramid_synthesises(const struct pyramid *pyramid);

// Which kind the ground has.
enum synthesis pyramid_synthesis(const struct pyramid *pyramid);

// Are a tile's heights a function of its parent's and of place alone, by synthesis of one source
// that never changes, with no stored tile of its zoom near? True for ever. Cheap.
bool pyramid_derives(const struct pyramid *pyramid, tile_id id);

// Holds the tile until released; reads, decodes or makes it on the calling thread when it is not
// cached. ERR_PENDING when what it is made of is still on its way, in which the want then has a
// share; otherwise ERR_MEMORY only: bad or missing data is replaced and counted, and what cannot be
// had for now has a stand-in from coarser data. zoom in [0, GRID_MAX_ZOOM], row and col inside the
// grid.
status pyramid_try(struct pyramid *pyramid, tile_id id, struct want *want,
                   const pyramid_tile **out);

// The same, but waits for what is on its way. ERR_MEMORY, or ERR_CANCELLED after pyramid_give_up.
status pyramid_acquire(struct pyramid *pyramid, tile_id id, const pyramid_tile **out);

// Ends all waiting in pyramid_acquire and pyramid_height_at, now and for good: for who wants to
// leave while a server hangs.
void pyramid_give_up(struct pyramid *pyramid);
void pyramid_release(struct pyramid *pyramid, const pyramid_tile **tile);

// Finest zoom at which data is stored at or above this tile's zoom for its place: zoom of the tile
// itself or of its nearest stored ancestor; -1 when none. Cheap: the index is held in memory.
int pyramid_data_zoom(struct pyramid *pyramid, tile_id id);

// Is a height stored at any of `count` places (degrees; those that are not finite are passed over),
// at whatever zoom? Elsewhere heights are made up. Reads tiles, past the cache, and waits for what
// is on its way. ERR_MEMORY only.
status pyramid_knows_any(struct pyramid *pyramid, const double *lat_deg, const double *lon_deg,
                         size_t count, bool *known);

// Bilinear height in the data at `zoom` (clamped to GRID_MAX_ZOOM), metres above the ellipsoid.
// Blocks on I/O.
status pyramid_height_at(struct pyramid *pyramid, int zoom, double lat, double lon, double *height);

// The same without waiting for a network: ERR_PENDING while tiles are on their way, in which the
// want then has a share. Reads the disk.
status pyramid_height_try(struct pyramid *pyramid, int zoom, double lat, double lon,
                          struct want *want, double *height);

// The same without reading anything: from the finest zoom up to `zoom` whose tiles at the place are
// in memory. Returns that zoom; -1, and height 0, when there is none.
int pyramid_height_held(struct pyramid *pyramid, int zoom, double lat, double lon, double *height);

void pyramid_counters(struct pyramid *pyramid, struct pyramid_counters *out);

#endif
