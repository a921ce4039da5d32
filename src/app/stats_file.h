// What each frame cost: one JSON object a line. Main only.
#ifndef PERIGEE_APP_STATS_FILE_H
#define PERIGEE_APP_STATS_FILE_H

#include <stdio.h>

#include "app/session.h"
#include "base/status.h"

struct stats_file {
    const char *path;
    FILE *file;                // NULL: nothing is written
    uint64_t uploaded, placed; // totals at the line before
};

// path NULL: every call below does nothing. ERR_IO, logged.
status stats_file_open(struct stats_file *f, const char *path);

// "bytes_uploaded" and "vertices_placed" count since the line before, the waiting for data
// included. camera: of the session's view, its place the map's.
void stats_file_add(struct stats_file *f, const struct session *session, int frame, double time_s,
                    const perigee_camera *camera);

// ERR_IO, logged, when any line could not be written.
status stats_file_close(struct stats_file *f);

#endif
