// A planet file as a source: its index in memory, tiles that cannot be read noted and counted.
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/memory.h"
#include "planet/source.h"
#include "planet/tile_index.h"

enum { SAMPLES = TILE_SIZE * TILE_SIZE };

struct source_file {
    struct source source;
    struct planet_file *file;
    bool owned;
    struct tile_index *index[LAYER_COUNT];
    atomic_uint_fast64_t corrupt, failed;
};

static bool file_has(const struct source *source, tile_id id)
{
    return tile_index_readable(((const struct source_file *)source)->index[id.layer], id);
}

// From R, G, B packed at the end of the room to R, G, B, 255.
static void spread(uint8_t *rgba)
{
    const uint8_t *rgb = rgba + SAMPLES;
    for (size_t i = 0; i < SAMPLES; i++) {
        memmove(rgba + 4 * i, rgb + 3 * i, 3);
        rgba[4 * i + 3] = 255;
    }
}

static status file_read(struct source *source, tile_id id, struct want *want, void *samples,
                        double *until_s)
{
    const double again_s = 2; // a disk that failed is asked again after so long
    (void)want;
    struct source_file *f = (struct source_file *)source;
    uint8_t *bytes = samples;
    status s = ERR_NOT_FOUND;
    if (!file_has(source, id)) return s;
    if (id.layer == LAYER_HEIGHT) s = planet_file_read_height(f->file, id, samples);
    else
        s = planet_file_read_pixels(f->file, id, id.layer == LAYER_COLOR ? bytes + SAMPLES : bytes);
    if (!s && id.layer == LAYER_COLOR) spread(bytes);
    if (s == ERR_IO) {
        *until_s = clock_now_s() + again_s;
        f->failed++;
        return s;
    }
    if (s && s != ERR_MEMORY && tile_index_mark_bad(f->index[id.layer], id)) f->corrupt++;
    return s;
}

static void file_counters(struct source *source, struct source_counters *out)
{
    out->corrupt = ((struct source_file *)source)->corrupt;
    out->failed = ((struct source_file *)source)->failed;
}

static void file_close(struct source *source)
{
    struct source_file *f = (struct source_file *)source;
    for (int layer = 0; layer < LAYER_COUNT; layer++) tile_index_destroy(&f->index[layer]);
    if (f->owned) planet_file_close(&f->file);
    free(f);
}

static const struct source_ops file_ops = {file_has, file_read, file_counters, file_close};

static status open_file(struct planet_file *file, bool owned, struct source **out)
{
    struct source_file *f = NEW(struct source_file);
    f->source = (struct source){
        .ops = &file_ops, .meta = *planet_file_meta(file), .path = planet_file_path(file)};
    f->file = file;
    f->owned = owned;
    *out = &f->source;
    status s = OK;
    for (int layer = 0; !s && layer < LAYER_COUNT; layer++) {
        s = tile_index_create(file, (enum tile_layer)layer, &f->index[layer]);
        if (!s) f->source.meta.max_zoom[layer] = tile_index_max_zoom(f->index[layer]);
    }
    if (s) source_close(out);
    return s;
}

status source_file_open_take(struct planet_file *file, struct source **out)
{
    return open_file(file, true, out);
}

status source_file_open(struct planet_file *file, struct source **out)
{
    return open_file(file, false, out);
}
