// One rendered frame with its truth per pixel as a scanline EXR (ZIP). Any thread.
//   R, G, B   linear light, float or half
//   Z         metres along the view axis; NaN: sky (so for the planes below)
//   height    metres above the ellipsoid
//   lat, lon  degrees as floats; lat.lo, lon.lo what a float leaves out, so that lat + lat.lo is
//   good to 1e-12 degrees
//   easting, northing  of the map of a projected raster, in its units; .lo likewise
//   level     continuous level of detail; -1: sky
//   nx, ny, nz  unit normal of the ground, ECEF; only where the renderer knows it
#ifndef PERIGEE_APP_IMAGE_EXR_H
#define PERIGEE_APP_IMAGE_EXR_H

#include <stdbool.h>

#include "base/status.h"
#include "perigee.h"

typedef struct image_exr {
    int width, height;
    perigee_planes planes; // all of them set, top row first
    bool half_color;
    perigee_camera
        camera; // attributes camera.lat, .lon, .alt, .heading, .pitch, .roll, .fov (doubles)
    const char *planet;               // attribute planet
    const char *attribution;          // attribute attribution
    const char *zoom;                 // attribute zoom: of which heights; NULL: none
    const float *normals[3];          // nx, ny, nz; NULL: none
    const double *easting, *northing; // NULL: none
} image_exr;

// By way of PATH.part. ERR_IO, logged with the path; nothing is left behind.
status image_exr_write(const char *path, const image_exr *image);

// Other planes of such a frame: floats, top row first, in the order of their names' bytes. Size,
// camera and texts are those of `about`.
typedef struct image_exr_plane {
    const char *name;
    const float *values;
} image_exr_plane;

enum { IMAGE_EXR_MAX_PLANES = 20 };

status image_exr_write_planes(const char *path, const image_exr *about,
                              const image_exr_plane *planes, int count);

// What a file written by image_exr_write holds. Owned memory; NULL planes: the file has no such
// channel.
typedef struct image_exr_file {
    int width, height;
    float *r, *g, *b, *z_m, *height_m, *level, *normals[3];
    double *lat_deg, *lon_deg;
    bool has_camera;
    perigee_camera camera;
    char planet[64]; // "" when the file does not say
} image_exr_file;

// Reads a single scanline picture of float or half channels; channels it does not know are left.
// ERR_NOT_FOUND, ERR_IO, ERR_FORMAT, ERR_MEMORY, logged with the path: also when Z is missing.
status image_exr_read(const char *path, image_exr_file *out);
void image_exr_file_deinit(image_exr_file *file);

#endif
