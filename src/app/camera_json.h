// A camera as members of a JSON object: "lat", "lon", one of "alt" (above the ellipsoid) and
// "aboveGround" (above the terrain), "heading", "pitch", and, if wanted, "roll" and "fov". Degrees,
// metres. Main only.
#ifndef PERIGEE_APP_CAMERA_JSON_H
#define PERIGEE_APP_CAMERA_JSON_H

#include "app/json_file.h"
#include "perigee.h"

#define CAMERA_JSON_ALT_MIN 0.5  // m, above the ellipsoid or the terrain
#define CAMERA_JSON_FOV     60.0 // degrees, unless the file says otherwise

// *out holds the field of view for an object without one; alt_m is above the terrain when
// *above_ground. ERR_FORMAT, logged.
status camera_json_read(struct json_place at, const struct cJSON *object, perigee_camera *out,
                        bool *above_ground);

#endif
