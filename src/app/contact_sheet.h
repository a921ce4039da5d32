// Small copies of evenly spaced frames on one picture. Main only.
#ifndef PERIGEE_APP_CONTACT_SHEET_H
#define PERIGEE_APP_CONTACT_SHEET_H

#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"

struct contact_sheet;

// A sheet of columns x rows cells, fewer rows when there are fewer frames, each cell at most
// `cell_width` wide with the frames' aspect. Frames never grow: cells are at most as large as they.
struct contact_sheet *contact_sheet_create(int columns, int rows, int cell_width, int frame_width,
                                           int frame_height, int frame_count);
void contact_sheet_destroy(struct contact_sheet **sheet);

// Is this frame on the sheet? The first and the last are; those between are evenly spaced.
bool contact_sheet_wants(const struct contact_sheet *sheet, int frame);

// Puts a frame (3 * width * height bytes, sRGB, top row first) in its cell, box-filtered in linear
// light.
void contact_sheet_add(struct contact_sheet *sheet, int frame, const uint8_t *rgb);

void contact_sheet_size(const struct contact_sheet *sheet, int *width, int *height);
const uint8_t *contact_sheet_pixels(const struct contact_sheet *sheet);

#endif
