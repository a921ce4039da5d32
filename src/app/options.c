#include "app/options.h"

#include <ctype.h>
#include <getopt.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "app/layers.h"
#include "app/number.h"
#include "app/option_table.h"
#include "app/option_values.h"
#include "base/log.h"
#include "base/memory.h"
#include "reference/sight.h"

enum { MAX_OPTIONS = 96, FIRST_LONG = 256, FPS_DEFAULT = 30 };

static const char *const names[COMMAND_COUNT] = {"view", "render",  "fly",   "import",
                                                 "info", "compare", "export"};

const char *command_name(enum command command)
{
    return names[command];
}

bool command_find(const char *name, enum command *out)
{
    for (int i = 0; i < COMMAND_COUNT; i++) {
        if (strcmp(name, names[i]) != 0) continue;
        *out = (enum command)i;
        return true;
    }
    return false;
}

// What getopt_long wants: val is FIRST_LONG + the row for every option, the letters map to rows by
// find_letter.
struct getopt_tables {
    struct option longs[MAX_OPTIONS + 1];
    char shorts[2 * MAX_OPTIONS + 3];
};

static bool takes_value(const struct option_spec *spec)
{
    return spec->kind != OPTION_FLAG && spec->kind != OPTION_UNFLAG &&
           spec->kind != OPTION_OPTIONAL;
}

static void build_tables(enum command command, struct getopt_tables *t)
{
    int count = 0;
    char *s = t->shorts;
    *s++ = '-'; // arguments that are no options come in their order, as option 1
    *s++ = ':';
    for (int i = 0; i < option_count; i++) {
        const struct option_spec *spec = &option_table[i];
        if (!(spec->commands & (1u << command))) continue;
        int has = takes_value(spec)               ? required_argument
                  : spec->kind == OPTION_OPTIONAL ? optional_argument
                                                  : no_argument;
        t->longs[count++] = (struct option){spec->name, has, NULL, FIRST_LONG + i};
        if (!spec->letter) continue;
        *s++ = spec->letter;
        if (takes_value(spec)) *s++ = ':';
    }
    t->longs[count] = (struct option){0};
    *s = '\0';
}

static const struct option_spec *find_letter(int letter)
{
    for (int i = 0; i < option_count; i++)
        if (option_table[i].letter == letter) return &option_table[i];
    return NULL;
}

static const struct option_spec *find_option(int value)
{
    return value >= FIRST_LONG ? &option_table[value - FIRST_LONG] : find_letter(value);
}

static status apply_number(const struct option_spec *spec, struct options *o, const char *value)
{
    double x = NAN;
    long long n = 0;
    bool whole = spec->kind == OPTION_INTEGER;
    bool good = whole ? number_parse_integer(value, &n) : number_parse(value, &x);
    if (!good) {
        log_error("--%s %s: not a %s", spec->name, value,
                  whole ? "whole number" : "decimal number");
        return ERR_ARGUMENT;
    }
    if (whole) x = (double)n;
    if (x < spec->low || x > spec->high) {
        log_error("--%s %s: not in %.10g..%.10g", spec->name, value, spec->low, spec->high);
        return ERR_ARGUMENT;
    }
    void *at = (char *)o + spec->offset;
    if (whole) *(int *)at = (int)n;
    else *(double *)at = x;
    return OK;
}

static status apply(const struct option_spec *spec, struct options *o, const char *value)
{
    void *at = (char *)o + spec->offset;
    switch (spec->kind) {
    case OPTION_FLAG:
        *(bool *)at = true;
        return OK;
    case OPTION_UNFLAG:
        *(bool *)at = false;
        return OK;
    case OPTION_NUMBER:
    case OPTION_INTEGER:
        return apply_number(spec, o, value);
    case OPTION_VALUE:
    case OPTION_OPTIONAL:
        return spec->apply(o, spec->name, value);
    case OPTION_TEXT:
        if (!value[0]) {
            log_error("--%s: the value is empty", spec->name);
            return ERR_ARGUMENT;
        }
        *(const char **)at = value;
    }
    return OK;
}

static status argument(struct options *o, const char *text)
{
    if (o->command == COMMAND_IMPORT) return option_add_source(o, text);
    if (o->planet) {
        log_error("unexpected argument '%s'", text);
        return ERR_ARGUMENT;
    }
    o->planet = text;
    return OK;
}

static status report_unknown(const struct options *o, char **argv)
{
    const char *command = command_name(o->command);
    if (optopt >= FIRST_LONG) log_error("--%s takes no value", find_option(optopt)->name);
    else if (optopt)
        log_error("unknown option '-%c' (see perigee %s --help)", isprint(optopt) ? optopt : '?',
                  command);
    else log_error("unknown option '%s' (see perigee %s --help)", argv[optind - 1], command);
    return ERR_ARGUMENT;
}

static status parse_all(struct options *o, int argc, char **argv)
{
    struct getopt_tables tables;
    build_tables(o->command, &tables);
    optind = 0;
    opterr = 0;
    status s = OK;
    int c;
    while (!s && (c = getopt_long(argc, argv, tables.shorts, tables.longs, NULL)) != -1) {
        if (c == 1) s = argument(o, optarg);
        else if (c == '?') s = report_unknown(o, argv);
        else if (c == ':') {
            log_error("--%s: the value is missing", find_option(optopt)->name);
            s = ERR_ARGUMENT;
        } else s = apply(find_option(c), o, optarg);
    }
    while (!s && optind < argc) s = argument(o, argv[optind++]);
    return s;
}

static status require(const struct options *o, const char *value, const char *option)
{
    if (value) return OK;
    log_error("%s: %s is missing", command_name(o->command), option);
    return ERR_ARGUMENT;
}

static bool has_bounds(const struct options *o)
{
    for (int i = 0; i < 4; i++)
        if (o->bounds_deg[i] != 0) return true;
    return false;
}

static status check_import(const struct options *o)
{
    if (o->earth && o->estimate) {
        log_error("import: --estimate is for rasters, not --earth");
        return ERR_ARGUMENT;
    }
    if (o->earth && (o->source_count > 0 || o->body_name || o->name || o->attribution)) {
        log_error("import: --earth makes the default Earth and takes no rasters, body, name or "
                  "attribution");
        return ERR_ARGUMENT;
    }
    if (o->earth && (o->codec != CODEC_LOSSLESS || !isnan(o->quantum) || has_bounds(o))) {
        log_error(
            "import: --earth has its own codec and covers the globe: no --codec, --quantum or "
            "--bounds");
        return ERR_ARGUMENT;
    }
    if (!o->earth && (o->bathymetry || o->atlas_dir)) {
        log_error("import: --bathymetry and --atlas go with --earth");
        return ERR_ARGUMENT;
    }
    if (!o->earth && o->source_count == 0) {
        log_error("import: no raster given (--height, --color, --night or --earth)");
        return ERR_ARGUMENT;
    }
    if (o->add && (o->earth || o->body_name || o->codec != CODEC_LOSSLESS || !isnan(o->quantum))) {
        log_error(
            "import: --add takes body and codec from the planet: no --earth, --body, --codec or "
            "--quantum");
        return ERR_ARGUMENT;
    }
    if ((o->codec == CODEC_BOUNDED) != !isnan(o->max_error)) {
        log_error("import: --codec bounded and --max-error go together");
        return ERR_ARGUMENT;
    }
    if (!isnan(o->quantum) && o->codec != CODEC_LOSSLESS) {
        log_error("--quantum %g: only with --codec lossless", o->quantum);
        return ERR_ARGUMENT;
    }
    return o->earth || o->estimate ? OK : require(o, o->output, "-o");
}

static status refuse_with(const char *first, const char *second)
{
    log_error("compare: %s: not with %s", first, second);
    return ERR_ARGUMENT;
}

// What belongs to one pair only, or to several modes only.
static status check_modes(const struct options *o)
{
    if (!o->modes) {
        const char *lonely = o->views                    ? "--views"
                             : o->equal != EQUAL_NOTHING ? "--equal"
                             : o->repeats >= 0           ? "--repeats"
                             : o->fps != FPS_DEFAULT     ? "--fps"
                                                         : NULL;
        if (!lonely) return OK;
        log_error("compare: %s goes with --modes", lonely);
        return ERR_ARGUMENT;
    }
    if (o->side_a) return refuse_with("--modes", "--a");
    if (o->output) return refuse_with("--modes", "-o");
    if (o->picture) return refuse_with("--modes", "--picture");
    if (o->samples > 1) return refuse_with("--modes", "--samples");
    if (o->views && o->path) return refuse_with("--views", "--path");
    if (o->views && options_camera_given(o))
        return refuse_with("--views", "--camera, --lat and so on: the file has the cameras");
    return OK;
}

static status check_compare(const struct options *o)
{
    status s = check_modes(o);
    if (s) return s;
    if (o->path && options_camera_given(o)) {
        log_error("--path %s: the flight has the camera: no --camera, --lat and so on", o->path);
        return ERR_ARGUMENT;
    }
    if (!o->path && (o->frames > 0 || o->start_s > 0 || !isnan(o->end_s))) {
        log_error("compare: --frames, --start and --end go with --path");
        return ERR_ARGUMENT;
    }
    return OK;
}

static bool uses_reference(const struct options *o)
{
    if (o->command != COMMAND_COMPARE) return o->reference;
    return (o->side_a && option_mode_find(o->side_a) == MODE_REFERENCE) ||
           option_mode_find(o->side_b) == MODE_REFERENCE;
}

static status check_reference(const struct options *o)
{
    bool reference = uses_reference(o);
    if (o->heights_given && !reference) {
        log_error("--heights: only with --mode reference, or with reference as a side of compare");
        return ERR_ARGUMENT;
    }
    if (o->zoom_given && !reference) {
        log_error("--zoom: only with --mode reference, or with reference as a side of compare");
        return ERR_ARGUMENT;
    }
    if (isnan(o->zoom_error_px) || (reference && o->zoom == SIGHT_AUTO)) return OK;
    log_error("--zoom-error %g: only with the reference and --zoom auto", o->zoom_error_px);
    return ERR_ARGUMENT;
}

static status check(const struct options *o)
{
    status s = OK;
    if (!isnan(o->above_ground_m) && !isnan(o->camera.alt_m)) {
        log_error("--alt and --above-ground: give one of them");
        return ERR_ARGUMENT;
    }
    if (o->end_s < o->start_s) {
        log_error("--end %g: before --start %g", o->end_s, o->start_s);
        return ERR_ARGUMENT;
    }
    const perigee_view_params *v = &o->view_params;
    if (o->paper + (v->quality != PERIGEE_QUALITY_DEFAULT) + (v->error_px > 0) > 1) {
        log_error("--paper, --quality and --error: give one of them");
        return ERR_ARGUMENT;
    }
    if (!s) s = check_reference(o);
    if (s) return s;
    if (o->command == COMMAND_RENDER) s = require(o, o->output, "-o");
    if (o->command == COMMAND_FLY) {
        s = require(o, o->path, "--path");
        if (!s) s = require(o, o->output, "-o");
    }
    if (o->command == COMMAND_IMPORT) s = check_import(o);
    if (o->command == COMMAND_EXPORT) s = require(o, o->output, "-o");
    if (o->command == COMMAND_COMPARE) s = check_compare(o);
    return s;
}

status options_parse(enum command command, int argc, char **argv, struct options *out)
{
    *out = (struct options){
        .command = command,
        .camera = {NAN, NAN, NAN, NAN, NAN, NAN, NAN},
        .above_ground_m = NAN,
        .timeout_s = 60,
        .zoom = SIGHT_AUTO,
        .zoom_error_px = NAN,
        .fps = FPS_DEFAULT,
        .end_s = NAN,
        .sheet_columns = 5,
        .sheet_rows = 4,
        .side_b = "reference",
        .repeats = -1,
        .equal_value = NAN,
        .source_layer = LAYER_COUNT,
        .feather_rows = FEATHER_ROWS,
        .feather_m = FEATHER_AUTO,
        .quantum = NAN,
        .max_error = NAN,
        .sources = NEW_ARRAY(import_source, (size_t)argc + 1),
    };
    status s = parse_all(out, argc, argv);
    if (!s && !out->help) s = check(out);
    if (!out->modes && !out->side_a) out->side_a = perigee_mode_name(PERIGEE_MODE_SPHERICAL);
    if (out->paper) out->view_params.quality = PERIGEE_QUALITY_PAPER;
    if (s) options_deinit(out);
    return s;
}

void options_deinit(struct options *o)
{
    layers_deinit(o);
    free(o->sources);
    o->sources = NULL;
    o->source_count = 0;
}

bool options_camera_given(const struct options *o)
{
    const perigee_camera *c = &o->camera;
    return !isnan(c->lat_deg) || !isnan(c->lon_deg) || !isnan(c->alt_m) || !isnan(c->heading_deg) ||
           !isnan(c->pitch_deg) || !isnan(c->roll_deg) || !isnan(c->fov_deg) ||
           !isnan(o->above_ground_m);
}
