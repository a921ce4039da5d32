// What a window sample has to be, from the words of window.h and grid.h and the fake field alone:
// shares no code with the rooms it checks.
#ifndef PERIGEE_TESTS_ORACLE_H
#define PERIGEE_TESTS_ORACLE_H

#include <stdint.h>

// Equator-width tiles merged into one in a tile row.
int64_t oracle_coalesce(int zoom, int64_t tile_row);

// Samples [col0, col1) of a row of windows of `cols` columns and this share. Heights are exact;
// colours are before rounding, in encoded units.
void oracle_heights(int cols, int zoom, int share, int64_t row, int64_t col0, int64_t col1,
                    float *out);
void oracle_colors(int cols, int zoom, int share, int64_t row, int64_t col0, int64_t col1,
                   double (*out)[4]);

#endif
