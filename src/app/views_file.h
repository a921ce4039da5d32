// A set of views in JSON, to measure at:
//   {"name": "Accuracy", "fov": 90,
//    "views": [{"name": "orbit, Himalaya", "lat": 28, "lon": 86.9, "aboveGround": 4e5, "heading":
//    0, "pitch": -90, "roll": 0, "fov": 90}, ...]}
// "name" of the file, "roll" and both "fov" may be left out; the rest of a view as camera_json.h
// has it. Main only.
#ifndef PERIGEE_APP_VIEWS_FILE_H
#define PERIGEE_APP_VIEWS_FILE_H

#include <stdbool.h>

#include "base/status.h"
#include "perigee.h"

typedef struct named_view {
    char name[64];
    perigee_camera camera; // alt_m is above the terrain when above_ground
    bool above_ground;
} named_view;

struct views_file {
    char name[64];
    char path[256]; // for messages, cut when longer
    named_view *views;
    int count;
};

// ERR_NOT_FOUND, ERR_IO, ERR_FORMAT: one line with file, view and value.
status views_file_load(const char *path, struct views_file *out);
void views_file_deinit(struct views_file *file);

#endif
