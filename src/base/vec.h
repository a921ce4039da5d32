// Vectors and 3 x 3 matrices in double precision. Pure values; matrices are rows of vectors,
// applied to columns.
#ifndef PERIGEE_BASE_VEC_H
#define PERIGEE_BASE_VEC_H

#include <math.h>

#ifndef M_PI
#define M_PI 3.14159265358979323846
#endif

typedef struct dvec3 {
    double x, y, z;
} dvec3;

typedef struct dmat3 {
    dvec3 row[3];
} dmat3;

static inline dvec3 dvec3_make(double x, double y, double z)
{
    return (dvec3){x, y, z};
}

static inline dvec3 dvec3_add(dvec3 a, dvec3 b)
{
    return (dvec3){a.x + b.x, a.y + b.y, a.z + b.z};
}

static inline dvec3 dvec3_sub(dvec3 a, dvec3 b)
{
    return (dvec3){a.x - b.x, a.y - b.y, a.z - b.z};
}

static inline dvec3 dvec3_scale(dvec3 a, double s)
{
    return (dvec3){a.x * s, a.y * s, a.z * s};
}

// a + b s
static inline dvec3 dvec3_mad(dvec3 a, dvec3 b, double s)
{
    return (dvec3){a.x + b.x * s, a.y + b.y * s, a.z + b.z * s};
}

static inline double dvec3_dot(dvec3 a, dvec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline dvec3 dvec3_cross(dvec3 a, dvec3 b)
{
    return (dvec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline double dvec3_length(dvec3 a)
{
    return sqrt(dvec3_dot(a, a));
}

// NaN for the zero vector.
static inline dvec3 dvec3_normalize(dvec3 a)
{
    return dvec3_scale(a, 1.0 / dvec3_length(a));
}

static inline dvec3 dmat3_mul(dmat3 m, dvec3 v)
{
    return (dvec3){dvec3_dot(m.row[0], v), dvec3_dot(m.row[1], v), dvec3_dot(m.row[2], v)};
}

static inline dmat3 dmat3_transpose(dmat3 m)
{
    return (dmat3){{{m.row[0].x, m.row[1].x, m.row[2].x},
                    {m.row[0].y, m.row[1].y, m.row[2].y},
                    {m.row[0].z, m.row[1].z, m.row[2].z}}};
}

static inline double clamp_double(double x, double low, double high)
{
    return x < low ? low : x > high ? high : x;
}

#endif
