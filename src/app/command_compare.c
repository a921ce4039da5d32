#include "app/command.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "app/compare_cameras.h"
#include "app/compare_files.h"
#include "app/compare_modes.h"
#include "app/compare_output.h"
#include "app/interrupt.h"
#include "app/option_values.h"
#include "app/output_file.h"
#include "base/log.h"
#include "base/memory.h"

// Two sides at one camera or along a flight.
struct contest {
    const struct options *options;
    struct compare_side sides[2];
    struct compare_stage stage;
    bool files; // a side is one, which has the camera
    perigee_camera file_camera;
    char color_note[160];
    struct compare_cameras cameras;
    compare_head head;
    compare_row *rows;
    int done;     // rows that are made
    double worst; // 99.9 % of the frame that the picture shows
    compare_maps maps;
};

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
    const char *const names[2] = {c->options->side_a, c->options->side_b};
    struct options *o = &c->stage.options;
    status s = compare_cameras_load(&c->cameras, c->options);
    if (!s) s = compare_files_open(names, 2, c->sides, &c->stage, &c->files, &c->file_camera);
    if (!s) s = compare_stage_open(&c->stage, c->sides, 2);
    const struct session *session = &c->stage.session;
    if (s) return s;
    c->head = (compare_head){.a = names[0],
                             .b = names[1],
                             .planet = session->planet ? session->info.name : "",
                             .width = c->stage.width,
                             .height = c->stage.height,
                             .flight = c->options->path != NULL,
                             .bicubic = c->options->bicubic,
                             .color_note = c->color_note};
    write_color_note(c);
    compare_files_check_planet(c->sides, 2, c->head.planet);
    if (!c->files) s = compare_cameras_open(&c->cameras, session);
    else if (session->planet) s = session_place(session, &c->file_camera);
    if (compare_cameras_time(&c->cameras, &o->unix_time_s)) o->time_given = true;
    if (!s) s = take_maps(c);
    c->rows = NEW_ARRAY(compare_row, (size_t)c->cameras.count);
    return s;
}

static void close_contest(struct contest *c)
{
    for (int i = 0; i < 2; i++) compare_side_close(&c->sides[i]);
    compare_stage_close(&c->stage);
    compare_cameras_deinit(&c->cameras);
    free(c->maps.geometric_px);
    free(c->maps.kind);
    free(c->rows);
}

static status compare_frame(struct contest *c, int frame)
{
    compare_row *row = &c->rows[frame];
    compare_place place = {.camera = c->file_camera};
    status s = c->files ? OK : compare_cameras_at(&c->cameras, frame, 0, &place);
    *row = (compare_row){.frame = frame, .time_s = place.time_s, .camera = place.camera};
    for (int i = 0; i < 2 && !s; i++) {
        c->stage.done = (frame + 0.5 * i) / c->cameras.count;
        c->stage.share = 0.5 / c->cameras.count;
        s = compare_side_render(&c->sides[i], &c->stage, &row->camera);
    }
    if (!s)
        s = compare_side_judge(&c->sides[0], &c->sides[1], &c->stage, &row->camera, &c->maps,
                               &row->result);
    if (s) return s;
    compare_side_tell(&c->sides[1], &c->stage, row);
    c->done = frame + 1;
    compare_side_zooms(&c->sides[1], &row->zoom_low, &row->zoom_high);
    return compare_output_row(&c->stage, &c->head, c->sides, row, &c->maps, &c->worst);
}

static status compare_frames(struct contest *c)
{
    int count = c->cameras.count;
    status s = OK;
    interrupt_catch();
    progress_start(&c->stage.progress, stderr, c->options->quiet);
    for (int frame = 0; frame < count && !s; frame++) {
        s = compare_frame(c, frame);
        if (s || !c->head.flight) continue;
        progress_clear_line();
        compare_report_line(stdout, &c->rows[frame]);
    }
    progress_finish(&c->stage.progress);
    if (s == ERR_CANCELLED)
        log_error("interrupted after %d of %d frames; the tables hold these", c->done, count);
    return s;
}

static status write_tables(const struct contest *c)
{
    const struct options *o = c->options;
    status s = OK;
    if (c->done == 0) return OK;
    if (!c->head.flight) compare_report_print(stdout, &c->head, &c->rows[0]);
    if (o->csv) s = compare_report_csv(o->csv, c->rows, c->done);
    if (o->json_file && !s) s = compare_report_json(o->json_file, &c->head, c->rows, c->done);
    return s;
}

static status compare_pair(const struct options *o)
{
    struct contest c = {.options = o, .stage = {.options = *o}};
    status s = open_contest(&c);
    if (!s) s = compare_frames(&c);
    status written = write_tables(&c);
    close_contest(&c);
    return s ? s : written;
}

status command_compare(const struct options *o)
{
    status s = compare_output_check(o);
    if (s) return s;
    return o->modes ? compare_modes(o) : compare_pair(o);
}
