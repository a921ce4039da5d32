// Values of options that are more than one number. Each logs one line naming option and value on
// ERR_ARGUMENT.
#ifndef PERIGEE_APP_OPTION_VALUES_H
#define PERIGEE_APP_OPTION_VALUES_H

#include "app/options.h"

// Besides the modes of perigee.h, by the names of --mode.
enum { MODE_REFERENCE = 1000 };

// The enum perigee_mode of that name, or MODE_REFERENCE, -1: none.
int option_mode_find(const char *name);
// The names of perigee.h's modes with commas between them, in text, which is returned.
const char *option_mode_names(char *text, size_t size);

status option_camera(struct options *o, const char *name, const char *value);
status option_time(struct options *o, const char *name, const char *value);
status option_size(struct options *o, const char *name, const char *value);
status option_grid(struct options *o, const char *name, const char *value);
status option_screen_grid(struct options *o, const char *name, const char *value);
status option_transform(struct options *o, const char *name, const char *value);
status option_planar_n(struct options *o, const char *name, const char *value);
status option_planar_form(struct options *o, const char *name, const char *value);
status option_planar_heights(struct options *o, const char *name, const char *value);
status option_quality(struct options *o, const char *name, const char *value);
status option_texels(struct options *o, const char *name, const char *value);
status option_feather(struct options *o, const char *name, const char *value);
status option_codec(struct options *o, const char *name, const char *value);
status option_filter(struct options *o, const char *name, const char *value);
status option_texcoord(struct options *o, const char *name, const char *value);
status option_mode(struct options *o, const char *name, const char *value);
status option_synthesis(struct options *o, const char *name, const char *value);
status option_zoom(struct options *o, const char *name, const char *value);
status option_heights(struct options *o, const char *name, const char *value);
status option_equal(struct options *o, const char *name, const char *value);
status option_levels(struct options *o, const char *name, const char *value);
status option_azimuth_steps(struct options *o, const char *name, const char *value);
status option_rings(struct options *o, const char *name, const char *value);
status option_bytes(struct options *o, const char *name, const char *value);
status option_tile_bytes(struct options *o, const char *name, const char *value);
status option_bounds(struct options *o, const char *name, const char *value);
status option_body(struct options *o, const char *name, const char *value);
status option_height_layer(struct options *o, const char *name, const char *value);
status option_color_layer(struct options *o, const char *name, const char *value);
status option_night_layer(struct options *o, const char *name, const char *value);

// Adds a raster of the layer said last; ERR_ARGUMENT when none was said.
status option_vertical(struct options *o, const char *name, const char *value);
status option_add_source(struct options *o, const char *path);

#endif
