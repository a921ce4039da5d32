// Files come from anywhere: sizes and channels are checked before memory is taken, and what
// OpenEXRCore finds wrong is told in its words.
#include <errno.h>
#include <math.h>
#include <openexr.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "app/image_exr.h"
#include "base/log.h"

enum { PART = 0, MAX_SIZE_PX = 16384, CHANNELS = 13 };

static const char *const names[CHANNELS] = {"R",  "G",  "B",   "Z",      "height", "level", "nx",
                                            "ny", "nz", "lat", "lat.lo", "lon",    "lon.lo"};

enum { DEPTH = 3, LAT = 9, LAT_LO, LON, LON_LO };

struct reader {
    const char *path;
    exr_context_t context;
    int top, width, height, lines; // of a chunk
    float *planes[CHANNELS];
    char message[256];
};

static void on_error(exr_const_context_t context, exr_result_t code, const char *message)
{
    void *user = NULL;
    (void)code;
    exr_get_user_data(context, &user);
    struct reader *r = user;
    if (r && !r->message[0]) snprintf(r->message, sizeof r->message, "%s", message);
}

static status refuse(const struct reader *r, const char *what)
{
    log_error("%s: %s", r->path, what);
    return ERR_FORMAT;
}

static status report(const struct reader *r, exr_result_t code)
{
    return code ? refuse(r, r->message[0] ? r->message : exr_get_default_error_message(code)) : OK;
}

static status check_shape(struct reader *r)
{
    exr_storage_t storage;
    exr_attr_box2i_t box;
    int parts = 0;
    exr_result_t code = exr_get_count(r->context, &parts);
    if (!code) code = exr_get_storage(r->context, PART, &storage);
    if (!code) code = exr_get_data_window(r->context, PART, &box);
    if (code) return report(r, code);
    if (parts != 1 || storage != EXR_STORAGE_SCANLINE)
        return refuse(r, "not a single scanline picture as perigee render writes");
    double width = (double)box.max.x - box.min.x + 1, height = (double)box.max.y - box.min.y + 1;
    if (width < 1 || height < 1 || width > MAX_SIZE_PX || height > MAX_SIZE_PX) {
        log_error("%s: %.0f x %.0f pixels, not 1..%d each", r->path, width, height, MAX_SIZE_PX);
        return ERR_FORMAT;
    }
    r->width = (int)width;
    r->height = (int)height;
    r->top = box.min.y;
    return report(r, exr_get_scanlines_per_chunk(r->context, PART, &r->lines));
}

static int find_name(const char *name)
{
    for (int i = 0; i < CHANNELS; i++)
        if (strcmp(name, names[i]) == 0) return i;
    return -1;
}

static status take_channel(struct reader *r, const exr_attr_chlist_entry_t *entry)
{
    int i = find_name(entry->name.str);
    if (i < 0) return OK;
    if (entry->pixel_type == EXR_PIXEL_UINT || entry->x_sampling != 1 || entry->y_sampling != 1) {
        log_error("%s: channel %s is not one float or half a pixel", r->path, names[i]);
        return ERR_FORMAT;
    }
    r->planes[i] = calloc((size_t)r->width * (size_t)r->height, sizeof(float));
    if (r->planes[i]) return OK;
    log_error("%s: out of memory for %d x %d pixels", r->path, r->width, r->height);
    return ERR_MEMORY;
}

static status take_channels(struct reader *r)
{
    const exr_attr_chlist_t *list = NULL;
    status s = report(r, exr_get_channels(r->context, PART, &list));
    for (int i = 0; !s && i < list->num_channels; i++) s = take_channel(r, &list->entries[i]);
    if (s || r->planes[DEPTH]) return s;
    return refuse(r, "no channel Z (metres along the view axis)");
}

static void point_channels(const struct reader *r, int line, exr_decode_pipeline_t *pipe)
{
    for (int i = 0; i < pipe->channel_count; i++) {
        exr_coding_channel_info_t *info = &pipe->channels[i];
        int k = find_name(info->channel_name);
        info->decode_to_ptr = NULL;
        if (k < 0) continue;
        info->decode_to_ptr = (uint8_t *)(r->planes[k] + (size_t)line * (size_t)r->width);
        info->user_data_type = EXR_PIXEL_FLOAT;
        info->user_bytes_per_element = sizeof(float);
        info->user_pixel_stride = sizeof(float);
        info->user_line_stride = (int32_t)((size_t)r->width * sizeof(float));
    }
}

static status read_chunks(struct reader *r)
{
    exr_decode_pipeline_t pipe = EXR_DECODE_PIPELINE_INITIALIZER;
    exr_result_t code = EXR_ERR_SUCCESS;
    for (int line = 0; line < r->height && !code; line += r->lines) {
        exr_chunk_info_t chunk;
        code = exr_read_scanline_chunk_info(r->context, PART, r->top + line, &chunk);
        if (!code)
            code = line == 0 ? exr_decoding_initialize(r->context, PART, &chunk, &pipe)
                             : exr_decoding_update(r->context, PART, &chunk, &pipe);
        if (!code) point_channels(r, line, &pipe);
        if (!code && line == 0)
            code = exr_decoding_choose_default_routines(r->context, PART, &pipe);
        if (!code) code = exr_decoding_run(r->context, PART, &pipe);
    }
    exr_decoding_destroy(r->context, &pipe);
    return report(r, code);
}

static void read_attributes(const struct reader *r, image_exr_file *out)
{
    perigee_camera *c = &out->camera;
    double *const numbers[] = {&c->lat_deg,   &c->lon_deg,  &c->alt_m,  &c->heading_deg,
                               &c->pitch_deg, &c->roll_deg, &c->fov_deg};
    static const char *const attributes[] = {"camera.lat",     "camera.lon",   "camera.alt",
                                             "camera.heading", "camera.pitch", "camera.roll",
                                             "camera.fov"};
    out->has_camera = true;
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++)
        if (exr_attr_get_double(r->context, PART, attributes[i], numbers[i]) ||
            !isfinite(*numbers[i]))
            out->has_camera = false;
    int32_t length;
    const char *text;
    if (!exr_attr_get_string(r->context, PART, "planet", &length, &text))
        snprintf(out->planet, sizeof out->planet, "%s", text);
}

// The sum of a channel and its residual, in double.
static status join(const struct reader *r, int coarse, double **out)
{
    const float *high = r->planes[coarse], *low = r->planes[coarse + 1];
    size_t pixels = (size_t)r->width * (size_t)r->height;
    if (!high) return OK;
    *out = calloc(pixels, sizeof(double));
    if (!*out) {
        log_error("%s: out of memory for %d x %d pixels", r->path, r->width, r->height);
        return ERR_MEMORY;
    }
    for (size_t i = 0; i < pixels; i++) (*out)[i] = (double)high[i] + (low ? (double)low[i] : 0);
    return OK;
}

static void give(struct reader *r, image_exr_file *out)
{
    float **const to[] = {&out->r,          &out->g,          &out->b,
                          &out->z_m,        &out->height_m,   &out->level,
                          &out->normals[0], &out->normals[1], &out->normals[2]};
    for (int i = 0; i < LAT; i++) {
        *to[i] = r->planes[i];
        r->planes[i] = NULL;
    }
}

static status read_file(struct reader *r, image_exr_file *out)
{
    status s = check_shape(r);
    if (!s) s = take_channels(r);
    if (!s) s = read_chunks(r);
    if (!s) s = join(r, LAT, &out->lat_deg);
    if (!s) s = join(r, LON, &out->lon_deg);
    if (s) return s;
    out->width = r->width;
    out->height = r->height;
    read_attributes(r, out);
    give(r, out);
    return OK;
}

status image_exr_read(const char *path, image_exr_file *out)
{
    struct reader r = {.path = path};
    *out = (image_exr_file){0};
    if (access(path, R_OK) != 0) {
        log_error("%s: %s", path, strerror(errno));
        return errno == ENOENT ? ERR_NOT_FOUND : ERR_IO;
    }
    exr_context_initializer_t settings = EXR_DEFAULT_CONTEXT_INITIALIZER;
    settings.error_handler_fn = on_error;
    settings.user_data = &r;
    exr_result_t code = exr_start_read(&r.context, path, &settings);
    status s = code ? refuse(&r, "not an EXR file") : read_file(&r, out);
    if (r.context) exr_finish(&r.context);
    for (int i = 0; i < CHANNELS; i++) free(r.planes[i]);
    if (s) image_exr_file_deinit(out);
    return s;
}

void image_exr_file_deinit(image_exr_file *f)
{
    float *const planes[] = {f->r,     f->g,          f->b,          f->z_m,       f->height_m,
                             f->level, f->normals[0], f->normals[1], f->normals[2]};
    for (size_t i = 0; i < sizeof planes / sizeof planes[0]; i++) free(planes[i]);
    free(f->lat_deg);
    free(f->lon_deg);
    *f = (image_exr_file){0};
}
