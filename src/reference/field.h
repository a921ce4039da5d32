// The height field of a frame: every sample of one zoom of the pyramid, bilinear between, and for
// any box of the map a height that nothing in it exceeds. Degrees; longitudes may be any number of
// turns away. The field: any thread, once scanned; a reader: one thread.
#ifndef PERIGEE_REFERENCE_FIELD_H
#define PERIGEE_REFERENCE_FIELD_H

#include "base/pool.h"
#include "planet/pyramid.h"

// Tells how far it is, in [0, 1]; true cancels. Called on the thread that asked for the work.
typedef struct reference_progress {
    bool (*report)(void *user, double done);
    void *user;
} reference_progress;

struct field;

// What can be seen from `eye` (ECEF): the tiles of the cap that the horizon of eye and of the
// highest ground bound are read once and their maxima kept. ERR_ARGUMENT, logged, when these are
// too many; ERR_CANCELLED; ERR_MEMORY.
status field_create(struct pyramid *pyramid, int zoom, const double eye[3], struct pool *pool,
                    const reference_progress *progress, struct field **out);
void field_destroy(struct field **field);

int field_zoom(const struct field *field);
geo_ellipsoid field_ellipsoid(const struct field *field);
// Bounds of the heights in the cap.
void field_range(const struct field *field, double *min, double *max);

typedef struct field_box {
    double south, north, west, east;
} field_box;

// Not less than any height in the box; the box lies in the cap.
double field_max(const struct field *field, const field_box *box);

enum { FIELD_SLOTS = 16 };

struct field_reader {
    struct field *field;
    struct pyramid *pyramid;
    const pyramid_tile *heights[FIELD_SLOTS], *colors[FIELD_SLOTS];
    status error; // first failure; samples are 0 from then on
};

void field_reader_init(struct field_reader *reader, struct field *field, struct pyramid *pyramid);
void field_reader_deinit(struct field_reader *reader);

// One piece of the field, bilinear: h = (1 - u) (a + ka v) + u (b + kb v), u = (north - lat) /
// step, v = lon - ref, valid in `box`.
typedef struct field_patch {
    field_box box;
    double step, ref;
    double a, ka, b, kb;
} field_patch;

bool field_box_holds(const field_box *outer, const field_box *inner);

// The piece that holds a point.
field_patch field_patch_at(struct field_reader *reader, double lat, double lon);
double field_patch_height(const field_patch *patch, double lat, double lon);

double field_height(struct field_reader *reader, double lat, double lon);

// Slopes of the piece that holds a point, metres a degree.
void field_gradient(struct field_reader *reader, double lat, double lon, double *per_lat,
                    double *per_lon);

// Linear R, G, B and encoded night light at a continuous zoom, bilinear and linear between zooms.
// False when the planet has no imagery: `rgba` is then grey ground.
bool field_color(struct field_reader *reader, double zoom, double lat, double lon, double rgba[4]);

#endif
