// The ground that a camera sees: the height field of one zoom, or, with the zoom chosen by
// distance, one field for each doubling of the distance. Created by one thread, then any thread,
// each with its own reader.
#ifndef PERIGEE_REFERENCE_SIGHT_H
#define PERIGEE_REFERENCE_SIGHT_H

#include "reference/ray.h"

// A zoom of the camera's choice lies in [0, GRID_MAX_ZOOM], or is one of these.
enum {
    SIGHT_STORED = -1, // the finest stored anywhere
    SIGHT_AUTO = -2    // by distance, so that bilinear heights are within `error_px` of the limit
};

typedef struct sight_params {
    struct pyramid *pyramid;
    field_sight view; // eye and sides
    double pixel;     // metres that a pixel is wide at distance 1
    int zoom;
    double error_px; // SIGHT_AUTO: > 0
    bool bicubic;    // heights between samples; false: bilinear
} sight_params;

// What was chosen. error_px: what bilinear heights of these zooms are estimated to miss of the
// surface that endless refinement tends to, in pixels of the picture's middle, at most; 0 when a
// zoom was given, which is taken as it is.
typedef struct sight_ground {
    int zoom_min, zoom_max;
    double error_px;
} sight_ground;

struct sight;

// SIGHT_AUTO: between 2^k and 2^(k+1) quarters of the eye's clearance the zoom is the coarsest that
// is the finest stored or has four samples a pixel, and whose greatest second difference D in sight
// says that it is within error_px at the nearer end: D / 6 where finer zooms are smooth (D / 8 is
// missed by this zoom of the next, and a quarter of that by each zoom after it), D / 2 where they
// add detail (stored or synthesised: what a zoom adds shrinks by 2^0.85). Ground nearer than a
// quarter of the clearance counts as that far. Where a zoom would need too many tiles, the one
// before is kept and a warning logged; sight_get_ground() tells.
// ERR_ARGUMENT, logged, when a given zoom has too many tiles in sight; ERR_CANCELLED; ERR_MEMORY.
status sight_create(const sight_params *params, struct pool *pool,
                    const reference_progress *progress, struct sight **out);
void sight_destroy(struct sight **sight);

sight_ground sight_get_ground(const struct sight *sight);

// As ray_cast() from the eye. Leaves the reader at the field that was hit.
bool sight_cast(const struct sight *sight, struct field_reader *reader, dvec3 dir, ray_hit *hit);

// The nearest field, for readers to begin with.
const struct field *sight_nearest(const struct sight *sight);

#endif
