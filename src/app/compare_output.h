// The files with each pixel's errors, and the picture of a pair. Main only.
#ifndef PERIGEE_APP_COMPARE_OUTPUT_H
#define PERIGEE_APP_COMPARE_OUTPUT_H

#include "app/compare_picture.h"
#include "app/compare_side.h"

// Whether the files that the options name can be made. ERR_IO, ERR_ARGUMENT, logged.
status compare_output_check(const struct options *o);

// Writes what the options ask for of one row: the errors to PREFIX.exr and PREFIX.png (of a flight
// to PREFIX-00012.exr and so on), and the picture, if the row's error is larger than *worst, which
// then is the row's. ERR_IO, ERR_MEMORY, ERR_ARGUMENT, logged.
status compare_output_row(const struct compare_stage *stage, const compare_head *head,
                          const struct compare_side sides[2], const compare_row *row,
                          const compare_maps *maps, double *worst);

#endif
