// The cameras of a comparison: one by the options, frames of a flight, or a file's views. Main
// only.
#ifndef PERIGEE_APP_COMPARE_CAMERAS_H
#define PERIGEE_APP_COMPARE_CAMERAS_H

#include "app/path_file.h"
#include "app/session.h"
#include "app/views_file.h"

struct compare_cameras {
    const struct options *options;
    const struct session *session;
    struct path_file path;
    struct flight *flight; // NULL: no flight
    struct views_file views;
    int count;
};

// One of them. Without a name of its own: "frame 3" of a flight, "" of the one of the options.
typedef struct compare_place {
    char name[64];
    double time_s; // of the flight
    perigee_camera camera;
} compare_place;

// Reads the file that the options name, before anything slow. Deinit whatever the status.
status compare_cameras_load(struct compare_cameras *c, const struct options *o);

// Over the session's planet; borrows the session. ERR_ARGUMENT, ERR_FORMAT, logged.
status compare_cameras_open(struct compare_cameras *c, const struct session *session);
void compare_cameras_deinit(struct compare_cameras *c);

// The time at which the sun stands, when the flight says one and the options do not.
bool compare_cameras_time(const struct compare_cameras *c, double *unix_time_s);

// Camera i of count; of a flight so many seconds later, or earlier where it ends before.
// ERR_FORMAT, ERR_ARGUMENT, logged, when it stands below the terrain.
status compare_cameras_at(const struct compare_cameras *c, int i, double later_s,
                          compare_place *out);

#endif
