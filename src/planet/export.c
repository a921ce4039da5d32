// Workers write tiles; the first fault stops all. Folders are made when a tile is the first in
// them.
#include "planet/export.h"

#include <errno.h>
#include <math.h>
#include <png.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/memory.h"
#include "base/pool.h"
#include "planet/codec.h"
#include "planet/export_json.h"

enum { SAMPLES = TILE_SIZE * TILE_SIZE, PATH_SIZE = 4096, QUEUE = 256 };

struct exporter {
    const export_params *params;
    struct planet_file *file;
    struct pool *pool;
    export_list lists[LAYER_COUNT];
    uint64_t total;
    atomic_uint_fast64_t done, bytes;
    atomic_int failure; // status
};

struct task {
    struct exporter *exporter;
    tile_id id;
};

static status write_fault(const char *path)
{
    log_error("%s: %s", path, strerror(errno));
    return ERR_IO;
}

// Makes the folders of a file that is to be written.
static status make_folders(char *path)
{
    for (char *slash = path + 1; (slash = strchr(slash, '/')); slash++) {
        *slash = '\0';
        bool good = mkdir(path, 0777) == 0 || errno == EEXIST;
        *slash = '/';
        if (!good) return write_fault(path);
    }
    return OK;
}

static status write_file(char *path, const void *data, size_t size)
{
    FILE *f = fopen(path, "wb");
    if (!f && errno == ENOENT) {
        status s = make_folders(path);
        if (s) return s;
        f = fopen(path, "wb");
    }
    if (!f) return write_fault(path);
    bool good = fwrite(data, 1, size, f) == size;
    good &= fclose(f) == 0;
    return good ? OK : write_fault(path);
}

// Rounded to the nearest 1/256 m; what terrarium cannot hold is no data.
static void code_heights(const float *heights, uint8_t *rgba)
{
    for (int i = 0; i < SAMPLES; i++, rgba += 4) {
        double v = rint(((double)heights[i] + 32768) * 256);
        bool there = v >= 1 && v < 16777216;
        uint32_t code = there ? (uint32_t)v : 0;
        rgba[0] = (uint8_t)(code >> 16);
        rgba[1] = (uint8_t)(code >> 8);
        rgba[2] = (uint8_t)code;
        rgba[3] = there ? 255 : 0;
    }
}

static status encode_png(const uint8_t *rgba, codec_blob *out)
{
    png_image image = {.version = PNG_IMAGE_VERSION,
                       .width = TILE_SIZE,
                       .height = TILE_SIZE,
                       .format = PNG_FORMAT_RGBA};
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
    out->data = malloc(size);
    if (!out->data) return ERR_MEMORY;
    if (!png_image_write_to_memory(&image, out->data, &size, 0, rgba, 0, NULL)) return ERR_MEMORY;
    out->size = size;
    return OK;
}

static status height_body(struct planet_file *file, tile_id id, codec_blob *out)
{
    float *heights = malloc(sizeof *heights * SAMPLES);
    uint8_t *rgba = malloc(SAMPLES * 4);
    status s = heights && rgba ? planet_file_read_height(file, id, heights) : ERR_MEMORY;
    if (!s) {
        code_heights(heights, rgba);
        s = encode_png(rgba, out);
    }
    free(heights);
    free(rgba);
    return s;
}

static bool is_jpeg(const codec_blob *body)
{
    return body->size > 3 && memcmp(body->data, "\xff\xd8\xff", 3) == 0;
}

// As stored; what is stored in another way than as JPEG is made one.
static status pixel_body(struct planet_file *file, tile_id id, codec_blob *out)
{
    enum { QUALITY = 95 };
    int channels = id.layer == LAYER_COLOR ? 3 : 1;
    status s = planet_file_read_body(file, id, out);
    if (s || is_jpeg(out)) return s;
    codec_blob_deinit(out);
    unsigned char *pixels = malloc(SAMPLES * 3);
    s = pixels ? planet_file_read_pixels(file, id, pixels) : ERR_MEMORY;
    if (!s) s = codec_pixels_encode_jpeg(pixels, channels, QUALITY, out);
    free(pixels);
    return s;
}

static status export_tile(struct exporter *e, tile_id id)
{
    char path[PATH_SIZE];
    codec_blob body = {0};
    bool heights = id.layer == LAYER_HEIGHT;
    status s = heights ? height_body(e->file, id, &body) : pixel_body(e->file, id, &body);
    if (!s) {
        snprintf(path, sizeof path, "%s/%s/%d/%d/%d.%s", e->params->output,
                 tile_layer_name(id.layer), id.zoom, id.row, id.col, heights ? "png" : "jpg");
        s = write_file(path, body.data, body.size);
    }
    e->bytes += body.size;
    codec_blob_deinit(&body);
    return s;
}

static void run_task(void *arg, int worker)
{
    (void)worker;
    struct task *t = arg;
    struct exporter *e = t->exporter;
    if (!atomic_load(&e->failure)) {
        status s = export_tile(e, t->id);
        if (s) atomic_store(&e->failure, (int)s);
    }
    e->done++;
    free(t);
}

static status export_all(struct exporter *e)
{
    double told = 0;
    for (int layer = 0; layer < LAYER_COUNT; layer++)
        for (size_t i = 0; i < e->lists[layer].count && !atomic_load(&e->failure); i++) {
            struct task *t = NEW(struct task);
            *t = (struct task){e, e->lists[layer].ids[i]};
            pool_submit(e->pool, run_task, t);
            if (!e->params->progress || clock_now_s() - told < 0.2) continue;
            told = clock_now_s();
            if (e->params->progress(e->params->user, "export", (double)e->done / (double)e->total))
                atomic_store(&e->failure, (int)ERR_CANCELLED);
        }
    pool_drain(e->pool);
    return (status)atomic_load(&e->failure);
}

static status write_document(struct exporter *e)
{
    char path[PATH_SIZE];
    snprintf(path, sizeof path, "%s/planet.json", e->params->output);
    char *text = export_json(planet_file_meta(e->file), e->lists);
    status s = text ? write_file(path, text, strlen(text)) : ERR_MEMORY;
    free(text);
    return s;
}

static status check_output(const export_params *p)
{
    char path[PATH_SIZE];
    if ((size_t)snprintf(path, sizeof path, "%s/planet.json", p->output) >= sizeof path - 64) {
        log_error("%s: the name is too long", p->output);
        return ERR_ARGUMENT;
    }
    if (p->force || access(path, F_OK) != 0) return OK;
    log_error("%s: exists (--force writes over it)", path);
    return ERR_ARGUMENT;
}

static void add_tile(void *user, tile_id id)
{
    export_list *list = user;
    if (list->count == list->room) {
        size_t room = list->room ? 2 * list->room : 1024;
        tile_id *ids = realloc(list->ids, room * sizeof *ids);
        if (!ids) {
            list->out_of_memory = true;
            return;
        }
        list->ids = ids;
        list->room = room;
    }
    list->ids[list->count++] = id;
}

static status list_tiles(struct exporter *e)
{
    status s = OK;
    for (int i = 0; !s && i < LAYER_COUNT; i++) {
        s = planet_file_list(e->file, (enum tile_layer)i, add_tile, &e->lists[i]);
        if (!s && e->lists[i].out_of_memory) s = ERR_MEMORY;
        e->total += e->lists[i].count;
    }
    return s;
}

status export_run(const export_params *params, export_result *out)
{
    struct exporter e = {.params = params};
    status s = check_output(params);
    if (!s) s = planet_file_open(params->input, &e.file);
    if (!s) s = list_tiles(&e);
    if (!s) {
        e.pool = pool_create(params->threads, QUEUE);
        s = export_all(&e);
        pool_destroy(&e.pool);
    }
    if (!s) s = write_document(&e);
    *out = (export_result){e.done, e.bytes};
    for (int i = 0; i < LAYER_COUNT; i++) free(e.lists[i].ids);
    planet_file_close(&e.file);
    return s;
}
