// Sizes of modes at which all draw as many triangles, or have the same error, in one view. A mode's
// size is that of perigee_view_params_resize. Main only.
#ifndef PERIGEE_APP_COMPARE_EQUAL_H
#define PERIGEE_APP_COMPARE_EQUAL_H

#include "app/compare_side.h"

#define COMPARE_EQUAL_TOLERANCE 0.1 // share by which triangles or error may differ from the goal

// What was chosen. Nothing: size 1, the options' own mesh.
typedef struct compare_size {
    double size;
    bool met;          // the goal, within the tolerance
    char options[160]; // of the program, that make this mesh; "" when none are needed
} compare_size;

// Triangles drawn, or the 99.9 % error without silhouettes, of a mode of size 1; of an error at
// least COMPARE_EQUAL_LEAST_PX, for beyond that the search would be for triangles nobody sees. The
// judge's picture of the camera is there already.
#define COMPARE_EQUAL_LEAST_PX 0.05
status compare_equal_goal(struct compare_side *side, const struct compare_side *judge,
                          struct compare_stage *stage, const perigee_camera *camera, double *goal);

// Gives the side a view of the size that comes nearest to the goal. ERR_TIMEOUT, ERR_MEMORY,
// ERR_GPU, ERR_CANCELLED.
status compare_equal_choose(struct compare_side *side, const struct compare_side *judge,
                            struct compare_stage *stage, const perigee_camera *camera, double goal,
                            compare_size *out);

#endif
