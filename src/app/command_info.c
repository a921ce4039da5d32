#include "app/command.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>

#include "app/data_files.h"
#include "app/output_file.h"
#include "planet/planet_file.h"

// Size of one sample of a zoom at the equator, in metres.
static double sample_m(const struct planet_meta *m, int zoom)
{
    return m->ellipsoid.a * grid_step_lat(zoom);
}

static void print_text(const char *path, const struct planet_meta *m)
{
    printf("%s\n", m->name);
    printf("  file         %s\n", path);
    printf("  radii        %.3f m equatorial, %.3f m polar\n", m->ellipsoid.a, m->ellipsoid.b);
    for (int layer = 0; layer < LAYER_COUNT; layer++) {
        int zoom = m->max_zoom[layer];
        const char *name = tile_layer_name((enum tile_layer)layer);
        if (zoom < 0) printf("  %-12s none\n", name);
        else printf("  %-12s zooms 0-%d, %.4g m a sample\n", name, zoom, sample_m(m, zoom));
    }
    if (m->max_zoom[LAYER_HEIGHT] >= 0)
        printf("  heights      %.1f to %.1f m above the ellipsoid\n", m->height_min, m->height_max);
    printf("  attribution  %s\n", m->attribution[0] ? m->attribution : "none");
    printf("  complete     %s\n", m->complete ? "yes" : "no");
}

static cJSON *layers_json(const struct planet_meta *m)
{
    cJSON *layers = cJSON_CreateObject();
    for (int layer = 0; layer < LAYER_COUNT; layer++) {
        if (m->max_zoom[layer] < 0) continue;
        cJSON *entry = cJSON_AddObjectToObject(layers, tile_layer_name((enum tile_layer)layer));
        cJSON_AddNumberToObject(entry, "maxZoom", m->max_zoom[layer]);
        cJSON_AddNumberToObject(entry, "metresPerSample", sample_m(m, m->max_zoom[layer]));
    }
    return layers;
}

static void print_json(const char *path, const struct planet_meta *m)
{
    cJSON *root = cJSON_CreateObject();
    cJSON_AddStringToObject(root, "name", m->name);
    cJSON_AddStringToObject(root, "file", path);
    cJSON_AddNumberToObject(root, "equatorialRadius", m->ellipsoid.a);
    cJSON_AddNumberToObject(root, "polarRadius", m->ellipsoid.b);
    cJSON_AddItemToObject(root, "layers", layers_json(m));
    if (m->max_zoom[LAYER_HEIGHT] >= 0) {
        cJSON_AddNumberToObject(root, "heightMin", m->height_min);
        cJSON_AddNumberToObject(root, "heightMax", m->height_max);
    }
    cJSON_AddNumberToObject(root, "synthesisGain", m->synthesis_gain);
    cJSON_AddStringToObject(root, "attribution", m->attribution);
    cJSON_AddBoolToObject(root, "complete", m->complete);
    char *text = cJSON_Print(root);
    if (text) puts(text);
    cJSON_free(text);
    cJSON_Delete(root);
}

status command_info(const struct options *o)
{
    char earth[OUTPUT_PATH_SIZE];
    status s = o->planet ? OK : data_earth_path(earth, sizeof earth);
    if (s) return s;
    struct planet_file *file;
    s = planet_file_open(o->planet ? o->planet : earth, &file);
    if (s) return s;
    const struct planet_meta *meta = planet_file_meta(file);
    if (o->json) print_json(planet_file_path(file), meta);
    else print_text(planet_file_path(file), meta);
    planet_file_close(&file);
    return OK;
}
