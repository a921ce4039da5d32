// Where the program's own files are: its data and the default Earth. Main only.
#ifndef PERIGEE_APP_DATA_FILES_H
#define PERIGEE_APP_DATA_FILES_H

#include <stddef.h>

#include "base/status.h"

// The first that exists of NAME in $PERIGEE_DATA_DIR, ../share/perigee beside the program, the
// source tree it was built from, and where it was to be installed. ERR_NOT_FOUND, logged with the
// name.
status data_file_find(const char *name, char *path, size_t size);

// $PERIGEE_EARTH, else ${XDG_DATA_HOME:-~/.local/share}/perigee/earth.planet. ERR_NOT_FOUND,
// logged, without a home.
status data_earth_path(char *path, size_t size);

#endif
