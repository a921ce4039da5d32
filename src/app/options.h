// The command line as plain values. Every option is a row of one table (option_table.h), from which
// parsing, --help and the checks of the man page come. Main only.
#ifndef PERIGEE_APP_OPTIONS_H
#define PERIGEE_APP_OPTIONS_H

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"
#include "geo/ellipsoid.h"
#include "perigee.h"
#include "planet/import.h"

enum command {
    COMMAND_VIEW,
    COMMAND_RENDER,
    COMMAND_FLY,
    COMMAND_IMPORT,
    COMMAND_INFO,
    COMMAND_COMPARE,
    COMMAND_EXPORT,
    COMMAND_COUNT
};

// "view", "render", ...
const char *command_name(enum command command);

// The command of that name; false when there is none.
bool command_find(const char *name, enum command *out);

enum { OPTIONS_MAX_LAYERS = 15 };

enum option_codec { CODEC_LOSSLESS, CODEC_EXACT, CODEC_BOUNDED };

// What the sizes of modes are chosen for.
enum option_equal { EQUAL_NOTHING, EQUAL_TRIANGLES, EQUAL_ERROR };

struct options {
    enum command command;
    bool help, quiet, verbose;

    const char *planet;                  // NULL: the default Earth
    perigee_planet_params planet_params; // but for the layers' place and the path of the tile cache
    perigee_layer layers[OPTIONS_MAX_LAYERS]; // planet_params.layer_count of them; sources owned
    const char *tile_cache;                   // NULL: the usual place; "none"
    perigee_view_params view_params;
    bool reference;         // --mode reference
    int zoom;               // of the reference's height field, SIGHT_STORED or SIGHT_AUTO
    bool zoom_given;        // --zoom
    double zoom_error_px;   // NaN: not given
    bool bicubic;           // --heights bicubic, of the reference
    bool heights_given;     // --heights
    bool paper;             // --paper: as --quality paper
    const char *shader_dir; // NULL: the built-in shaders

    perigee_camera camera; // members not given are NaN
    double above_ground_m; // NaN: camera.alt_m counts
    bool time_given;       // false: noon at the camera
    double unix_time_s;

    int width, height; // 0: the command's default
    int samples;       // 0: the command's default
    const char *output;
    bool half;
    bool no_wait;
    double timeout_s;
    const char *stats;

    const char *path;
    double fps, start_s, end_s; // end NaN: the flight's end
    const char *contact_sheet;
    int sheet_columns, sheet_rows;
    bool resume;

    const char *side_a, *side_b; // of compare: a mode or a file; side_a NULL with `modes`
    const char *modes;           // of compare: "all" or names with commas; NULL: a pair
    const char *views;           // file of the views to compare at; NULL: none
    int frames;                  // of a flight that are compared
    int repeats;                 // of frames that are timed, -1: not given
    enum option_equal equal;
    double equal_value; // NaN: that of the first mode
    const char *csv, *json_file, *picture;

    import_source *sources; // owned
    int source_count;
    enum tile_layer source_layer; // of the rasters that follow; LAYER_COUNT: not said yet
    const char *source_vertical;  // of the rasters that follow; NULL: as they declare
    int source_priority;          // of the rasters that follow
    int feather_rows;
    double feather_m;
    enum option_codec codec; // of heights
    double max_error;        // of --codec bounded, in metres; NaN: not given
    double quantum;          // of heights, in metres; NaN: not given
    const char *name, *attribution;
    const char
        *body_name; // of --body, NULL when not given; `body_text` holds a name read from a file
    char body_text[64];
    geo_ellipsoid ellipsoid; // zero: WGS84
    double bounds_deg[4];
    bool earth, bathymetry, force, estimate, add;
    const char *atlas_dir;

    bool json;
};

// Parses argv[0..argc), argv[0] being the subcommand's name. ERR_ARGUMENT with one line that names
// option and value. Strings are borrowed from argv. After --help nothing is required any more.
status options_parse(enum command command, int argc, char **argv, struct options *out);
void options_deinit(struct options *options);

// true when any option of the camera was given.
bool options_camera_given(const struct options *options);

#endif
