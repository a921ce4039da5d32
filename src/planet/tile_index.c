// Keys order as planet_file_list does: zoom, row, column.
#include "planet/tile_index.h"

#include <stdatomic.h>
#include <stdint.h>
#include <stdlib.h>

#include "base/log.h"
#include "base/memory.h"

struct tile_index {
    uint64_t *keys;
    atomic_bool *bad;
    size_t count, capacity;
    int max_zoom;
    bool out_of_memory, out_of_order;
};

static uint64_t key_of(tile_id id)
{
    return (uint64_t)id.zoom << 50 | (uint64_t)id.row << 25 | (uint64_t)id.col;
}

static void add(void *user, tile_id id)
{
    struct tile_index *index = user;
    uint64_t key = key_of(id);
    if (index->count && key <= index->keys[index->count - 1]) index->out_of_order = true;
    if (index->count == index->capacity) {
        size_t capacity = index->capacity ? 2 * index->capacity : 256;
        uint64_t *keys = realloc(index->keys, capacity * sizeof *keys);
        if (!keys) {
            index->out_of_memory = true;
            return;
        }
        index->keys = keys;
        index->capacity = capacity;
    }
    index->keys[index->count++] = key;
    index->max_zoom = id.zoom;
}

status tile_index_create(struct planet_file *file, enum tile_layer layer, struct tile_index **out)
{
    struct tile_index *index = NEW(struct tile_index);
    index->max_zoom = -1;
    status s = planet_file_list(file, layer, add, index);
    if (!s && index->out_of_order) {
        log_error("%s: the table of %s tiles is out of order", planet_file_path(file),
                  tile_layer_name(layer));
        s = ERR_FORMAT;
    }
    if (!s && index->count) {
        index->bad = calloc(index->count, sizeof *index->bad);
        index->out_of_memory |= !index->bad;
    }
    if (!s && index->out_of_memory) {
        log_error("%s: out of memory for its %zu tiles", planet_file_path(file), index->count);
        s = ERR_MEMORY;
    }
    if (s) tile_index_destroy(&index);
    *out = index;
    return s;
}

void tile_index_destroy(struct tile_index **index)
{
    if (!*index) return;
    free((*index)->keys);
    free((*index)->bad);
    free(*index);
    *index = NULL;
}

int tile_index_max_zoom(const struct tile_index *index)
{
    return index->max_zoom;
}

// Place of the tile in the arrays, or `count`.
static size_t find(const struct tile_index *index, tile_id id)
{
    uint64_t key = key_of(id);
    size_t low = 0, high = index->count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (index->keys[middle] < key) low = middle + 1;
        else high = middle;
    }
    return low < index->count && index->keys[low] == key ? low : index->count;
}

bool tile_index_has(const struct tile_index *index, tile_id id)
{
    return find(index, id) < index->count;
}

int tile_index_data_zoom(const struct tile_index *index, tile_id id)
{
    int64_t west = (int64_t)id.col * grid_coalesce(id.zoom, id.row); // in equator-width tiles
    int zoom = id.zoom < index->max_zoom ? id.zoom : index->max_zoom;
    for (; zoom >= 0; zoom--) {
        int up = id.zoom - zoom, row = id.row >> up;
        int col = (int)((west >> up) / grid_coalesce(zoom, row));
        if (tile_index_has(index, (tile_id){id.layer, zoom, row, col})) break;
    }
    return zoom;
}

bool tile_index_mark_bad(struct tile_index *index, tile_id id)
{
    size_t i = find(index, id);
    return i < index->count && !atomic_exchange(&index->bad[i], true);
}

bool tile_index_readable(const struct tile_index *index, tile_id id)
{
    size_t i = find(index, id);
    return i < index->count && !atomic_load(&index->bad[i]);
}
