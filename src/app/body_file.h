// A body that is not built in: {"name": "Ceres", "equatorialRadius": 482100, "polarRadius":
// 445900}, metres.
#ifndef PERIGEE_APP_BODY_FILE_H
#define PERIGEE_APP_BODY_FILE_H

#include <stddef.h>

#include "base/status.h"
#include "geo/ellipsoid.h"

// ERR_ARGUMENT when there is no such file, ERR_FORMAT when it says something else; one line names
// file and value. `name` is filled with "name", or with the file's own name without folder and
// extension.
status body_file_load(const char *path, geo_ellipsoid *out, char *name, size_t name_size);

#endif
