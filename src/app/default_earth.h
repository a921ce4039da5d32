// The default Earth: made once from the atlas, then found. Main only.
#ifndef PERIGEE_APP_DEFAULT_EARTH_H
#define PERIGEE_APP_DEFAULT_EARTH_H

#include <stddef.h>

#include "app/options.h"

// Path of the default Earth; made first, with a progress bar, when it is not there yet.
status default_earth_find(const struct options *o, char *path, size_t size);

// `perigee import --earth`: makes it at o->output, or at its usual place.
status default_earth_make(const struct options *o);

#endif
