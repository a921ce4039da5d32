// A planet file as a folder of tiles that any web server can serve, and that source_spec.h reads:
//   planet.json            all of it: TileJSON a layer, with the tiles there are
//   height/Z/ROW/COL.png   terrarium, rounded to 1/256 m; alpha 0: no data
//   color/Z/ROW/COL.jpg    as stored;  night/Z/ROW/COL.jpg
// on the planet's own grid (grid.h). planet.json is written last. Main only; workers inside.
#ifndef PERIGEE_PLANET_EXPORT_H
#define PERIGEE_PLANET_EXPORT_H

#include "planet/planet_file.h"

typedef struct export_params {
    const char *input, *output; // a planet file, a folder
    int threads;                // 0: one for each processor
    bool force;                 // write into a folder that has a planet.json
    // Called on the calling thread, a few times a second; true: stop. May be NULL.
    bool (*progress)(void *user, const char *stage, double done);
    void *user;
} export_params;

typedef struct export_result {
    uint64_t tiles, bytes;
} export_result;

// ERR_CANCELLED; ERR_ARGUMENT, ERR_IO and those of planet_file_open, logged.
status export_run(const export_params *params, export_result *out);

#endif
