// OpenEXRCore writes through our own file, so that a full disk is reported in the system's words.
#include "app/image_exr.h"

#include <errno.h>
#include <fcntl.h>
#include <openexr.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "app/output_file.h"
#include "base/log.h"

enum { PART = 0, LINES = 16 }; // a ZIP chunk has 16 lines

// Where a channel's floats come from: a plane of floats, or one of doubles split in two.
struct channel {
    const char *name;
    const float *plane;
    const double *wide;
    bool residual, half;
};

struct writer {
    const char *path;
    const image_exr *image;
    struct channel channels[IMAGE_EXR_MAX_PLANES];
    int count;
    exr_context_t context;
    int file;
    int write_errno;
    float *split; // LINES * width floats for each channel taken from doubles
};

static void on_error(exr_const_context_t context, exr_result_t code, const char *message)
{
    (void)context;
    log_debug("EXR: %s (%d)", message, (int)code);
}

static int64_t write_bytes(exr_const_context_t context, void *user, const void *data, uint64_t size,
                           uint64_t offset, exr_stream_error_func_ptr_t error)
{
    struct writer *w = user;
    uint64_t done = 0;
    while (done < size) {
        ssize_t n = pwrite(w->file, (const char *)data + done, size - done, (off_t)(offset + done));
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) {
            w->write_errno = n < 0 ? errno : ENOSPC;
            error(context, EXR_ERR_WRITE_IO, "%s", strerror(w->write_errno));
            return -1;
        }
        done += (uint64_t)n;
    }
    return (int64_t)size;
}

static status report(const struct writer *w, exr_result_t code)
{
    if (code == EXR_ERR_SUCCESS) return OK;
    log_error("%s: cannot write: %s", w->path,
              w->write_errno ? strerror(w->write_errno) : exr_get_default_error_message(code));
    return ERR_IO;
}

enum { SPLIT_COUNT = 8 };

// In the order of their names, as in the file.
static void list_channels(struct writer *w)
{
    const image_exr *image = w->image;
    const perigee_planes *p = &image->planes;
    const struct channel channels[] = {
        {"B", p->b, NULL, false, image->half_color},
        {"G", p->g, NULL, false, image->half_color},
        {"R", p->r, NULL, false, image->half_color},
        {"Z", p->z_m, NULL, false, false},
        {"easting", NULL, image->easting, false, false},
        {"easting.lo", NULL, image->easting, true, false},
        {"height", p->height_m, NULL, false, false},
        {"lat", NULL, p->lat_deg, false, false},
        {"lat.lo", NULL, p->lat_deg, true, false},
        {"level", p->level, NULL, false, false},
        {"lon", NULL, p->lon_deg, false, false},
        {"lon.lo", NULL, p->lon_deg, true, false},
        {"northing", NULL, image->northing, false, false},
        {"northing.lo", NULL, image->northing, true, false},
        {"nx", image->normals[0], NULL, false, false},
        {"ny", image->normals[1], NULL, false, false},
        {"nz", image->normals[2], NULL, false, false},
    };
    for (size_t i = 0; i < sizeof channels / sizeof channels[0]; i++)
        if (channels[i].plane || channels[i].wide) w->channels[w->count++] = channels[i];
}

static exr_result_t set_attributes(const struct writer *w)
{
    const perigee_camera *c = &w->image->camera;
    const struct {
        const char *name;
        double value;
    } numbers[] = {
        {"camera.lat", c->lat_deg},     {"camera.lon", c->lon_deg},
        {"camera.alt", c->alt_m},       {"camera.heading", c->heading_deg},
        {"camera.pitch", c->pitch_deg}, {"camera.roll", c->roll_deg},
        {"camera.fov", c->fov_deg},
    };
    exr_result_t r = EXR_ERR_SUCCESS;
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0] && !r; i++)
        r = exr_attr_set_double(w->context, PART, numbers[i].name, numbers[i].value);
    if (!r) r = exr_attr_set_string(w->context, PART, "planet", w->image->planet);
    if (!r) r = exr_attr_set_string(w->context, PART, "attribution", w->image->attribution);
    if (!r && w->image->zoom) r = exr_attr_set_string(w->context, PART, "zoom", w->image->zoom);
    if (!r) r = exr_attr_set_string(w->context, PART, "software", "Perigee");
    return r;
}

static exr_result_t write_header(const struct writer *w)
{
    exr_context_t c = w->context;
    int part;
    exr_result_t r = exr_add_part(c, "frame", EXR_STORAGE_SCANLINE, &part);
    if (!r)
        r = exr_initialize_required_attr_simple(c, PART, w->image->width, w->image->height,
                                                EXR_COMPRESSION_ZIP);
    for (int i = 0; i < w->count && !r; i++)
        r = exr_add_channel(c, PART, w->channels[i].name,
                            w->channels[i].half ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT,
                            EXR_PERCEPTUALLY_LINEAR, 1, 1);
    if (!r) r = set_attributes(w);
    return r ? r : exr_write_header(c);
}

// The float nearest to each double, or what is left of the double beside it.
static void split_lines(const double *wide, bool residual, size_t count, float *out)
{
    for (size_t i = 0; i < count; i++) {
        float nearest = (float)wide[i];
        out[i] = residual ? (float)(wide[i] - (double)nearest) : nearest;
    }
}

static void point_channels(const struct writer *w, int y, exr_encode_pipeline_t *pipe)
{
    size_t width = (size_t)w->image->width, start = (size_t)y * width;
    size_t lines = (size_t)(w->image->height - y < LINES ? w->image->height - y : LINES);
    float *split = w->split;
    for (int i = 0; i < w->count; i++) {
        const float *from = w->channels[i].plane ? w->channels[i].plane + start : split;
        if (w->channels[i].wide) {
            split_lines(w->channels[i].wide + start, w->channels[i].residual, lines * width, split);
            split += LINES * width;
        }
        exr_coding_channel_info_t *info = &pipe->channels[i];
        info->user_data_type = EXR_PIXEL_FLOAT;
        info->user_bytes_per_element = sizeof(float);
        info->user_pixel_stride = sizeof(float);
        info->user_line_stride = (int32_t)(width * sizeof(float));
        info->encode_from_ptr = (const uint8_t *)from;
    }
}

static exr_result_t write_chunks(const struct writer *w)
{
    exr_encode_pipeline_t pipe = EXR_ENCODE_PIPELINE_INITIALIZER;
    exr_result_t r = EXR_ERR_SUCCESS;
    for (int y = 0; y < w->image->height && !r; y += LINES) {
        exr_chunk_info_t chunk;
        r = exr_write_scanline_chunk_info(w->context, PART, y, &chunk);
        if (!r)
            r = y == 0 ? exr_encoding_initialize(w->context, PART, &chunk, &pipe)
                       : exr_encoding_update(w->context, PART, &chunk, &pipe);
        if (!r) point_channels(w, y, &pipe);
        if (!r && y == 0) r = exr_encoding_choose_default_routines(w->context, PART, &pipe);
        if (!r) r = exr_encoding_run(w->context, PART, &pipe);
    }
    exr_encoding_destroy(w->context, &pipe);
    return r;
}

static status write_image(struct writer *w)
{
    exr_context_initializer_t settings = EXR_DEFAULT_CONTEXT_INITIALIZER;
    settings.error_handler_fn = on_error;
    settings.user_data = w;
    settings.write_fn = write_bytes;
    exr_result_t r = exr_start_write(&w->context, w->path, EXR_WRITE_FILE_DIRECTLY, &settings);
    if (!r) r = write_header(w);
    if (!r) r = write_chunks(w);
    exr_result_t end = w->context ? exr_finish(&w->context) : EXR_ERR_SUCCESS;
    return report(w, r ? r : end);
}

static status write_part(struct writer *w, const char *part)
{
    w->split = calloc(SPLIT_COUNT * LINES * (size_t)w->image->width, sizeof(float));
    if (!w->split) {
        log_error("%s: out of memory", w->path);
        return ERR_MEMORY;
    }
    status s = ERR_IO;
    w->file = open(part, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (w->file < 0) log_error("%s: cannot write: %s", w->path, strerror(errno));
    else {
        s = write_image(w);
        if (close(w->file) != 0 && !s) {
            log_error("%s: cannot write: %s", w->path, strerror(errno));
            s = ERR_IO;
        }
    }
    free(w->split);
    return s;
}

static status write_file(struct writer *w)
{
    char part[OUTPUT_PATH_SIZE];
    status s = output_part(w->path, part);
    if (s) return s;
    s = write_part(w, part);
    if (!s) s = output_commit(w->path);
    if (s) output_discard(w->path);
    return s;
}

status image_exr_write(const char *path, const image_exr *image)
{
    struct writer w = {.path = path, .image = image};
    list_channels(&w);
    return write_file(&w);
}

status image_exr_write_planes(const char *path, const image_exr *about,
                              const image_exr_plane *planes, int count)
{
    struct writer w = {.path = path, .image = about, .count = count};
    for (int i = 0; i < count; i++)
        w.channels[i] = (struct channel){planes[i].name, planes[i].values, NULL, false, false};
    return write_file(&w);
}
