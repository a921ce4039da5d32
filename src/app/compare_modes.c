#include "app/compare_modes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "app/compare_cameras.h"
#include "app/compare_files.h"
#include "app/compare_modes_report.h"
#include "app/compare_time.h"
#include "app/interrupt.h"
#include "app/option_values.h"
#include "base/log.h"
#include "base/memory.h"

enum { MODES_MAX = 16, NAMES_SIZE = 256, REPEATS = 7 };

// What is kept of a side's picture: of modes the errors too.
struct moment {
    float *planes; // r, g, b, geometric_px
    unsigned char *kind;
};

struct contest {
    const struct options *options;
    char text[NAMES_SIZE]; // the names of --modes
    const char *names[MODES_MAX + 1];
    struct compare_side sides[MODES_MAX + 1]; // the judge is the last
    int modes;
    struct compare_stage stage;
    struct compare_cameras cameras;
    bool files;
    perigee_camera file_camera;
    struct moment before[MODES_MAX + 1], after[MODES_MAX + 1];
    compare_modes_head head;
    compare_size sizes[MODES_MAX];
    double goal; // of --equal, NaN: none
    compare_mode_row *rows;
    int done; // cameras
};

static struct compare_side *judge_of(struct contest *c)
{
    return &c->sides[c->modes];
}

static status add_mode(struct contest *c, const char *name)
{
    char names[128];
    int mode = option_mode_find(name);
    if (mode < 0 || mode == MODE_REFERENCE) {
        log_error("--modes %s: '%s' is not a mode (%s)", c->options->modes, name,
                  option_mode_names(names, sizeof names));
        return ERR_ARGUMENT;
    }
    for (int i = 0; i < c->modes; i++) {
        if (strcmp(c->names[i], name) != 0) continue;
        log_error("--modes %s: '%s' stands there twice", c->options->modes, name);
        return ERR_ARGUMENT;
    }
    if (c->modes == MODES_MAX) {
        log_error("--modes %s: more than %d", c->options->modes, MODES_MAX);
        return ERR_ARGUMENT;
    }
    c->names[c->modes++] = perigee_mode_name((enum perigee_mode)mode);
    return OK;
}

static status read_modes(struct contest *c)
{
    const char *text = c->options->modes, *known;
    status s = OK;
    if (strcmp(text, "all") == 0) {
        for (int i = 0; (known = perigee_mode_name((enum perigee_mode)i)) && !s; i++)
            s = add_mode(c, known);
        return s;
    }
    if (strlen(text) >= sizeof c->text) {
        log_error("--modes %.40s...: too long", text);
        return ERR_ARGUMENT;
    }
    memcpy(c->text, text, strlen(text) + 1);
    for (char *name = c->text; name && !s;) {
        char *end = strchr(name, ',');
        if (end) *end++ = '\0';
        s = add_mode(c, name);
        name = end;
    }
    return s;
}

static status take_moment(const struct contest *c, struct moment *m)
{
    size_t pixels = (size_t)c->stage.width * (size_t)c->stage.height;
    m->planes = calloc(pixels, 4 * sizeof *m->planes);
    m->kind = calloc(pixels, 1);
    if (m->planes && m->kind) return OK;
    log_error("compare: out of memory for %dx%d pixels", c->stage.width, c->stage.height);
    return ERR_MEMORY;
}

static void fill_head(struct contest *c)
{
    const struct options *o = c->options;
    const struct session *session = &c->stage.session;
    c->head = (compare_modes_head){.modes = c->names,
                                   .mode_count = c->modes,
                                   .judge = o->side_b,
                                   .planet = session->info.name,
                                   .width = c->stage.width,
                                   .height = c->stage.height,
                                   .flight = o->path != NULL,
                                   .step_s = 1 / o->fps,
                                   .equal = o->equal,
                                   .repeats = o->repeats < 0 ? REPEATS : o->repeats};
}

static status open_contest(struct contest *c)
{
    struct options *o = &c->stage.options;
    status s = read_modes(c);
    c->names[c->modes] = o->side_b;
    if (!s) s = compare_cameras_load(&c->cameras, c->options);
    if (!s)
        s = compare_files_open(c->names, c->modes + 1, c->sides, &c->stage, &c->files,
                               &c->file_camera);
    if (!s) s = compare_stage_open(&c->stage, c->sides, c->modes + 1);
    if (s) return s;
    fill_head(c);
    compare_files_check_planet(judge_of(c), 1, c->head.planet);
    if (!c->files) s = compare_cameras_open(&c->cameras, &c->stage.session);
    else s = session_place(&c->stage.session, &c->file_camera);
    if (compare_cameras_time(&c->cameras, &o->unix_time_s)) o->time_given = true;
    for (int i = 0; i <= c->modes && !s; i++) {
        s = take_moment(c, &c->before[i]);
        if (!s) s = take_moment(c, &c->after[i]);
    }
    c->goal = NAN;
    for (int k = 0; k < c->modes; k++) c->sizes[k] = (compare_size){.size = 1, .met = true};
    c->rows = NEW_ARRAY(compare_mode_row, (size_t)c->cameras.count * (size_t)c->modes);
    return s;
}

static void close_contest(struct contest *c)
{
    for (int i = 0; i <= c->modes; i++) {
        compare_side_close(&c->sides[i]);
        free(c->before[i].planes);
        free(c->before[i].kind);
        free(c->after[i].planes);
        free(c->after[i].kind);
    }
    compare_stage_close(&c->stage);
    compare_cameras_deinit(&c->cameras);
    free(c->rows);
}

static status place_of(const struct contest *c, int i, double later_s, compare_place *out)
{
    *out = (compare_place){.camera = c->file_camera};
    return c->files ? OK : compare_cameras_at(&c->cameras, i, later_s, out);
}

static void keep_colors(const struct contest *c, const struct compare_side *side, struct moment *m)
{
    size_t pixels = (size_t)c->stage.width * (size_t)c->stage.height,
           bytes = pixels * sizeof(float);
    memcpy(m->planes, side->picture.r, bytes);
    memcpy(m->planes + pixels, side->picture.g, bytes);
    memcpy(m->planes + 2 * pixels, side->picture.b, bytes);
}

// One mode at one moment, whose errors and colours are kept there; the bytes uploaded on the way.
static status judge_mode(struct contest *c, int k, const perigee_camera *camera, struct moment *m,
                         compare_result *result, uint64_t *bytes)
{
    struct compare_side *side = &c->sides[k];
    size_t pixels = (size_t)c->stage.width * (size_t)c->stage.height;
    compare_maps maps = {.geometric_px = m->planes + 3 * pixels, .kind = m->kind};
    perigee_stats start, end;
    perigee_view_get_stats(side->view, &start);
    status s = compare_side_render(side, &c->stage, camera);
    if (!s) s = compare_side_judge(side, judge_of(c), &c->stage, camera, &maps, result);
    if (s) return s;
    perigee_view_get_stats(side->view, &end);
    *bytes = end.total_bytes_uploaded - start.total_bytes_uploaded;
    if (c->head.flight) keep_colors(c, side, m);
    return OK;
}

static void fill_row(const struct contest *c, int k, compare_mode_row *row)
{
    perigee_stats stats;
    perigee_view_get_stats(c->sides[k].view, &stats);
    row->size = c->sizes[k];
    row->goal = c->goal;
    row->triangles_total = stats.triangles_total;
    row->triangles_drawn = stats.triangles_drawn;
    row->draws = stats.draws;
    row->gpu_bytes = stats.gpu_bytes;
}

// All modes at a place: errors, triangles, bytes.
static status judge_place(struct contest *c, int i, const compare_place *place)
{
    status s = OK;
    for (int k = 0; k < c->modes && !s; k++) {
        compare_mode_row *row = &c->rows[i * c->modes + k];
        *row = (compare_mode_row){
            .mode = c->names[k],
            .row = {.frame = i, .time_s = place->time_s, .camera = place->camera},
            .bytes_step = NAN,
            .gpu_time = NAN};
        memcpy(row->view, place->name, sizeof row->view);
        s = judge_mode(c, k, &place->camera, &c->before[k], &row->row.result, &row->bytes_filled);
        if (s) return s;
        compare_side_tell(judge_of(c), &c->stage, &row->row);
        fill_row(c, k, row);
        compare_side_zooms(judge_of(c), &row->row.zoom_low, &row->row.zoom_high);
    }
    return s;
}

static flicker_moment flicker_of(const struct contest *c, const struct moment *mode,
                                 const struct moment *judge)
{
    size_t pixels = (size_t)c->stage.width * (size_t)c->stage.height;
    const float *seen = mode->planes, *truth = judge->planes;
    return (flicker_moment){.geometric_px = seen + 3 * pixels,
                            .kind = mode->kind,
                            .r = seen,
                            .g = seen + pixels,
                            .b = seen + 2 * pixels,
                            .true_r = truth,
                            .true_g = truth + pixels,
                            .true_b = truth + 2 * pixels};
}

// All modes at the flight's next moment: what changes from the one before.
static status judge_step(struct contest *c, int i)
{
    int judge = c->modes;
    compare_place next;
    status s = place_of(c, i, c->head.step_s, &next);
    keep_colors(c, judge_of(c), &c->before[judge]);
    if (!s) s = compare_side_render(judge_of(c), &c->stage, &next.camera);
    if (!s) keep_colors(c, judge_of(c), &c->after[judge]);
    for (int k = 0; k < c->modes && !s; k++) {
        compare_mode_row *row = &c->rows[i * c->modes + k];
        compare_result result;
        uint64_t bytes = 0;
        s = judge_mode(c, k, &next.camera, &c->after[k], &result, &bytes);
        flicker_moment before = flicker_of(c, &c->before[k], &c->before[judge]),
                       after = flicker_of(c, &c->after[k], &c->after[judge]);
        if (!s)
            s = flicker_measure(&before, &after, c->stage.width, c->stage.height, &row->flicker);
        row->bytes_step = (double)bytes;
    }
    return s;
}

// The sizes for a place, whose judge's picture is there.
static status choose_sizes(struct contest *c, const perigee_camera *camera)
{
    status s = OK;
    c->goal = c->options->equal_value;
    if (isnan(c->goal))
        s = compare_equal_goal(&c->sides[0], judge_of(c), &c->stage, camera, &c->goal);
    for (int k = 0; k < c->modes && !s; k++)
        s = compare_equal_choose(&c->sides[k], judge_of(c), &c->stage, camera, c->goal,
                                 &c->sizes[k]);
    return s;
}

// Before a flight, by its middle frame; of views at each.
static status choose_for_flight(struct contest *c)
{
    compare_place middle;
    if (c->head.equal == EQUAL_NOTHING || !c->head.flight) return OK;
    status s = place_of(c, c->cameras.count / 2, 0, &middle);
    if (!s) s = compare_side_render(judge_of(c), &c->stage, &middle.camera);
    return s ? s : choose_sizes(c, &middle.camera);
}

// A file's views are judged from nothing each, so that no row depends on those before it.
static status begin_anew(struct contest *c)
{
    status s = OK;
    for (int i = 0; i <= c->modes && !s; i++)
        if (c->sides[i].view)
            s = compare_side_view(&c->sides[i], &c->stage, &c->stage.options.view_params);
    return s;
}

static status compare_camera(struct contest *c, int i)
{
    static const flicker_moment nothing;
    compare_mode_row *rows = &c->rows[i * c->modes];
    double times[MODES_MAX];
    compare_place place;
    c->stage.done = (double)i / c->cameras.count;
    c->stage.share = 0.5 / c->cameras.count;
    status s = place_of(c, i, 0, &place);
    if (!s && i > 0 && !c->head.flight) s = begin_anew(c);
    if (!s) s = compare_side_render(judge_of(c), &c->stage, &place.camera);
    if (!s && c->head.equal != EQUAL_NOTHING && !c->head.flight) s = choose_sizes(c, &place.camera);
    c->stage.done = (i + 0.5) / c->cameras.count;
    c->stage.share = 0;
    if (!s) s = judge_place(c, i, &place);
    for (int k = 0; k < c->modes && !s; k++)
        s = flicker_measure(&nothing, &nothing, 0, 0, &rows[k].flicker);
    if (!s && c->head.flight) s = judge_step(c, i);
    if (!s && c->head.repeats)
        s = compare_time(c->sides, c->modes, &c->stage, &place.camera, c->head.repeats, times);
    for (int k = 0; k < c->modes && !s && c->head.repeats; k++) rows[k].gpu_time = times[k];
    if (!s) c->done = i + 1;
    return s;
}

static status compare_cameras(struct contest *c)
{
    int count = c->cameras.count;
    interrupt_catch();
    progress_start(&c->stage.progress, stderr, c->options->quiet);
    status s = choose_for_flight(c);
    for (int i = 0; i < count && !s; i++) {
        s = compare_camera(c, i);
        if (s) break;
        progress_clear_line();
        compare_modes_report_lines(stdout, &c->head, &c->rows[i * c->modes], i == 0);
    }
    progress_finish(&c->stage.progress);
    if (s == ERR_CANCELLED)
        log_error("interrupted after %d of %d; the tables hold these", c->done, count);
    return s;
}

static status write_tables(const struct contest *c)
{
    const struct options *o = c->options;
    int rows = c->done * c->modes;
    status s = OK;
    if (c->done == 0) return OK;
    if (c->cameras.count > 1) compare_modes_report_summary(stdout, &c->head, c->rows, rows);
    if (o->csv) s = compare_modes_report_csv(o->csv, c->rows, rows);
    if (o->json_file && !s) s = compare_modes_report_json(o->json_file, &c->head, c->rows, rows);
    return s;
}

status compare_modes(const struct options *o)
{
    struct contest c = {.options = o, .stage = {.options = *o}};
    status s = open_contest(&c);
    if (!s) s = compare_cameras(&c);
    status written = write_tables(&c);
    close_contest(&c);
    return s ? s : written;
}
