// The height field of a frame: the samples of one zoom of the pyramid, bilinear or bicubic between,
// and for any box of the map a height that nothing in sight in it exceeds. Degrees; longitudes may
// be any number of turns away. The field: any thread, once scanned; a reader: one thread.
#ifndef PERIGEE_REFERENCE_FIELD_H
#define PERIGEE_REFERENCE_FIELD_H

#include "base/pool.h"
#include "base/vec.h"
#include "planet/pyramid.h"
#include "reference/patch.h"

// Tells how far it is, in [0, 1]; true cancels. Called on the thread that asked for the work.
typedef struct reference_progress {
    bool (*report)(void *user, double done);
    void *user;
} reference_progress;

struct field;

enum { FIELD_MAX_SIDES = 4, FIELD_MAX_TILES = 65536 };

// What a field must answer for: rays that begin at the eye and run on the positive side of planes
// through it, from `near` metres to `far`.
typedef struct field_sight {
    dvec3 eye;                   // ECEF
    dvec3 side[FIELD_MAX_SIDES]; // unit normals
    int sides;                   // 0: rays of all directions
    double near, far;            // far 0: without end
} field_sight;

typedef struct field_params {
    struct pyramid *pyramid;
    int zoom; // [0, GRID_MAX_ZOOM]
    field_sight sight;
    bool bicubic; // between the samples; false: bilinear
} field_params;

// Tiles of which a ray in sight may need a sample: those whose sphere, grown by the range of the
// planet's heights and by what interpolation reaches, is met. SIZE_MAX when not even their number
// can be told.
size_t field_count_tiles(const field_params *params);

// Reads the tiles in sight once and keeps their maxima: 11 KiB a tile, so 0.7 GiB at most; twice
// that when bicubic, whose surface rises above its samples by a share of their range.
// ERR_ARGUMENT, logged, when they are more than FIELD_MAX_TILES; ERR_CANCELLED; ERR_MEMORY.
status field_create(const field_params *params, struct pool *pool,
                    const reference_progress *progress, struct field **out);
void field_destroy(struct field **field);

int field_zoom(const struct field *field);
int field_order(const struct field *field); // PATCH_LINEAR or PATCH_CUBIC
geo_ellipsoid field_ellipsoid(const struct field *field);
size_t field_tiles(const struct field *field);
// Bounds of the surface in sight; 0 and 0 when there is no ground in sight.
void field_range(const struct field *field, double *min, double *max);
// The greatest second difference of neighbouring samples in sight, metres: over 8, and more or less
// a quarter of it at each finer zoom of a smooth surface, it is what bilinear heights miss.
double field_bend(const struct field *field);

// Not less than any height in the box that is in sight.
double field_max(const struct field *field, const field_box *box);

enum { FIELD_SLOTS = 16 };

struct field_reader {
    const struct field *field; // may be changed between calls
    struct pyramid *pyramid;
    const pyramid_tile *heights[FIELD_SLOTS], *colors[FIELD_SLOTS];
    status error; // first failure; samples are 0 from then on
};

void field_reader_init(struct field_reader *reader, const struct field *field,
                       struct pyramid *pyramid);
void field_reader_deinit(struct field_reader *reader);

// The piece of the field that holds a point.
field_patch field_patch_at(struct field_reader *reader, double lat, double lon);

double field_height(struct field_reader *reader, double lat, double lon);

// Slopes of the piece that holds a point, metres a degree.
void field_gradient(struct field_reader *reader, double lat, double lon, double *per_lat,
                    double *per_lon);

// Linear R, G, B and encoded night light at a continuous zoom, bilinear and linear between zooms;
// the pyramid's bare ground when the planet has no imagery.
void field_color(struct field_reader *reader, double zoom, double lat, double lon, double rgba[4]);

#endif
