// Modes side by side: each judged by the same picture at one camera, at a file's views, or along a
// flight. Main only.
#ifndef PERIGEE_APP_COMPARE_MODES_H
#define PERIGEE_APP_COMPARE_MODES_H

#include "app/options.h"

// perigee compare --modes. ERR_CANCELLED after Ctrl-C, with the tables of what is done written.
status compare_modes(const struct options *options);

#endif
