#include "app/layers.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "app/data_files.h"
#include "app/number.h"
#include "app/output_file.h"
#include "base/log.h"
#include "base/memory.h"

static status wrong(const char *name, const char *value, const char *what)
{
    log_error("--%s %s: %s", name, value, what);
    return ERR_ARGUMENT;
}

// One part after the source: *known is false when it is none, and so belongs to the source.
static status read_part(const char *name, const char *value, const char *part, perigee_layer *layer,
                        bool *known)
{
    *known = true;
    double opacity;
    if (strcmp(part, "height") == 0) layer->kind = PERIGEE_LAYER_HEIGHT;
    else if (strcmp(part, "color") == 0) layer->kind = PERIGEE_LAYER_COLOR;
    else if (strncmp(part, "opacity=", 8) == 0) {
        if (!number_parse(part + 8, &opacity) || !(opacity >= 0 && opacity <= 1))
            return wrong(name, value, "the opacity is not a number in 0..1");
        layer->transparency = 1 - opacity;
    } else *known = false;
    return OK;
}

status layers_add(struct options *o, const char *name, const char *value)
{
    if (o->planet_params.layer_count == OPTIONS_MAX_LAYERS)
        return wrong(name, value, "more than 15 layers");
    char *text = NEW_ARRAY(char, strlen(value) + 1);
    perigee_layer *layer = &o->layers[o->planet_params.layer_count];
    *layer = (perigee_layer){.source = strcpy(text, value)};
    bool known = true;
    status s = OK;
    for (char *comma; !s && known && (comma = strrchr(text, ','));) {
        s = read_part(name, value, comma + 1, layer, &known);
        if (!s && known) *comma = '\0';
    }
    if (!s && !text[0]) s = wrong(name, value, "names no source");
    if (s) free(text);
    else o->planet_params.layer_count++;
    return s;
}

void layers_deinit(struct options *o)
{
    for (int i = 0; i < o->planet_params.layer_count; i++) free((char *)o->layers[i].source);
    o->planet_params.layer_count = 0;
}

// ${XDG_CACHE_HOME:-~/.cache}/perigee/tiles.db; NULL without a home.
static const char *cache_path(const struct options *o, char *path, size_t size)
{
    const char *cache = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    int length = 0;
    if (o->tile_cache) return strcmp(o->tile_cache, "none") == 0 ? NULL : o->tile_cache;
    if (cache && cache[0] == '/') length = snprintf(path, size, "%s/perigee/tiles.db", cache);
    else if (home && home[0]) length = snprintf(path, size, "%s/.cache/perigee/tiles.db", home);
    return length > 0 && (size_t)length < size ? path : NULL;
}

// The name itself, or the path of the preset in `path`.
static status resolve(const char *name, char *path, size_t size, const char **out)
{
    *out = name;
    if (strpbrk(name, "./:") || access(name, F_OK) == 0) return OK;
    char file[256];
    if ((size_t)snprintf(file, sizeof file, "sources/%s.json", name) >= sizeof file)
        return wrong("layer", name, "no such file, and no such preset");
    status s = data_file_find(file, path, size);
    *out = path;
    return s;
}

status layers_open_planet(const struct options *o, const char *path, perigee_planet **out)
{
    char cache[OUTPUT_PATH_SIZE], (*room)[OUTPUT_PATH_SIZE];
    int count = o->planet_params.layer_count;
    perigee_planet_params params = o->planet_params;
    perigee_layer layers[OPTIONS_MAX_LAYERS];
    room = calloc((size_t)count + 1, sizeof *room);
    status s = room ? resolve(path, room[count], sizeof *room, &path) : ERR_MEMORY;
    for (int i = 0; !s && i < count; i++) {
        layers[i] = o->layers[i];
        s = resolve(o->layers[i].source, room[i], sizeof *room, &layers[i].source);
    }
    params.layers = layers;
    params.tile_cache = cache_path(o, cache, sizeof cache);
    if (!s) s = (status)perigee_planet_open(path, &params, out);
    free(room);
    return s;
}
