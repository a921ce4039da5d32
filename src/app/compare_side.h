// One side of a comparison: a mode that renders a camera, or an EXR file that holds its picture.
// Main only.
#ifndef PERIGEE_APP_COMPARE_SIDE_H
#define PERIGEE_APP_COMPARE_SIDE_H

#include "app/compare_report.h"
#include "app/image_exr.h"
#include "app/progress.h"
#include "app/reference_picture.h"
#include "app/session.h"
#include "reference/compare.h"

struct compare_side {
    const char *name;   // as given
    int mode;           // enum perigee_mode or MODE_REFERENCE, -1: a file
    perigee_view *view; // of a mode of perigee_mode, else NULL
    image_exr_file picture;
};

// What the sides share, opened as far as they want it.
struct compare_stage {
    struct options options; // those of the user, without air; a flight's time is put in
    struct session session; // without a view
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

// Opens the planet and what the sides need of it, with `stage->options` set before. Without modes
// there is no planet.
status compare_stage_open(struct compare_stage *stage, struct compare_side *sides, int count);
void compare_stage_close(struct compare_stage *stage); // after its sides

// A view of the side's mode with these parameters, instead of the one it has.
status compare_side_view(struct compare_side *side, const struct compare_stage *stage,
                         const perigee_view_params *params);

// Makes the side's picture of a camera; a file's is there already. ERR_CANCELLED after Ctrl-C.
status compare_side_render(struct compare_side *side, struct compare_stage *stage,
                           const perigee_camera *camera);

// A frame of a side with a view as soon as its data is there, finished but not read.
status compare_side_frame(const struct compare_side *side, const struct compare_stage *stage,
                          const perigee_camera *camera);

compare_picture compare_side_planes(const struct compare_side *side);

// The pictures of both sides, made for this camera. ERR_MEMORY.
status compare_side_judge(const struct compare_side *a, const struct compare_side *b,
                          const struct compare_stage *stage, const perigee_camera *camera,
                          const compare_maps *maps, compare_result *out);

// A row whose places are the map's, but those of the errors where the judge is a file, as it is
// told.
void compare_side_tell(const struct compare_side *judge, const struct compare_stage *stage,
                       compare_row *row);

// The zooms of the heights that the reference's picture shows, NaN when the side is not it.
void compare_side_zooms(const struct compare_side *side, double *low, double *high);

#endif
