// Pictures of a comparison. Main only.
#ifndef PERIGEE_APP_COMPARE_PICTURE_H
#define PERIGEE_APP_COMPARE_PICTURE_H

#include <stdint.h>

#include "app/compare_report.h"

// The error map, 3 * width * height bytes: ground by |geometric_px| on a logarithmic scale from
// COMPARE_SCALE_LOW to COMPARE_SCALE_HIGH px, the other kinds in one colour each.
#define COMPARE_SCALE_LOW  0.001
#define COMPARE_SCALE_HIGH 10.0
void compare_picture_map(const compare_maps *maps, int width, int height, uint8_t *rgb);

// One PNG: a, b and the error map side by side, the scale, and the table. Panels are made smaller
// by a whole number when wider than 640 px: a and b by the mean in linear light, the map by the
// worst of its pixels. ERR_IO, ERR_MEMORY, logged.
status compare_picture_write(const char *path, const compare_head *head, const compare_row *row,
                             const compare_picture *a, const compare_picture *b,
                             const compare_maps *maps);

#endif
