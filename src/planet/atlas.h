// The relief of Debian's marble-qt-data as heights: 10800 x 5400 greys of 8 bits become metres
// above mean sea level.
//
// A grey g stands for the interval between the midpoints from its metres to its neighbours' in the
// table; 96 and below end at 0, 97 and above begin there. The heights are the smoothest found
// inside these intervals, so that steps between greys vanish on slopes and plains while coasts stay
// where they are; a summit keeps at least its table value, a pit at most: a grey above (below) its
// eight neighbours and by two greys above (below) their mean.
// The greys passed through JPEG: they are off by one or two, so the true height often lies in a
// neighbour's interval (of a 2' relief of another make only 20 to 35 % of the samples lie in their
// own grey's). The result bounds the distance to the data that is there, not to the truth, which
// tests/planet/test_import_earth.c measures.
#ifndef PERIGEE_PLANET_ATLAS_H
#define PERIGEE_PLANET_ATLAS_H

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

enum {
    ATLAS_TILE = 675,
    ATLAS_COLS = 16,
    ATLAS_ROWS = 8,
    ATLAS_WIDTH = ATLAS_COLS * ATLAS_TILE,
    ATLAS_HEIGHT = ATLAS_ROWS * ATLAS_TILE,
    ATLAS_SEA_GREY = 96, // the highest grey below sea level
    // What an ocean reaches and no hollow on land does: the Black Sea, the shallowest basin that
    // stands alone, has grey 45 (-2879 m), the Dead Sea 54.
    ATLAS_DEEP_GREY = 46,
    // Straits that a sample of 2' closes: the Dardanelles and the Rion strait take 2 samples; with
    // 3 the ocean would reach the Salton Sea, Lake Assal and the Danakil.
    ATLAS_STRAIT = 2,
};

// metres[g] of the table, strictly usable as an order: not falling. low, high: the interval of g.
typedef struct atlas_table {
    float metres[256], low[256], high[256];
} atlas_table;

// Reads "grey,metres,..." rows, # comments. Logs; ERR_NOT_FOUND, ERR_FORMAT (a grey is missing, or
// metres fall).
status atlas_read_table(const char *csv, atlas_table *out);

// Reads one tile of <dir>/earth/srtm/3, ATLAS_TILE x ATLAS_TILE greys, into the global grid. Any
// thread.
status atlas_read_tile(const char *dir, int row, int col, unsigned char *greys);

// Path of that tile; free it.
char *atlas_tile_path(const char *dir, int row, int col);

// Marks the ocean with 1 in sea (width * height bytes), all else with 0: samples at or below
// ATLAS_SEA_GREY that are joined to one at or below `deep_grey`, over edges, across the left and
// right border, and over straits: land of up to `gap` samples. ERR_MEMORY.
status atlas_find_sea(const unsigned char *greys, int width, int height, int deep_grey, int gap,
                      unsigned char *sea);

// Heights of the greys as above; where `sea` (may be NULL) is 1 exactly 0. The grid closes on
// itself from left to right. Runs on `threads` threads (0: one for each processor). progress(user,
// share) may be NULL; true stops: ERR_CANCELLED.
typedef struct atlas_params {
    const unsigned char *greys, *sea;
    int width, height;
    const atlas_table *table;
    int threads;
    bool (*progress)(void *user, double done);
    void *user;
} atlas_params;
status atlas_make_heights(const atlas_params *params, float *heights);

#endif
