// Names of numbered frames: one "%d" or "%0Nd" in a path, "%%" for a percent sign. Any thread.
#ifndef PERIGEE_APP_FRAME_PATTERN_H
#define PERIGEE_APP_FRAME_PATTERN_H

#include <stddef.h>

#include "base/status.h"

// ERR_ARGUMENT, logged with the pattern, unless it has exactly one number, that in the file's name,
// and ends in .png.
status frame_pattern_check(const char *pattern);

// The path of a frame. The pattern has passed the check. ERR_ARGUMENT, logged, when it is longer
// than size.
status frame_pattern_path(const char *pattern, int frame, char *path, size_t size);

#endif
