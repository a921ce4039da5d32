#include "app/command.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "app/compare_picture.h"
#include "app/compare_report.h"
#include "app/compare_side.h"
#include "app/interrupt.h"
#include "app/option_values.h"
#include "app/output_file.h"
#include "app/path_file.h"
#include "base/log.h"
#include "base/memory.h"

enum { WIDTH = 1280, HEIGHT = 960, FRAMES = 10 };

struct contest {
    const struct options *options;
    struct compare_side sides[2];
    struct compare_stage stage;
    perigee_camera camera;
    bool files; // a side is one, which has the camera
    char color_note[160];
    struct path_file path;
    struct flight *flight; // NULL: one still
    int frames;
    compare_head head;
    compare_row *rows;
    int done;     // rows that are made
    double worst; // 99.9 % of the frame that the picture shows
    compare_maps maps;
};

static bool is_file(const struct compare_side *side)
{
    return side->mode < 0;
}

static status refuse_file(const struct compare_side *side, const char *what)
{
    log_error("%s: %s", side->name, what);
    return ERR_ARGUMENT;
}

// What two cameras differ in, NULL: nothing. Files keep all bits.
static const char *camera_difference(const perigee_camera *a, const perigee_camera *b)
{
    if (a->lat_deg != b->lat_deg) return "camera.lat";
    if (a->lon_deg != b->lon_deg) return "camera.lon";
    if (a->alt_m != b->alt_m) return "camera.alt";
    if (a->heading_deg != b->heading_deg) return "camera.heading";
    if (a->pitch_deg != b->pitch_deg) return "camera.pitch";
    if (a->roll_deg != b->roll_deg) return "camera.roll";
    return a->fov_deg != b->fov_deg ? "camera.fov" : NULL;
}

static status take_file(struct contest *c, const struct compare_side *side)
{
    const struct options *o = c->options;
    const image_exr_file *p = &side->picture;
    if (c->stage.samples > 1) return refuse_file(side, "has its colours: no --samples");
    if (!p->has_camera) return refuse_file(side, "no attributes camera.lat and so on");
    if (o->path)
        return refuse_file(side, "a picture of one camera cannot be compared along --path");
    if (options_camera_given(o))
        return refuse_file(side, "the camera is that of the file: no --camera, --lat and so on");
    if (o->width && (o->width != p->width || o->height != p->height)) {
        log_error("--size %dx%d: %s has %dx%d pixels", o->width, o->height, side->name, p->width,
                  p->height);
        return ERR_ARGUMENT;
    }
    c->files = true;
    c->camera = p->camera;
    c->stage.width = p->width;
    c->stage.height = p->height;
    return OK;
}

static status check_pair(const struct compare_side *a, const struct compare_side *b)
{
    if (!is_file(a) || !is_file(b)) return OK;
    if (a->picture.width != b->picture.width || a->picture.height != b->picture.height) {
        log_error("%s has %dx%d pixels, %s %dx%d", a->name, a->picture.width, a->picture.height,
                  b->name, b->picture.width, b->picture.height);
        return ERR_ARGUMENT;
    }
    const char *differs = camera_difference(&a->picture.camera, &b->picture.camera);
    if (differs) {
        log_error("%s and %s: not of one camera: they differ in %s", a->name, b->name, differs);
        return ERR_ARGUMENT;
    }
    return OK;
}

static status open_sides(struct contest *c)
{
    const char *const names[2] = {c->options->side_a, c->options->side_b};
    status s = OK;
    c->stage.width = c->options->width ? c->options->width : WIDTH;
    c->stage.height = c->options->height ? c->options->height : HEIGHT;
    c->stage.samples = c->options->samples ? c->options->samples : 1;
    for (int i = 0; i < 2 && !s; i++) {
        s = compare_side_open(names[i], &c->sides[i]);
        if (!s && is_file(&c->sides[i])) s = take_file(c, &c->sides[i]);
    }
    if (!s)
        s = reference_check_options(c->options, c->stage.width, c->stage.height, c->stage.samples);
    return s ? s : check_pair(&c->sides[0], &c->sides[1]);
}

// Pictures of another planet are worth a warning only: names can be changed.
static void check_planet(const struct contest *c)
{
    for (int i = 0; i < 2; i++) {
        const char *name = c->sides[i].picture.planet, *other = c->head.planet;
        if (is_file(&c->sides[i]) && other[0] && strcmp(name, other) != 0)
            log_warn("%s: a picture of '%s', not of '%s'", c->sides[i].name, name, other);
    }
}

static status open_flight(struct contest *c)
{
    const struct options *o = c->options;
    status s = path_file_flight(&c->path, c->stage.session.planet, &c->flight);
    if (s) return s;
    double duration = flight_duration_s(c->flight);
    if (o->start_s > duration) {
        log_error("--start %g: %s ends at %g s", o->start_s, o->path, duration);
        return ERR_ARGUMENT;
    }
    if (c->path.time_given && !o->time_given) {
        c->stage.options.time_given = true;
        c->stage.options.unix_time_s = c->path.unix_time_s;
    }
    c->frames = o->frames > 0 ? o->frames : FRAMES;
    return OK;
}

static double frame_time(const struct contest *c, int frame)
{
    double duration = flight_duration_s(c->flight), end = c->options->end_s;
    if (isnan(end) || end > duration) end = duration;
    double start = c->options->start_s;
    return c->frames > 1 ? start + (end - start) * frame / (c->frames - 1) : start;
}

static status take_maps(struct contest *c)
{
    size_t pixels = (size_t)c->stage.width * (size_t)c->stage.height;
    float *f = calloc(pixels, 3 * sizeof *f);
    unsigned char *kind = calloc(pixels, 1);
    c->maps = (compare_maps){f, f ? f + pixels : NULL, f ? f + 2 * pixels : NULL, kind};
    if (f && kind) return OK;
    log_error("compare: out of memory for %dx%d pixels", c->stage.width, c->stage.height);
    return ERR_MEMORY;
}

static void write_color_note(struct contest *c)
{
    int n = c->stage.samples;
    const char *note = c->files ? "colours of files are compared as they are, with air or without; "
                                  "modes render without"
                                : "colour is compared without air";
    if (n == 1) snprintf(c->color_note, sizeof c->color_note, "%s", note);
    else
        snprintf(c->color_note, sizeof c->color_note, "%s, the mean of %d x %d samples a pixel",
                 note, n, n);
}

static status open_contest(struct contest *c)
{
    status s = c->options->path ? path_file_load(c->options->path, &c->path) : OK;
    if (!s) s = open_sides(c);
    if (!s) s = compare_stage_open(&c->stage, c->sides);
    const struct session *session = &c->stage.session;
    if (s) return s;
    c->head = (compare_head){.a = c->sides[0].name,
                             .b = c->sides[1].name,
                             .planet = session->planet ? session->info.name : "",
                             .width = c->stage.width,
                             .height = c->stage.height,
                             .flight = c->options->path != NULL,
                             .bicubic = c->options->bicubic,
                             .color_note = c->color_note};
    write_color_note(c);
    check_planet(c);
    c->frames = 1;
    if (c->options->path) s = open_flight(c);
    else if (!c->files) s = session_camera(session, &c->camera);
    else if (session->planet) s = session_place(session, &c->camera);
    if (!s) s = take_maps(c);
    c->rows = NEW_ARRAY(compare_row, (size_t)c->frames);
    return s;
}

static void close_contest(struct contest *c)
{
    for (int i = 0; i < 2; i++) compare_side_close(&c->sides[i]);
    compare_stage_close(&c->stage);
    flight_destroy(&c->flight);
    path_file_deinit(&c->path);
    free(c->maps.geometric_px);
    free(c->maps.kind);
    free(c->rows);
}

// PREFIX.exr, or PREFIX-00012.exr of a flight.
static status output_name(const struct contest *c, const compare_row *row, const char *extension,
                          char path[OUTPUT_PATH_SIZE])
{
    const char *prefix = c->options->output;
    int length = c->flight
                     ? snprintf(path, OUTPUT_PATH_SIZE, "%s-%05d%s", prefix, row->frame, extension)
                     : snprintf(path, OUTPUT_PATH_SIZE, "%s%s", prefix, extension);
    if (length < OUTPUT_PATH_SIZE - 16) return OK;
    log_error("-o %.80s...: too long", prefix);
    return ERR_ARGUMENT;
}

static status write_map(const struct contest *c, const char *path)
{
    static const struct image_text texts[] = {{"Software", "Perigee"}};
    int width = c->stage.width, height = c->stage.height;
    uint8_t *rgb = calloc((size_t)width * (size_t)height, 3);
    status s = ERR_MEMORY;
    if (rgb) {
        compare_picture_map(&c->maps, width, height, rgb);
        s = image_png_write(path, width, height, rgb, texts, 1);
    } else log_error("%s: out of memory", path);
    free(rgb);
    return s;
}

static status write_difference(const struct contest *c, const compare_row *row, const char *path)
{
    size_t pixels = row->result.pixels;
    float *kind = calloc(pixels, sizeof *kind);
    if (!kind) {
        log_error("%s: out of memory", path);
        return ERR_MEMORY;
    }
    for (size_t i = 0; i < pixels; i++) kind[i] = c->maps.kind[i];
    const image_exr_plane planes[] = {{"depth_m", c->maps.depth_m},
                                      {"geometric_px", c->maps.geometric_px},
                                      {"kind", kind},
                                      {"silhouette_px", c->maps.silhouette_px}};
    image_exr about = {.width = c->stage.width,
                       .height = c->stage.height,
                       .camera = row->camera,
                       .planet = c->head.planet,
                       .attribution = c->stage.session.info.attribution};
    status s = image_exr_write_planes(path, &about, planes, sizeof planes / sizeof planes[0]);
    free(kind);
    return s;
}

// The picture is that of the frame with the largest error.
static status write_pictures(struct contest *c, const compare_row *row)
{
    const struct options *o = c->options;
    char path[OUTPUT_PATH_SIZE];
    compare_picture a = compare_side_planes(&c->sides[0]), b = compare_side_planes(&c->sides[1]);
    double worst = row->result.geometric_px.rank_999;
    status s = OK;
    if (o->picture && (row->frame == 0 || worst > c->worst)) {
        s = compare_picture_write(o->picture, &c->head, row, &a, &b, &c->maps);
        c->worst = isnan(worst) ? -1 : worst;
    }
    if (!o->output) return s;
    if (!s) s = output_name(c, row, ".exr", path);
    if (!s) s = write_difference(c, row, path);
    if (!s) s = output_name(c, row, ".png", path);
    return s ? s : write_map(c, path);
}

// The zooms of the heights that side b was cast against.
static void find_zooms(const struct contest *c, compare_row *row)
{
    const float *level = c->sides[1].mode == MODE_REFERENCE ? c->sides[1].picture.level : NULL;
    row->zoom_low = row->zoom_high = NAN;
    for (size_t i = 0; level && i < row->result.pixels; i++) {
        if (level[i] < 0) continue;
        row->zoom_low = fmin(row->zoom_low, level[i]);
        row->zoom_high = fmax(row->zoom_high, level[i]);
    }
}

static status compare_frame(struct contest *c, int frame)
{
    compare_row *row = &c->rows[frame];
    *row = (compare_row){.frame = frame, .camera = c->camera};
    status s = OK;
    if (c->flight) {
        row->time_s = frame_time(c, frame);
        s = path_file_camera(c->flight, c->stage.session.planet, row->time_s, &row->camera);
    }
    for (int i = 0; i < 2 && !s; i++) {
        c->stage.done = (frame + 0.5 * i) / c->frames;
        c->stage.share = 0.5 / c->frames;
        s = compare_side_render(&c->sides[i], &c->stage, &row->camera);
    }
    const perigee_camera *p = &row->camera;
    compare_params params = {
        // No measure depends on its size: only directions are taken.
        .ellipsoid = c->stage.options.planet_params.flat ? geo_plane_of(GEO_WGS84) : GEO_WGS84,
        .camera = {p->lat_deg, p->lon_deg, p->alt_m, p->heading_deg, p->pitch_deg, p->roll_deg,
                   p->fov_deg},
        .width = c->stage.width,
        .height = c->stage.height,
        .a = compare_side_planes(&c->sides[0]),
        .b = compare_side_planes(&c->sides[1])};
    if (!s) s = compare_pictures(&params, &c->maps, &row->result);
    if (s) return s;
    c->done = frame + 1;
    find_zooms(c, row);
    return write_pictures(c, row);
}

static status compare_frames(struct contest *c)
{
    status s = OK;
    interrupt_catch();
    progress_start(&c->stage.progress, stderr, c->options->quiet);
    for (int frame = 0; frame < c->frames && !s; frame++) {
        s = compare_frame(c, frame);
        if (s || !c->flight) continue;
        progress_clear_line();
        compare_report_line(stdout, &c->rows[frame]);
    }
    progress_finish(&c->stage.progress);
    if (s == ERR_CANCELLED)
        log_error("interrupted after %d of %d frames; the tables hold these", c->done, c->frames);
    return s;
}

static status write_tables(const struct contest *c)
{
    const struct options *o = c->options;
    status s = OK;
    if (c->done == 0) return OK;
    if (!c->flight) compare_report_print(stdout, &c->head, &c->rows[0]);
    if (o->csv) s = compare_report_csv(o->csv, c->rows, c->done);
    if (o->json_file && !s) s = compare_report_json(o->json_file, &c->head, c->rows, c->done);
    return s;
}

static status check_outputs(const struct options *o)
{
    const char *const files[] = {o->csv, o->json_file, o->picture};
    status s = OK;
    if (o->picture && !output_has_extension(o->picture, ".png")) {
        log_error("--picture %s: not a .png", o->picture);
        return ERR_ARGUMENT;
    }
    for (int i = 0; i < 3 && !s; i++)
        if (files[i]) s = output_check(files[i]);
    char probe[OUTPUT_PATH_SIZE];
    if (s || !o->output) return s;
    if (snprintf(probe, sizeof probe, "%s.exr", o->output) >= (int)sizeof probe - 16) {
        log_error("-o %.80s...: too long", o->output);
        return ERR_ARGUMENT;
    }
    snprintf(probe + strlen(o->output), 5, ".png");
    if (o->picture && strcmp(probe, o->picture) == 0) {
        log_error("-o %s: its error map %s would be the --picture", o->output, probe);
        return ERR_ARGUMENT;
    }
    return output_check(probe);
}

status command_compare(const struct options *o)
{
    struct contest c = {.options = o, .stage = {.options = *o}};
    status s = check_outputs(o);
    if (!s) s = open_contest(&c);
    if (!s) s = compare_frames(&c);
    status written = write_tables(&c);
    close_contest(&c);
    return s ? s : written;
}
