// The judge of every renderer: one ray a pixel, in double precision, against the height field
// P = S(lat, lon) + h(lat, lon) n with h bilinear or bicubic in the samples of one zoom, or of a
// zoom chosen by distance. It shares no code with the clipmap, and its conversions are
// GeographicLib's. The same input gives the same bits whatever the number of threads. One call at a
// time for each thread.
#ifndef PERIGEE_REFERENCE_REFERENCE_H
#define PERIGEE_REFERENCE_REFERENCE_H

#include "base/vec.h"
#include "reference/sight.h"

typedef struct reference_camera {
    double lat_deg, lon_deg, alt_m;
    double heading_deg, pitch_deg, roll_deg, fov_deg; // as perigee_camera, all given
} reference_camera;

typedef struct reference_params {
    struct pyramid *pyramid;
    reference_camera camera;
    int width, height; // px, 1 to 16384
    int zoom;          // of the height field, SIGHT_STORED or SIGHT_AUTO
    double error_px;   // with SIGHT_AUTO; 0: 0.05
    bool bicubic;      // heights between samples; false: bilinear
    int threads;       // 0: one for each processor
    bool has_sun;      // false: noon at the camera, as perigee_view has it
    dvec3 sun;         // unit, ECEF
    reference_progress progress;
    sight_ground *ground; // NULL, or told what was chosen
} reference_params;

// Top row first, width * height each; NULL planes are skipped. Sky is NaN (level: -1, colour 0).
typedef struct reference_planes {
    float *r, *g, *b; // linear light, without air
    float *z_m, *height_m;
    double *lat_deg, *lon_deg;
    float *level;        // the zoom
    float *nx, *ny, *nz; // unit normal of the height field, upward, ECEF
} reference_planes;

// ERR_ARGUMENT, logged, for impossible numbers and for a zoom with too many tiles in sight;
// ERR_CANCELLED when the progress asks for it.
status reference_render(const reference_params *params, const reference_planes *planes);

// The ray through a pixel's point ((0.5, 0.5): centre of the top left pixel): ECEF origin and a
// direction of length 1 along the view axis.
void reference_ray(geo_ellipsoid e, const reference_camera *camera, int width, int height,
                   double x_px, double y_px, dvec3 *origin, dvec3 *dir);

#endif
