// A planet made of single samples, and a field of it as seen from a point.
#ifndef PERIGEE_TESTS_REFERENCE_GROUND_H
#define PERIGEE_TESTS_REFERENCE_GROUND_H

#include "planet/planet_fixture.h"
#include "reference/field.h"

// Height of a sample of the global grid of a zoom.
typedef float ground_sample(int zoom, int64_t row, int64_t col);

struct ground {
    fixture files;
    opened planet;
    struct pool *pool;
    struct field *field;
    struct field_reader reader;
    bool bicubic; // of fields made from now on
};

// Zooms 0 to `zoom`; one ground at a time.
void ground_open(struct ground *ground, geo_ellipsoid e, int zoom, ground_sample *sample);
void ground_close(struct ground *ground);

// A field of that zoom, from an eye (ECEF) in all directions.
void ground_look_from(struct ground *ground, const double eye[3], int zoom);

// Where a sample lies, rad.
void ground_place(int zoom, int64_t row, int64_t col, double *lat, double *lon);

#endif
