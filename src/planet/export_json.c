#include "planet/export_json.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Runs of neighbours in a row, as [zoom, row, first, last].
static cJSON *ranges(const export_list *list)
{
    cJSON *array = cJSON_CreateArray();
    for (size_t i = 0; i < list->count;) {
        tile_id a = list->ids[i];
        int last = a.col;
        for (i++; i < list->count; i++, last++) {
            tile_id b = list->ids[i];
            if (b.zoom != a.zoom || b.row != a.row || b.col != last + 1) break;
        }
        cJSON_AddItemToArray(array, cJSON_CreateIntArray((int[]){a.zoom, a.row, a.col, last}, 4));
    }
    return array;
}

static cJSON *layer_json(const struct planet_meta *m, enum tile_layer layer,
                         const export_list *list)
{
    const char *name = tile_layer_name(layer);
    char tiles[64];
    cJSON *doc = cJSON_CreateObject(), *templates, *extra;
    snprintf(tiles, sizeof tiles, "%s/{z}/{y}/{x}.%s", name, layer == LAYER_HEIGHT ? "png" : "jpg");
    cJSON_AddStringToObject(doc, "tilejson", "3.0.0");
    cJSON_AddStringToObject(doc, "name", m->name);
    cJSON_AddStringToObject(doc, "attribution", m->attribution);
    templates = cJSON_AddArrayToObject(doc, "tiles");
    cJSON_AddItemToArray(templates, cJSON_CreateString(tiles));
    cJSON_AddNumberToObject(doc, "minzoom", 0);
    cJSON_AddNumberToObject(doc, "maxzoom", m->max_zoom[layer]);
    if (layer == LAYER_HEIGHT) cJSON_AddStringToObject(doc, "encoding", "terrarium");
    extra = cJSON_AddObjectToObject(doc, "perigee");
    cJSON_AddStringToObject(extra, "layer", name);
    cJSON_AddStringToObject(extra, "projection", "planet");
    cJSON_AddItemToObject(extra, "available", ranges(list));
    return doc;
}

char *export_json(const struct planet_meta *m, const export_list lists[LAYER_COUNT])
{
    cJSON *doc = cJSON_CreateObject();
    cJSON_AddStringToObject(doc, "name", m->name);
    cJSON_AddStringToObject(doc, "attribution", m->attribution);
    cJSON *extra = cJSON_AddObjectToObject(doc, "perigee");
    double radii[2] = {m->ellipsoid.a, m->ellipsoid.b}, range[2] = {m->height_min, m->height_max};
    cJSON_AddItemToObject(extra, "ellipsoid", cJSON_CreateDoubleArray(radii, 2));
    cJSON_AddItemToObject(extra, "heightRange", cJSON_CreateDoubleArray(range, 2));
    cJSON_AddNumberToObject(extra, "synthesisGain", m->synthesis_gain);
    cJSON *layers = cJSON_AddArrayToObject(doc, "layers");
    for (int i = 0; i < LAYER_COUNT; i++)
        if (lists[i].count)
            cJSON_AddItemToArray(layers, layer_json(m, (enum tile_layer)i, &lists[i]));
    char *text = cJSON_PrintUnformatted(doc);
    cJSON_Delete(doc);
    return text;
}
