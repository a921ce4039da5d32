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

// Tiles and bytes of each layer.
struct sizes {
    uint64_t tiles[LAYER_COUNT], bytes[LAYER_COUNT];
};

static status measure(struct planet_file *file, struct sizes *out)
{
    status s = OK;
    for (int layer = 0; !s && layer < LAYER_COUNT; layer++)
        s = planet_file_size(file, (enum tile_layer)layer, &out->tiles[layer], &out->bytes[layer]);
    return s;
}

static const char *codec_name(const struct planet_meta *m)
{
    return m->max_error > 0 ? "bounded" : m->quantum > 0 ? "lossless" : "exact";
}

// How heights are stored.
static void print_codec(const struct planet_meta *m)
{
    printf("  codec        %s", codec_name(m));
    if (m->max_error > 0) printf(", at most %g m off", m->max_error);
    else if (m->quantum > 0)
        printf(", at most %g m off, in the finest zoom %g m", m->quantum / 2,
               m->quantum_finest / 2);
    printf("\n");
}

static void print_text(const char *path, const struct planet_meta *m, const struct sizes *sizes)
{
    printf("%s\n", m->name);
    printf("  file         %s\n", path);
    printf("  radii        %.3f m equatorial, %.3f m polar\n", m->ellipsoid.a, m->ellipsoid.b);
    for (int layer = 0; layer < LAYER_COUNT; layer++) {
        int zoom = m->max_zoom[layer];
        const char *name = tile_layer_name((enum tile_layer)layer);
        if (zoom < 0) printf("  %-12s none\n", name);
        else
            printf("  %-12s zooms 0-%d, %.4g m a sample, %llu tiles, %llu bytes\n", name, zoom,
                   sample_m(m, zoom), (unsigned long long)sizes->tiles[layer],
                   (unsigned long long)sizes->bytes[layer]);
    }
    if (m->max_zoom[LAYER_HEIGHT] >= 0) {
        printf("  heights      %.1f to %.1f m above the ellipsoid\n", m->height_min, m->height_max);
        print_codec(m);
    }
    printf("  attribution  %s\n", m->attribution[0] ? m->attribution : "none");
    printf("  complete     %s\n", m->complete ? "yes" : "no");
}

static cJSON *layers_json(const struct planet_meta *m, const struct sizes *sizes)
{
    cJSON *layers = cJSON_CreateObject();
    for (int layer = 0; layer < LAYER_COUNT; layer++) {
        if (m->max_zoom[layer] < 0) continue;
        cJSON *entry = cJSON_AddObjectToObject(layers, tile_layer_name((enum tile_layer)layer));
        cJSON_AddNumberToObject(entry, "maxZoom", m->max_zoom[layer]);
        cJSON_AddNumberToObject(entry, "metresPerSample", sample_m(m, m->max_zoom[layer]));
        cJSON_AddNumberToObject(entry, "tiles", (double)sizes->tiles[layer]);
        cJSON_AddNumberToObject(entry, "bytes", (double)sizes->bytes[layer]);
    }
    return layers;
}

static void print_json(const char *path, const struct planet_meta *m, const struct sizes *sizes)
{
    cJSON *root = cJSON_CreateObject();
    cJSON_AddStringToObject(root, "name", m->name);
    cJSON_AddStringToObject(root, "file", path);
    cJSON_AddNumberToObject(root, "equatorialRadius", m->ellipsoid.a);
    cJSON_AddNumberToObject(root, "polarRadius", m->ellipsoid.b);
    cJSON_AddItemToObject(root, "layers", layers_json(m, sizes));
    if (m->max_zoom[LAYER_HEIGHT] >= 0) {
        cJSON_AddNumberToObject(root, "heightMin", m->height_min);
        cJSON_AddNumberToObject(root, "heightMax", m->height_max);
        cJSON_AddStringToObject(root, "codec", codec_name(m));
        cJSON_AddNumberToObject(root, "maxError", m->max_error > 0 ? m->max_error : m->quantum / 2);
        cJSON_AddNumberToObject(root, "quantum", m->quantum);
        cJSON_AddNumberToObject(root, "quantumFinest", m->quantum_finest);
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
    struct sizes sizes;
    s = measure(file, &sizes);
    if (!s && o->json) print_json(planet_file_path(file), meta, &sizes);
    else if (!s) print_text(planet_file_path(file), meta, &sizes);
    planet_file_close(&file);
    return s;
}
