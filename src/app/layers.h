// The sources that the options name: presets found by name, and where tiles of servers are kept.
// Main only.
#ifndef PERIGEE_APP_LAYERS_H
#define PERIGEE_APP_LAYERS_H

#include "app/options.h"

// Reads the value of --layer: SOURCE[,height|color][,opacity=0..1]. ERR_ARGUMENT, logged.
status layers_add(struct options *o, const char *name, const char *value);
void layers_deinit(struct options *o);

// Opens the planet `path` with what the options lay over it. A name that is no file and has neither
// dot nor slash is the preset data/sources/NAME.json.
status layers_open_planet(const struct options *o, const char *path, perigee_planet **out);

#endif
