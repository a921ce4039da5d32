// One rendered frame with its truth per pixel as a scanline EXR (ZIP). Any thread.
//   R, G, B   linear light, float or half
//   Z         metres along the view axis; NaN: sky (so for the planes below)
//   height    metres above the ellipsoid
//   lat, lon  degrees as floats; lat.lo, lon.lo what a float leaves out, so that lat + lat.lo is
//   good to 1e-12 degrees level     continuous level of detail; -1: sky
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
    const char *planet;      // attribute planet
    const char *attribution; // attribute attribution
    const char *zoom;        // attribute zoom: of which heights; NULL: none
} image_exr;

// By way of PATH.part. ERR_IO, logged with the path; nothing is left behind.
status image_exr_write(const char *path, const image_exr *image);

#endif
