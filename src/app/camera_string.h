// The camera as one line to copy and paste. Any thread.
//   lat,lon,alt[,heading,pitch[,roll[,fov]]]
//   geo:lat,lon[,alt][;heading=..][;pitch=..][;roll=..][;fov=..]       (RFC 5870, with crs=wgs84
//   allowed)
#ifndef PERIGEE_APP_CAMERA_STRING_H
#define PERIGEE_APP_CAMERA_STRING_H

#include <stddef.h>

#include "base/status.h"
#include "perigee.h"

enum { CAMERA_STRING_SIZE = 160 };

// Ranges of the values a user may give, in degrees and metres.
#define CAMERA_ALT_MIN (-12000.0)
#define CAMERA_ALT_MAX 1e10
#define CAMERA_FOV_MIN 0.01
#define CAMERA_FOV_MAX 179.0

// Fills what the text gives and leaves the other members of *camera alone. ERR_ARGUMENT, logged
// with the text and the value, when it is no such line or a value is out of range.
status camera_string_parse(const char *text, perigee_camera *camera);

// The first form, with enough digits to come back to the same picture (1e-9 degrees, millimetres).
void camera_string_format(const perigee_camera *camera, char *text, size_t size);

#endif
