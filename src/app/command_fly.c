#include "app/command.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "app/contact_sheet.h"
#include "app/frame_pattern.h"
#include "app/interrupt.h"
#include "app/output_file.h"
#include "app/path_file.h"
#include "app/progress.h"
#include "app/reference_picture.h"
#include "app/session.h"
#include "app/stats_file.h"
#include "base/log.h"
#include "geo/sun.h"

enum { WIDTH = 1280, HEIGHT = 720, SHEET_CELL_WIDTH = 384, MAX_FRAMES = 10000000 };

struct film {
    struct session session;
    struct path_file path;
    struct flight *flight;
    struct contact_sheet *sheet; // NULL: none
    struct stats_file stats;
    struct reference_source source; // --mode reference
    struct progress progress;
    int frame; // being made
    int width, height, samples, frames;
    double start_s;
    uint8_t *rgb;
};

static double frame_time(const struct film *film, int frame)
{
    return film->start_s + frame / film->session.options->fps;
}

// Is a whole frame of this size there already? Its pixels are read when the contact sheet wants
// them.
static bool already_there(const struct film *film, int frame, const char *path)
{
    int width, height;
    if (!film->session.options->resume) return false;
    if (image_png_size(path, &width, &height)) return false;
    if (width != film->width || height != film->height) return false;
    if (!film->sheet || !contact_sheet_wants(film->sheet, frame)) return true;
    return image_png_read(path, width, height, film->rgb) == OK;
}

// done: of the frame being made.
static bool report(void *user, double done)
{
    struct film *film = user;
    char label[48];
    snprintf(label, sizeof label, "%.24s: %d frames", film->path.name, film->frames);
    progress_update(&film->progress, label, (film->frame + done) / film->frames);
    return interrupt_requested();
}

static status picture(struct film *film, const perigee_camera *camera)
{
    struct session *session = &film->session;
    status s = (status)perigee_view_set_camera(session->view, camera);
    if (!s) s = session_wait(session, film->width, film->height);
    if (!s)
        s = (status)perigee_view_render_image(session->view, film->width, film->height,
                                              film->samples, film->rgb);
    return s;
}

static status cast_picture(struct film *film, const perigee_camera *camera)
{
    reference_params params =
        reference_source_params(&film->source, camera, film->width, film->height);
    if (film->path.time_given && !params.has_sun) {
        params.has_sun = true;
        params.sun = geo_sun_direction(film->path.unix_time_s);
    }
    params.progress = (reference_progress){report, film};
    return reference_picture(&params, film->samples, film->rgb);
}

static status render_frame(struct film *film, int frame, const char *path)
{
    struct session *session = &film->session;
    bool cast = session->options->reference;
    perigee_camera camera;
    double time_s = frame_time(film, frame);
    status s = path_file_camera(film->flight, session->planet, time_s, &camera);
    if (!s) s = cast ? cast_picture(film, &camera) : picture(film, &camera);
    if (s) return s;
    char line[SESSION_CAMERA_SIZE];
    struct image_text texts[SESSION_TEXTS];
    int count = session_texts(session, &camera, line, texts);
    s = image_png_write(path, film->width, film->height, film->rgb, texts, count);
    if (!s && !cast) stats_file_add(&film->stats, session, frame, time_s, &camera);
    return s;
}

static status fly_frame(struct film *film, int frame)
{
    char path[OUTPUT_PATH_SIZE];
    status s = frame_pattern_path(film->session.options->output, frame, path, sizeof path);
    if (s) return s;
    if (!already_there(film, frame, path)) s = render_frame(film, frame, path);
    if (!s && film->sheet) contact_sheet_add(film->sheet, frame, film->rgb);
    return s;
}

static status fly_frames(struct film *film)
{
    status s = OK;
    interrupt_catch();
    progress_start(&film->progress, stderr, film->session.options->quiet);
    for (int frame = 0; frame < film->frames && !s; frame++) {
        film->frame = frame;
        s = report(film, 0) ? ERR_CANCELLED : fly_frame(film, frame);
        if (s == ERR_CANCELLED)
            log_error("interrupted after %d of %d frames: the same command with --resume goes on",
                      frame, film->frames);
    }
    if (!s) report(film, 1);
    progress_finish(&film->progress);
    return s;
}

static status write_sheet(const struct film *film)
{
    if (!film->sheet) return OK;
    int width, height;
    struct image_text texts[] = {{"Software", "Perigee"},
                                 {"Source", film->session.info.attribution}};
    contact_sheet_size(film->sheet, &width, &height);
    return image_png_write(film->session.options->contact_sheet, width, height,
                           contact_sheet_pixels(film->sheet), texts,
                           film->session.info.attribution[0] ? 2 : 1);
}

// How many frames from --start to --end, both included.
static status count_frames(struct film *film)
{
    const struct options *o = film->session.options;
    double duration = flight_duration_s(film->flight);
    double end = isnan(o->end_s) || o->end_s > duration ? duration : o->end_s;
    film->start_s = o->start_s;
    if (film->start_s > duration) {
        log_error("--start %g: %s ends at %g s", o->start_s, o->path, duration);
        return ERR_ARGUMENT;
    }
    double count = floor((end - film->start_s) * o->fps + 1e-6) + 1;
    if (count > MAX_FRAMES) {
        log_error("--fps %g: more than %d frames", o->fps, MAX_FRAMES);
        return ERR_ARGUMENT;
    }
    film->frames = (int)count;
    return OK;
}

static status open_view(struct film *film)
{
    const struct options *o = film->session.options;
    if (o->reference) {
        session_credit(&film->session);
        return reference_source_init(&film->source, o);
    }
    status s = session_open_view(&film->session);
    if (!s && film->path.time_given && !o->time_given)
        s = (status)perigee_view_set_time(film->session.view, film->path.unix_time_s);
    return s;
}

static status prepare(struct film *film)
{
    const struct options *o = film->session.options;
    status s = path_file_flight(&film->path, film->session.planet, &film->flight);
    if (!s) s = count_frames(film);
    if (!s) s = open_view(film);
    if (s) return s;
    film->rgb = calloc((size_t)film->width * (size_t)film->height, 3);
    if (!film->rgb) {
        log_error("--size %dx%d: out of memory", film->width, film->height);
        return ERR_MEMORY;
    }
    if (o->contact_sheet)
        film->sheet = contact_sheet_create(o->sheet_columns, o->sheet_rows, SHEET_CELL_WIDTH,
                                           film->width, film->height, film->frames);
    return OK;
}

static status check_outputs(const struct options *o)
{
    status s = frame_pattern_check(o->output);
    if (!s && o->contact_sheet && !output_has_extension(o->contact_sheet, ".png")) {
        log_error("--contact-sheet %s: not a .png", o->contact_sheet);
        s = ERR_ARGUMENT;
    }
    if (!s) s = output_make_folder(o->output);
    if (!s) s = output_check(o->output);
    if (!s && o->contact_sheet) s = output_make_folder(o->contact_sheet);
    if (!s && o->contact_sheet) s = output_check(o->contact_sheet);
    return s;
}

static void film_deinit(struct film *film)
{
    contact_sheet_destroy(&film->sheet);
    flight_destroy(&film->flight);
    free(film->rgb);
    reference_source_deinit(&film->source);
    session_close(&film->session);
    path_file_deinit(&film->path);
}

status command_fly(const struct options *o)
{
    struct film film = {.width = o->width ? o->width : WIDTH,
                        .height = o->height ? o->height : HEIGHT,
                        .samples = o->samples ? o->samples : 1};
    status s = OK;
    if (o->reference) s = reference_check_options(o, film.width, film.height, film.samples);
    if (!s) s = path_file_load(o->path, &film.path);
    if (!s) s = check_outputs(o);
    if (!s) s = session_open_planet(o, &film.session);
    if (!s) s = stats_file_open(&film.stats, o->stats);
    if (!s) s = prepare(&film);
    if (!s) s = fly_frames(&film);
    if (!s) s = write_sheet(&film);
    if (!s) log_info("%d frames: %s", film.frames, o->output);
    status closed = stats_file_close(&film.stats);
    film_deinit(&film);
    return s ? s : closed;
}
