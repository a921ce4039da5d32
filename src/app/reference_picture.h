// Pictures by the reference, for the commands that make them. Main only.
#ifndef PERIGEE_APP_REFERENCE_PICTURE_H
#define PERIGEE_APP_REFERENCE_PICTURE_H

#include <stdint.h>

#include "app/options.h"
#include "reference/reference.h"

struct reference_source {
    const struct options *options;
    struct source_set *set;
    struct pyramid *pyramid;
};

// Opens the tiles of the planet that the options name. Deinit whatever the status.
status reference_source_init(struct reference_source *s, const struct options *o);
void reference_source_deinit(struct reference_source *s);

// Do the planet's heights, if it has any, reach into a picture with these places of `pixels` (NaN:
// sky)? ERR_ARGUMENT, logged, when all its ground is made up: it is nothing to judge by.
status reference_source_check(const struct reference_source *s, const perigee_camera *camera,
                              const double *lat_deg, const double *lon_deg, size_t pixels);

// A view by the options (zoom, threads, time); no progress yet.
reference_params reference_source_params(const struct reference_source *s,
                                         const perigee_camera *camera, int width, int height);

// sRGB, top row first, 3 bytes a pixel: the mean of samples x samples rays in linear light. The
// params' size is the picture's. ERR_MEMORY, logged.
status reference_picture(const reference_params *params, int samples, uint8_t *rgb);

// Of the samples of pixel (x, y) of a picture `width` pixels wide; the plane is `samples` times as
// large.
double reference_picture_mean(const float *plane, int width, int samples, int x, int y);

// ERR_ARGUMENT, logged: options that need a GPU, or too many rays across.
status reference_check_options(const struct options *o, int width, int height, int samples);

#endif
