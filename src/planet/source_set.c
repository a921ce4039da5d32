// What a name is: a URL by its scheme, a TileJSON by its ending, a planet file by its first bytes,
// and anything else GDAL's.
#include "planet/source_set.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "planet/http.h"
#include "planet/source_raster.h"
#include "planet/source_remote.h"

enum { MAX_DOCUMENT = 16 << 20 };

static const double DOCUMENT_WAIT_S = 30;
static const uint64_t DEFAULT_DISK_BYTES = (uint64_t)1 << 30;

struct source_set {
    source_set_params params;
    struct disk_cache *disk;
    struct fetcher *fetcher;
    struct plane_map *map;
    pyramid_layer layers[PYRAMID_MAX_LAYERS];
    int count;
};

struct source_set *source_set_create(const source_set_params *params)
{
    struct source_set *set = NEW(struct source_set);
    set->params = *params;
    return set;
}

void source_set_destroy(struct source_set **set)
{
    struct source_set *s = *set;
    if (!s) return;
    for (int i = 0; i < s->count; i++) source_close(&s->layers[i].source);
    plane_map_destroy(&s->map);
    fetcher_destroy(&s->fetcher);
    disk_cache_close(&s->disk);
    free(s);
    *set = NULL;
}

static struct fetcher *fetcher_of(struct source_set *set)
{
    if (set->fetcher) return set->fetcher;
    uint64_t bytes = set->params.disk_bytes ? set->params.disk_bytes : DEFAULT_DISK_BYTES;
    if (set->params.disk_path) disk_cache_open(set->params.disk_path, bytes, &set->disk);
    fetch_params params = set->params.fetch;
    params.disk = set->disk;
    return set->fetcher = fetcher_create(&params);
}

static status open_document(struct source_set *set, const char *text, size_t size,
                            const char *origin, struct source **out)
{
    source_spec spec;
    status s = source_spec_parse(text, size, origin, &spec);
    return s ? s : source_remote_open_take(&spec, fetcher_of(set), out);
}

static status open_url(struct source_set *set, const char *url, enum tile_layer layer,
                       struct source **out)
{
    source_spec spec;
    if (strchr(url, '{')) {
        status s = source_spec_of_template(url, layer == LAYER_COUNT ? LAYER_COLOR : layer, &spec);
        return s ? s : source_remote_open_take(&spec, fetcher_of(set), out);
    }
    const fetch_body *body;
    status s = fetch_wait(fetcher_of(set), url, MAX_DOCUMENT, DOCUMENT_WAIT_S, &body);
    if (s) {
        log_error("%s: %s", url,
                  s == ERR_NOT_FOUND ? "the server has no such thing"
                  : s == ERR_FORMAT  ? "refused"
                                     : "the server does not answer");
        return s == ERR_TIMEOUT ? ERR_IO : s;
    }
    s = open_document(set, (const char *)body->data, body->size, url, out);
    fetch_release(set->fetcher, &body);
    return s;
}

static status open_json(struct source_set *set, const char *path, struct source **out)
{
    FILE *f = fopen(path, "rb");
    if (!f) {
        log_error("%s: %s", path, strerror(errno));
        return errno == ENOENT ? ERR_NOT_FOUND : ERR_IO;
    }
    char *text = malloc(MAX_DOCUMENT);
    size_t size = text ? fread(text, 1, MAX_DOCUMENT, f) : 0;
    status s = text ? OK : ERR_MEMORY;
    if (size == MAX_DOCUMENT || ferror(f)) {
        log_error("%s: %s", path, ferror(f) ? "cannot read" : "too large");
        s = ferror(f) ? ERR_IO : ERR_FORMAT;
    }
    fclose(f);
    if (!s) s = open_document(set, text, size, path, out);
    free(text);
    return s;
}

static bool ends_with(const char *text, const char *end)
{
    size_t n = strlen(text), m = strlen(end);
    return n >= m && strcmp(text + n - m, end) == 0;
}

// SQLite files of other kinds (GeoPackage, MBTiles) are GDAL's.
static bool is_planet_file(const char *path)
{
    unsigned char head[72] = {0};
    FILE *f = fopen(path, "rb");
    size_t got = f ? fread(head, 1, sizeof head, f) : 0;
    if (f) fclose(f);
    if (got < 16 || memcmp(head, "SQLite format 3", 16) != 0) return ends_with(path, ".planet");
    return got < sizeof head || memcmp(head + 68, "PRGE", 4) == 0 || ends_with(path, ".planet");
}

static status open_raster(struct source_set *set, const char *name, enum tile_layer layer,
                          struct source **out)
{
    status s = OK;
    if (set->params.flat && set->count == 0) s = plane_map_open(name, &set->map);
    if (!s) s = source_raster_open_on(name, layer, set->map, out);
    // The map's own raster goes on where it has no data, from coarser tiles, so that the ground
    // ends at the map's edge without a step. What lies over it ends where its data do.
    if (!s && set->map) (*out)->gaps_final = set->count > 0;
    return s;
}

static status open_named(struct source_set *set, const char *name, enum tile_layer layer,
                         struct source **out)
{
    *out = NULL;
    if (http_is_url(name)) return open_url(set, name, layer, out);
    if (strstr(name, "://") && !strstr(name, "/vsi")) {
        log_error("%s: only http and https are spoken here", name);
        return ERR_ARGUMENT;
    }
    if (ends_with(name, ".json")) return open_json(set, name, out);
    if (!is_planet_file(name)) return open_raster(set, name, layer, out);
    struct planet_file *file;
    status s = planet_file_open(name, &file);
    return s ? s : source_file_open_take(file, out);
}

// Leaves only one layer of a source.
static status select_layer(struct source *source, const char *name, enum tile_layer layer)
{
    if (layer == LAYER_COUNT) return OK;
    for (int i = 0; i < LAYER_COUNT; i++)
        if (i != (int)layer && !(layer == LAYER_COLOR && i == LAYER_NIGHT))
            source->meta.max_zoom[i] = -1;
    if (source->meta.max_zoom[layer] >= 0) return OK;
    log_error("%s: has no %s", name, tile_layer_name(layer));
    return ERR_ARGUMENT;
}

status source_set_add(struct source_set *set, const char *name, enum tile_layer layer,
                      double opacity)
{
    if (set->count == PYRAMID_MAX_LAYERS) {
        log_error("%s: more than %d layers", name, PYRAMID_MAX_LAYERS);
        return ERR_ARGUMENT;
    }
    struct source *source;
    status s = open_named(set, name, layer, &source);
    if (!s && set->map && !geo_is_plane(source->meta.ellipsoid)) {
        log_error("%s: cannot lie on a map in a projected reference system: only rasters can",
                  name);
        s = ERR_ARGUMENT;
    }
    if (!s) s = select_layer(source, name, layer);
    if (s) {
        source_close(&source);
        return s;
    }
    set->layers[set->count++] = (pyramid_layer){source, (float)opacity};
    return OK;
}

status source_set_pyramid(struct source_set *set, const pyramid_params *params,
                          struct pyramid **out)
{
    pyramid_params with = *params;
    with.flat = set->params.flat;
    return pyramid_create_stack(set->layers, set->count, &with, out);
}

struct plane_map *source_set_map(const struct source_set *set)
{
    return set->map;
}

struct fetcher *source_set_fetcher(const struct source_set *set)
{
    return set->fetcher;
}

struct disk_cache *source_set_disk(const struct source_set *set)
{
    return set->disk;
}
