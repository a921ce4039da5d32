// `perigee render --mode reference`: the same outputs as `render`, by the ray caster. Main only.
#ifndef PERIGEE_APP_COMMAND_REFERENCE_H
#define PERIGEE_APP_COMMAND_REFERENCE_H

#include <stdbool.h>

#include "app/options.h"

// The output is checked by the caller; exr: write planes, otherwise a picture.
status command_reference(const struct options *o, bool exr);

#endif
