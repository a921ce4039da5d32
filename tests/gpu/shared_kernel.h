// Every shared function (shaders/shared) over a list of cases, in the GPU's own floats by readback
// (shaders/shared.comp). Main only, on the thread of the current context.
#ifndef PERIGEE_TESTS_SHARED_KERNEL_H
#define PERIGEE_TESTS_SHARED_KERNEL_H

#include "base/status.h"
#include "geo/test_shared_cases.h"

// As the shader counts them: floats only, in this order.
struct shared_inputs {
    float n, e, v, cb, sb, r, lat, stretch, dlat_db, w;
    float h, tan_y, tan_x;
    struct place_frame_f place;
};

struct shared_outputs {
    float stable[2], exact[2], approx[2], blend[2]; // longitude, latitude from the focus, rad
    float position[3];                              // up, east, north, m
    float atan;                                     // of tan_y / tan_x
};

// The functions' arguments of a case; tan_y and tan_x are 0.
struct shared_inputs shared_inputs_of(const struct shared_case *c);

// Computes all cases. ERR_GPU when the shader does not build.
status shared_kernel_run(const struct shared_inputs *in, struct shared_outputs *out, int count);

#endif
