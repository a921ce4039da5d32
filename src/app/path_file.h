// A recorded flight in JSON:
//   {"name": "Everest", "fov": 60, "time": "2026-06-21T06:00Z",
//    "keys": [{"time": 0, "lat": 27.5, "lon": 86.9, "alt": 9000, "heading": 0, "pitch": -10,
//    "roll": 0, "fov": 60}, ...]}
// "name", "time" (where the sun stands), "roll" and both "fov" may be left out. Seconds, degrees,
// metres; "alt" is above the ellipsoid, "aboveGround" above the terrain. Main only.
#ifndef PERIGEE_APP_PATH_FILE_H
#define PERIGEE_APP_PATH_FILE_H

#include <stdbool.h>

#include "base/status.h"
#include "geo/flight.h"
#include "perigee.h"

// The least height of a flying camera over the terrain.
#define PATH_CLEARANCE_M 2.0

struct path_key {
    double time_s;
    perigee_camera camera; // alt_m is above the terrain when above_ground
    bool above_ground;
};

struct path_file {
    char name[64];
    char path[256]; // for messages, cut when longer
    bool time_given;
    double unix_time_s;
    struct path_key *keys;
    int count;
};

// ERR_NOT_FOUND, ERR_IO, ERR_FORMAT: one line with file, key and value.
status path_file_load(const char *path, struct path_file *out);
void path_file_deinit(struct path_file *file);

// The flight over a planet: heights above ground become altitudes. ERR_FORMAT, logged, when a key
// lies below the ellipsoid (flights interpolate the logarithm of the altitude).
status path_file_flight(const struct path_file *file, perigee_planet *planet, struct flight **out);

// Where the flight is at a time, never lower than PATH_CLEARANCE_M over the terrain.
status path_file_camera(const struct flight *flight, perigee_planet *planet, double time_s,
                        perigee_camera *out);

#endif
