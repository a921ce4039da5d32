// The first place where a ray meets the height field. Any thread, each with its own reader.
#ifndef PERIGEE_REFERENCE_RAY_H
#define PERIGEE_REFERENCE_RAY_H

#include "base/vec.h"
#include "reference/field.h"

typedef struct ray_hit {
    double t;                // metres along the ray
    double lat, lon, height; // degrees, metres
} ray_hit;

// origin: ECEF; dir: unit; pixel: metres that a pixel is wide at distance 1. The ray is cut into
// pieces; a piece is passed over only when bounds prove that it does not meet the ground, or when
// it is shorter than RAY_TOLERANCE pixels (not below RAY_FLOOR_M) and ends above it. A ray that
// begins at or below the ground hits at t = 0. False: sky.
#define RAY_TOLERANCE 1e-4
#define RAY_FLOOR_M   1e-6
bool ray_cast(struct field_reader *reader, dvec3 origin, dvec3 dir, double pixel, ray_hit *hit);

// The same for the ray from `from` to `to` metres: at or below the ground at `from`, it hits there.
bool ray_cast_between(struct field_reader *reader, dvec3 origin, dvec3 dir, double pixel,
                      double from, double to, ray_hit *hit);

#endif
