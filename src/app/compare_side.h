// One side of a comparison: a mode that renders a camera, or an EXR file that holds its picture.
// Main only.
#ifndef PERIGEE_APP_COMPARE_SIDE_H
#define PERIGEE_APP_COMPARE_SIDE_H

#include "app/image_exr.h"
#include "app/progress.h"
#include "app/reference_picture.h"
#include "app/session.h"
#include "reference/compare.h"

struct compare_side {
    const char *name; // as given
    int mode;         // enum perigee_mode or MODE_REFERENCE, -1: a file
    image_exr_file picture;
};

// What the modes need, opened as far as the sides want it.
struct compare_stage {
    struct options options; // those of the user, without air; a flight's time is put in
    struct session session; // its view renders the first mode wanted
    perigee_view *other;    // and this one a second, NULL: there is none
    struct reference_source source;
    int width, height;
    int samples; // colours are the mean of so many by so many a pixel
    struct progress progress;
    double done, share; // of the work: what is done, and what the picture now made is of it
};

// A mode's name, "reference", or the name of an EXR file, which is read. ERR_ARGUMENT, logged, when
// it is none of these.
status compare_side_open(const char *name, struct compare_side *out);
void compare_side_close(struct compare_side *side);

// Opens the planet and what the modes of the sides need of it, with `stage->options` set before. A
// stage without modes has no planet.
status compare_stage_open(struct compare_stage *stage, const struct compare_side sides[2]);
void compare_stage_close(struct compare_stage *stage);

// Makes the side's picture of a camera; a file's is there already. ERR_CANCELLED after Ctrl-C.
status compare_side_render(struct compare_side *side, struct compare_stage *stage,
                           const perigee_camera *camera);

compare_picture compare_side_planes(const struct compare_side *side);

#endif
