// Members are checked one by one; what is not known here belongs to other readers and is left
// alone.
#include "planet/source_spec.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "planet/http.h"

#define RAD(deg) ((deg) * (M_PI / 180))

enum { DEFAULT_MAX_LEVEL = 18 };

// Where a member stands, for messages.
struct place {
    const char *origin;
};

static status fault(const struct place *at, const char *member, const char *what)
{
    log_error("%s: \"%s\" %s", at->origin, member, what);
    return ERR_FORMAT;
}

static status get_number(const struct place *at, const cJSON *object, const char *name, double low,
                         double high, double *out)
{
    const cJSON *m = cJSON_GetObjectItemCaseSensitive(object, name);
    char what[96];
    if (!m) return OK;
    if (cJSON_IsNumber(m) && m->valuedouble >= low && m->valuedouble <= high) {
        *out = m->valuedouble;
        return OK;
    }
    snprintf(what, sizeof what, "is not a number in %g..%g", low, high);
    return fault(at, name, what);
}

static status get_integer(const struct place *at, const cJSON *object, const char *name, int low,
                          int high, int *out)
{
    double x = *out;
    status s = get_number(at, object, name, low, high, &x);
    if (!s && x != floor(x)) s = fault(at, name, "is not a whole number");
    if (!s) *out = (int)x;
    return s;
}

// One of names[0..count); absent: *out is left alone.
static status get_choice(const struct place *at, const cJSON *object, const char *name,
                         const char *const *names, int count, int *out)
{
    const cJSON *m = cJSON_GetObjectItemCaseSensitive(object, name);
    if (!m) return OK;
    for (int i = 0; i < count && cJSON_IsString(m); i++)
        if (strcmp(m->valuestring, names[i]) == 0) {
            *out = i;
            return OK;
        }
    char what[160] = "is none of";
    for (int i = 0; i < count; i++) {
        size_t used = strlen(what);
        snprintf(what + used, sizeof what - used, " %s", names[i]);
    }
    return fault(at, name, what);
}

static status get_numbers(const struct place *at, const cJSON *object, const char *name, int count,
                          double *out)
{
    const cJSON *m = cJSON_GetObjectItemCaseSensitive(object, name);
    if (!m) return OK;
    if (!cJSON_IsArray(m) || cJSON_GetArraySize(m) != count)
        return fault(at, name, "is not the right number of numbers");
    for (int i = 0; i < count; i++) {
        const cJSON *n = cJSON_GetArrayItem(m, i);
        if (!cJSON_IsNumber(n) || !isfinite(n->valuedouble))
            return fault(at, name, "is not a list of numbers");
        out[i] = n->valuedouble;
    }
    return OK;
}

static void get_text(const cJSON *object, const char *name, char *out, size_t size)
{
    const cJSON *m = cJSON_GetObjectItemCaseSensitive(object, name);
    if (!cJSON_IsString(m) || out[0]) return;
    size_t n = 0;
    const char *c = m->valuestring;
    for (; *c && n + 1 < size; c++) out[n++] = (unsigned char)*c < ' ' ? ' ' : *c;
    while (*c && n > 0 && ((unsigned char)out[n - 1] & 0xc0) == 0x80) n--; // not half a letter
    if (*c && n > 0) n--;
    out[n] = '\0';
}

static bool is_placeholder(const char *text, size_t length)
{
    static const char *const known[] = {"{z}",          "{x}",       "{y}",      "{-y}",
                                        "{TileMatrix}", "{TileCol}", "{TileRow}"};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        if (strlen(known[i]) == length && strncmp(known[i], text, length) == 0) return true;
    return false;
}

static status check_template(const struct place *at, const char *url)
{
    if (!http_is_url(url)) return fault(at, "tiles", "is no URL of http or https");
    if (strlen(url) > SPEC_URL_SIZE / 2) return fault(at, "tiles", "is too long");
    int found = 0;
    for (const char *open = strchr(url, '{'); open; open = strchr(open + 1, '{')) {
        const char *close = strchr(open, '}');
        if (!close || !is_placeholder(open, (size_t)(close - open) + 1))
            return fault(at, "tiles",
                         "has a part in braces that is none of {z} {x} {y} {-y} "
                         "{TileMatrix} {TileCol} {TileRow}");
        found++;
    }
    return found >= 3 ? OK : fault(at, "tiles", "lacks {z}, {x} or {y}");
}

// A template relative to its document.
static char *absolute(const char *url, const char *origin)
{
    size_t size = strlen(url) + strlen(origin) + 2;
    char *out = NEW_ARRAY(char, size);
    const char *host = strstr(origin, "://");
    const char *path = host ? strchr(host + 3, '/') : NULL, *slash = strrchr(origin, '/');
    if (http_is_url(url) || !host) snprintf(out, size, "%s", url);
    else if (url[0] == '/') snprintf(out, size, "%.*s%s", (int)(path - origin), origin, url);
    else snprintf(out, size, "%.*s/%s", path ? (int)(slash - origin) : (int)size, origin, url);
    return out;
}

static status get_template(const struct place *at, const cJSON *doc, spec_layer *out)
{
    const cJSON *tiles = cJSON_GetObjectItemCaseSensitive(doc, "tiles");
    const cJSON *first = cJSON_GetArrayItem(tiles, 0);
    if (!cJSON_IsArray(tiles) || !cJSON_IsString(first))
        return fault(at, "tiles", "is not a list of URLs");
    out->url = absolute(first->valuestring, at->origin);
    return check_template(at, out->url);
}

static int compare_ranges(const void *a, const void *b)
{
    const spec_range *p = a, *q = b;
    if (p->zoom != q->zoom) return p->zoom < q->zoom ? -1 : 1;
    if (p->row != q->row) return p->row < q->row ? -1 : 1;
    return (p->first > q->first) - (p->first < q->first);
}

static status get_ranges(const struct place *at, const cJSON *extra, spec_layer *out)
{
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(extra, "available"), *item;
    if (!list) return OK;
    if (!cJSON_IsArray(list)) return fault(at, "available", "is not a list");
    size_t count = (size_t)cJSON_GetArraySize(list);
    out->ranges = calloc(count ? count : 1, sizeof *out->ranges);
    if (!out->ranges) return ERR_MEMORY;
    cJSON_ArrayForEach(item, list)
    {
        int v[4];
        for (int i = 0; i < 4; i++) {
            const cJSON *n = cJSON_GetArrayItem(item, i);
            if (!cJSON_IsNumber(n) || n->valuedouble < 0 || n->valuedouble > 1e9)
                return fault(at, "available", "has an entry that is not four numbers");
            v[i] = n->valueint;
        }
        out->ranges[out->range_count++] = (spec_range){v[0], v[1], v[2], v[3]};
    }
    qsort(out->ranges, out->range_count, sizeof *out->ranges, compare_ranges);
    return OK;
}

static status get_kind(const struct place *at, const cJSON *doc, const cJSON *extra,
                       spec_layer *out)
{
    static const char *const layers[] = {"height", "color", "night"};
    static const char *const projections[] = {"mercator", "geographic", "planet"};
    static const char *const encodings[] = {"image", "terrarium", "terrain-rgb", "mapbox"};
    int encoding = 0, layer = -1, projection = 0;
    status s = get_choice(at, doc, "encoding", encodings, 4, &encoding);
    if (!s) s = get_choice(at, extra, "encoding", encodings, 4, &encoding);
    if (!s) s = get_choice(at, extra, "layer", layers, 3, &layer);
    if (!s) s = get_choice(at, extra, "projection", projections, 3, &projection);
    if (s) return s;
    if (layer < 0) layer = encoding ? LAYER_HEIGHT : LAYER_COLOR;
    if ((layer == LAYER_HEIGHT) != (encoding != 0))
        return fault(at, "encoding",
                     layer ? "is one of heights" : "must say how heights are coded");
    out->layer = (enum tile_layer)layer;
    out->encoding = encoding > 2 ? ENCODING_TERRAIN_RGB : (enum tile_encoding)encoding;
    out->matrix.projection = (enum tile_projection)projection;
    return OK;
}

static status get_matrix(const struct place *at, const cJSON *doc, spec_layer *out)
{
    static const char *const schemes[] = {"xyz", "tms"};
    int scheme = 0, size = TILE_SIZE;
    tile_matrix *m = &out->matrix;
    m->max_level = DEFAULT_MAX_LEVEL;
    status s = get_choice(at, doc, "scheme", schemes, 2, &scheme);
    if (!s) s = get_integer(at, doc, "tileSize", 64, 1024, &size);
    if (!s) s = get_integer(at, doc, "minzoom", 0, MATRIX_MAX_LEVEL, &m->min_level);
    if (!s) s = get_integer(at, doc, "maxzoom", 0, MATRIX_MAX_LEVEL, &m->max_level);
    if (s) return s;
    if (size & (size - 1)) return fault(at, "tileSize", "is not a power of two");
    if (m->max_level < m->min_level) return fault(at, "maxzoom", "is below minzoom");
    if (m->projection == MATRIX_PLANET && (size != TILE_SIZE || m->max_level > GRID_MAX_ZOOM))
        return fault(at, "projection", "planet has tiles of 256 and zooms to 24");
    m->tile_size = size;
    out->from_south = scheme == 1;
    return OK;
}

static status get_bounds(const struct place *at, const cJSON *doc, spec_layer *out)
{
    double b[4] = {0};
    status s = get_numbers(at, doc, "bounds", 4, b);
    if (s) return s;
    if (b[0] < -180 || b[2] > 180 || b[1] < -90 || b[3] > 90 || b[1] > b[3])
        return fault(at, "bounds", "are not west, south, east, north in degrees");
    // Mercator's world is all there is of it.
    if (b[2] - b[0] >= 360 && b[3] >= 85 && b[1] <= -85) return OK;
    out->west = RAD(b[0]);
    out->south = RAD(b[1]);
    out->east = RAD(b[2]);
    out->north = RAD(b[3]);
    return OK;
}

static status get_layer(const struct place *at, const cJSON *doc, source_spec *out)
{
    if (!cJSON_IsObject(doc)) return fault(at, "layers", "is not a list of objects");
    if (out->count == LAYER_COUNT) return fault(at, "layers", "has more than three");
    const cJSON *extra = cJSON_GetObjectItemCaseSensitive(doc, "perigee");
    spec_layer *layer = &out->layers[out->count++];
    status s = get_template(at, doc, layer);
    if (!s) s = get_kind(at, doc, extra, layer);
    if (!s) s = get_matrix(at, doc, layer);
    if (!s) s = get_bounds(at, doc, layer);
    if (!s) s = get_ranges(at, extra, layer);
    if (s) return s;
    if (out->meta.max_zoom[layer->layer] >= 0) return fault(at, "layers", "has a layer twice");
    out->meta.max_zoom[layer->layer] = matrix_max_zoom(&layer->matrix);
    get_text(doc, "name", out->meta.name, sizeof out->meta.name);
    get_text(doc, "attribution", out->meta.attribution, sizeof out->meta.attribution);
    return OK;
}

// Heights of unknown range: those of the Earth and more.
static status get_planet(const struct place *at, const cJSON *extra, struct planet_meta *m)
{
    double radii[2] = {0}, range[2] = {-12000, 9000};
    status s = get_numbers(at, extra, "ellipsoid", 2, radii);
    if (!s) s = get_numbers(at, extra, "heightRange", 2, range);
    if (!s) s = get_number(at, extra, "synthesisGain", 0, 1, &m->synthesis_gain);
    if (!s && radii[0] != 0 &&
        !(radii[0] > 1e3 && radii[0] < 1e9 && radii[1] > 0.5 * radii[0] && radii[1] < 2 * radii[0]))
        s = fault(at, "ellipsoid", "is not two radii in metres");
    if (!s && !(range[0] <= range[1])) s = fault(at, "heightRange", "is empty");
    m->ellipsoid = (geo_ellipsoid){.a = radii[0], .b = radii[1]};
    m->height_min = range[0];
    m->height_max = range[1];
    return s;
}

static void spec_init(source_spec *out)
{
    *out = (source_spec){.meta = {.complete = true}};
    for (int i = 0; i < LAYER_COUNT; i++) out->meta.max_zoom[i] = -1;
}

status source_spec_parse(const char *text, size_t size, const char *origin, source_spec *out)
{
    struct place at = {origin};
    spec_init(out);
    cJSON *doc = cJSON_ParseWithLength(text, size);
    const cJSON *layers = cJSON_GetObjectItemCaseSensitive(doc, "layers"), *layer;
    status s = OK;
    if (!cJSON_IsObject(doc)) {
        log_error("%s: not a JSON object", origin);
        s = ERR_FORMAT;
    }
    get_text(doc, "name", out->meta.name, sizeof out->meta.name);
    get_text(doc, "attribution", out->meta.attribution, sizeof out->meta.attribution);
    if (!s) s = get_planet(&at, cJSON_GetObjectItemCaseSensitive(doc, "perigee"), &out->meta);
    if (!s && !cJSON_IsArray(layers)) s = get_layer(&at, doc, out);
    else if (!s) cJSON_ArrayForEach(layer, layers) if (!s) s = get_layer(&at, layer, out);
    if (!s && !out->count) s = fault(&at, "layers", "is empty");
    if (!out->meta.name[0]) snprintf(out->meta.name, sizeof out->meta.name, "%.63s", origin);
    cJSON_Delete(doc);
    if (s) source_spec_deinit(out);
    return s;
}

status source_spec_of_template(const char *url, enum tile_layer layer, source_spec *out)
{
    struct place at = {url};
    spec_init(out);
    status s = check_template(&at, url);
    if (s) return s;
    out->meta.height_min = -12000;
    out->meta.height_max = 9000;
    snprintf(out->meta.name, sizeof out->meta.name, "%.63s", url);
    out->count = 1;
    out->layers[0] = (spec_layer){
        .layer = layer,
        .url = absolute(url, ""),
        .matrix = {MATRIX_MERCATOR, TILE_SIZE, 0, layer == LAYER_HEIGHT ? 15 : DEFAULT_MAX_LEVEL},
        .encoding = layer == LAYER_HEIGHT ? ENCODING_TERRARIUM : ENCODING_IMAGE,
    };
    out->meta.max_zoom[layer] = matrix_max_zoom(&out->layers[0].matrix);
    return OK;
}

void source_spec_deinit(source_spec *spec)
{
    for (int i = 0; i < spec->count; i++) {
        free(spec->layers[i].url);
        free(spec->layers[i].ranges);
    }
    spec->count = 0;
}

// Appends a number in place of {...}; returns the rest of the template.
static const char *put_value(const spec_layer *l, const char *open, int level, int x, int y,
                             char *out, size_t *used)
{
    const char *close = strchr(open, '}');
    size_t length = (size_t)(close - open) + 1;
    int rows = 1 << level, value;
    if (l->matrix.projection == MATRIX_PLANET) rows = grid_rows(level);
    int south = rows - 1 - y;
    if (length == 3 && open[1] == 'x') value = x;
    else if (length == 3 && open[1] == 'z') value = level;
    else if (length == 3) value = l->from_south ? south : y;
    else if (open[1] == '-') value = south;
    else if (strncmp(open, "{TileMatrix}", length) == 0) value = level;
    else if (strncmp(open, "{TileCol}", length) == 0) value = x;
    else value = y;
    *used += (size_t)snprintf(out + *used, SPEC_URL_SIZE - *used, "%d", value);
    return close + 1;
}

void source_spec_url(const spec_layer *l, int level, int x, int y, char out[SPEC_URL_SIZE])
{
    size_t used = 0;
    for (const char *c = l->url; *c && used + 16 < SPEC_URL_SIZE;)
        if (*c == '{') c = put_value(l, c, level, x, y, out, &used);
        else out[used++] = *c++;
    out[used] = '\0';
}
