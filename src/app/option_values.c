#include "app/option_values.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "app/body_file.h"
#include "app/camera_string.h"
#include "app/number.h"
#include "base/log.h"
#include "geo/sun.h"
#include "reference/sight.h"

enum {
    SIZE_MAX_PX = 16384,
    GRID_MAX_CELLS = 64,
    SCREEN_GRID_MAX = 4096,
    SCREEN_GRID_VERTICES_MAX = 1 << 22,
    LEVEL_MAX = 23,
    AZIMUTH_MAX = 4096,
    RINGS_MAX = 512
};

static status refuse(const char *name, const char *value, const char *wanted)
{
    log_error("--%s %s: not %s", name, value, wanted);
    return ERR_ARGUMENT;
}

// Two whole numbers with one character between them.
static bool parse_pair(const char *text, char separator, int low, int high, int out[2])
{
    const char *middle = strchr(text, separator);
    char first[16];
    long long a, b;
    if (!middle || (size_t)(middle - text) >= sizeof first) return false;
    memcpy(first, text, (size_t)(middle - text));
    first[middle - text] = '\0';
    if (!number_parse_integer(first, &a) || !number_parse_integer(middle + 1, &b)) return false;
    if (a < low || a > high || b < low || b > high) return false;
    out[0] = (int)a;
    out[1] = (int)b;
    return true;
}

status option_camera(struct options *o, const char *name, const char *value)
{
    (void)name;
    return camera_string_parse(value, &o->camera);
}

status option_time(struct options *o, const char *name, const char *value)
{
    o->time_given = strcmp(value, "noon") != 0;
    if (o->time_given && geo_time_parse(value, &o->unix_time_s) != 0)
        return refuse(name, value, "noon nor a time such as 2026-06-21T10:00Z");
    return OK;
}

status option_size(struct options *o, const char *name, const char *value)
{
    int size[2];
    if (!parse_pair(value, 'x', 1, SIZE_MAX_PX, size))
        return refuse(name, value, "WxH with 1..16384 each");
    o->width = size[0];
    o->height = size[1];
    return OK;
}

status option_grid(struct options *o, const char *name, const char *value)
{
    int size[2];
    if (!parse_pair(value, 'x', 1, GRID_MAX_CELLS, size))
        return refuse(name, value, "NxM with 1..64 each");
    o->sheet_columns = size[0];
    o->sheet_rows = size[1];
    return OK;
}

status option_screen_grid(struct options *o, const char *name, const char *value)
{
    int size[2];
    if (!parse_pair(value, 'x', 2, SCREEN_GRID_MAX, size))
        return refuse(name, value, "ROWSxCOLUMNS with 2..4096 each");
    if (size[0] * size[1] > SCREEN_GRID_VERTICES_MAX)
        return refuse(name, value, "ROWSxCOLUMNS with up to 4194304 vertices in all");
    o->view_params.grid_rows = size[0];
    o->view_params.grid_columns = size[1];
    return OK;
}

// The index of value among count names, or -1.
static int find_name(const char *value, const char *const *names, int count)
{
    for (int i = 0; i < count; i++)
        if (strcmp(value, names[i]) == 0) return i;
    return -1;
}

status option_transform(struct options *o, const char *name, const char *value)
{
    static const char *const names[] = {"stable", "exact", "approx", "blend"};
    int found = find_name(value, names, 4);
    if (found < 0) return refuse(name, value, "stable, exact, approx or blend");
    o->view_params.transform = (enum perigee_transform)found;
    return OK;
}

status option_planar_form(struct options *o, const char *name, const char *value)
{
    static const char *const names[] = {"gpu", "2004"};
    int found = find_name(value, names, 2);
    if (found < 0) return refuse(name, value, "gpu or 2004");
    o->view_params.planar_form = (enum perigee_planar_form)found;
    return OK;
}

status option_planar_heights(struct options *o, const char *name, const char *value)
{
    static const char *const names[] = {"plain", "packed"};
    int found = find_name(value, names, 2);
    if (found < 0) return refuse(name, value, "plain or packed");
    o->view_params.planar_packed = found == 1;
    return OK;
}

status option_quality(struct options *o, const char *name, const char *value)
{
    static const char *const names[] = {"default", "low", "high", "paper"};
    int found = find_name(value, names, 4);
    if (found < 0) return refuse(name, value, "low, default, high or paper");
    o->view_params.quality = (enum perigee_quality)found;
    return OK;
}

status option_texels(struct options *o, const char *name, const char *value)
{
    long long n;
    if (!number_parse_integer(value, &n) || n < 128 || n > 1024 || (n & (n - 1)))
        return refuse(name, value, "128, 256, 512 or 1024");
    o->view_params.texels = (int)n;
    return OK;
}

status option_planar_n(struct options *o, const char *name, const char *value)
{
    long long n;
    if (!number_parse_integer(value, &n) || n < 31 || n > 1023 || (n & (n + 1)))
        return refuse(name, value, "31, 63, 127, 255, 511 or 1023");
    o->view_params.planar_n = (int)n;
    return OK;
}

status option_filter(struct options *o, const char *name, const char *value)
{
    static const char *const names[] = {"sharp", "emulated", "hardware"};
    int found = find_name(value, names, 3);
    if (found < 0) return refuse(name, value, "sharp, emulated or hardware");
    o->view_params.filter = (enum perigee_filter)(PERIGEE_FILTER_SHARP + found);
    return OK;
}

// "auto", a width in metres with an "m", or a number of samples.
status option_feather(struct options *o, const char *name, const char *value)
{
    char text[32];
    size_t length = strlen(value);
    double width = 0;
    bool automatic = strcmp(value, "auto") == 0;
    bool metres = !automatic && length > 1 && length < sizeof text && value[length - 1] == 'm';
    snprintf(text, sizeof text, "%s", value);
    if (metres) text[length - 1] = '\0';
    bool good =
        automatic ||
        (number_parse(text, &width) && width >= 0 &&
         (metres ? width > 0 && width <= FEATHER_MOST_M : width <= 255 && width == floor(width)));
    if (!good) return refuse(name, value, "auto, a width as 500m, or 0 to 255 samples");
    o->feather_rows = automatic || metres ? FEATHER_ROWS : (int)width;
    o->feather_m = automatic ? FEATHER_AUTO : metres ? width : 0;
    return OK;
}

status option_codec(struct options *o, const char *name, const char *value)
{
    static const char *const names[] = {"lossless", "exact", "bounded"};
    int found = find_name(value, names, 3);
    if (found < 0) return refuse(name, value, "lossless, exact or bounded");
    o->codec = (enum option_codec)found;
    return OK;
}

status option_texcoord(struct options *o, const char *name, const char *value)
{
    static const char *const names[] = {"fragment", "vertex"};
    int found = find_name(value, names, 2);
    if (found < 0) return refuse(name, value, "vertex or fragment");
    o->view_params.texcoord_vertex = found == 1;
    return OK;
}

int option_mode_find(const char *name)
{
    if (strcmp(name, "reference") == 0) return MODE_REFERENCE;
    const char *known;
    for (int i = 0; (known = perigee_mode_name((enum perigee_mode)i)); i++)
        if (strcmp(name, known) == 0) return i;
    return -1;
}

const char *option_mode_names(char *text, size_t size)
{
    size_t used = 0;
    const char *known;
    for (int i = 0; (known = perigee_mode_name((enum perigee_mode)i)) && used < size; i++)
        used += (size_t)snprintf(text + used, size - used, "%s%s", i ? ", " : "", known);
    return text;
}

status option_mode(struct options *o, const char *name, const char *value)
{
    bool view = o->command == COMMAND_VIEW;
    int found = option_mode_find(value);
    if (found < 0 || (found == MODE_REFERENCE && view)) {
        char names[128], wanted[192];
        snprintf(wanted, sizeof wanted,
                 view ? "%s (reference: perigee render and fly only)" : "%s or reference",
                 option_mode_names(names, sizeof names));
        return refuse(name, value, wanted);
    }
    o->reference = found == MODE_REFERENCE;
    if (!o->reference) o->view_params.mode = (enum perigee_mode)found;
    return OK;
}

status option_synthesis(struct options *o, const char *name, const char *value)
{
    static const char *const names[] = {"eroded", "plain", "none"};
    int found = find_name(value, names, 3);
    if (found < 0) return refuse(name, value, "eroded, plain or none");
    o->planet_params.plain_synthesis = found == 1;
    o->planet_params.no_synthesis = found == 2;
    return OK;
}

status option_zoom(struct options *o, const char *name, const char *value)
{
    static const char *const names[] = {"auto", "stored"};
    int found = find_name(value, names, 2);
    long long zoom = found == 1 ? SIGHT_STORED : SIGHT_AUTO;
    if (found < 0 && (!number_parse_integer(value, &zoom) || zoom < 0 || zoom > GRID_MAX_ZOOM))
        return refuse(name, value, "auto, stored or a zoom, 0..24");
    o->zoom = (int)zoom;
    o->zoom_given = true;
    return OK;
}

status option_heights(struct options *o, const char *name, const char *value)
{
    static const char *const names[] = {"bilinear", "bicubic"};
    int found = find_name(value, names, 2);
    if (found < 0) return refuse(name, value, "bilinear or bicubic");
    o->bicubic = found == 1;
    o->heights_given = true;
    return OK;
}

status option_equal(struct options *o, const char *name, const char *value)
{
    static const char *const names[] = {"triangles", "error"};
    static const double lows[] = {100, 1e-4}, highs[] = {2e9, 1000};
    size_t length = strcspn(value, "=");
    for (int i = 0; i < 2; i++) {
        if (strncmp(value, names[i], length) != 0 || names[i][length]) continue;
        o->equal = (enum option_equal)(EQUAL_TRIANGLES + i);
        o->equal_value = NAN;
        if (!value[length]) return OK;
        if (number_parse(value + length + 1, &o->equal_value) && o->equal_value >= lows[i] &&
            o->equal_value <= highs[i])
            return OK;
    }
    return refuse(name, value,
                  "triangles, error, triangles=N with 100..2e9, or error=PX with 1e-4..1000");
}

status option_levels(struct options *o, const char *name, const char *value)
{
    int range[2];
    if (!parse_pair(value, '-', 0, LEVEL_MAX, range) || range[0] > range[1] || range[1] == 0)
        return refuse(name, value, "A-B with 0 <= A <= B, 1 <= B <= 23");
    o->view_params.first_level = range[0];
    o->view_params.last_level = range[1];
    return OK;
}

status option_azimuth_steps(struct options *o, const char *name, const char *value)
{
    long long n;
    if (!number_parse_integer(value, &n) || n < 64 || n > AZIMUTH_MAX || n % 64 != 0)
        return refuse(name, value, "a multiple of 64 in 64..4096");
    o->view_params.azimuth_steps = (int)n;
    return OK;
}

status option_rings(struct options *o, const char *name, const char *value)
{
    long long m;
    if (!number_parse_integer(value, &m) || m < 2 || m > RINGS_MAX || m % 2 != 0)
        return refuse(name, value, "an even number in 2..512");
    o->view_params.rings_per_level = (int)m;
    return OK;
}

static status parse_bytes(const char *name, const char *value, uint64_t *out)
{
    static const char units[] = "KMG";
    char digits[24];
    size_t length = strlen(value);
    const char *unit = length ? strchr(units, value[length - 1]) : NULL;
    if (length == 0 || length >= sizeof digits) return refuse(name, value, "a number of bytes");
    memcpy(digits, value, length + 1);
    if (unit) digits[length - 1] = '\0';
    int shift = unit ? 10 * (int)(unit - units + 1) : 0;
    long long n;
    if (!number_parse_integer(digits, &n) || n < 1 || n > (1LL << (40 - shift)))
        return refuse(name, value, "a number of bytes from 1 to 1024G, such as 256M");
    *out = (uint64_t)n << shift;
    return OK;
}

status option_bytes(struct options *o, const char *name, const char *value)
{
    uint64_t bytes = 0;
    status s = parse_bytes(name, value, &bytes);
    if (!s) o->planet_params.cache_bytes = (size_t)bytes;
    return s;
}

status option_tile_bytes(struct options *o, const char *name, const char *value)
{
    return parse_bytes(name, value, &o->planet_params.tile_cache_bytes);
}

status option_bounds(struct options *o, const char *name, const char *value)
{
    double b[4];
    bool good = number_parse_list(value, ',', b, 4) == 4 && fabs(b[0]) <= 360 &&
                fabs(b[2]) <= 360 && b[0] != b[2] && b[2] - b[0] <= 360 && b[1] >= -90 &&
                b[1] < b[3] && b[3] <= 90;
    if (!good)
        return refuse(name, value, "W,S,E,N in degrees with W other than E and -90 <= S < N <= 90");
    memcpy(o->bounds_deg, b, sizeof b);
    return OK;
}

status option_body(struct options *o, const char *name, const char *value)
{
    static const char *const names[] = {"earth", "moon", "mars"};
    static const char *const titles[] = {"Earth", "Moon", "Mars"};
    static const geo_ellipsoid ellipsoids[] = {
        {.a = 6378137.0, .b = 6356752.314245179}, // WGS84
        {.a = 1737400.0, .b = 1737400.0},         // IAU 2015
        {.a = 3396190.0, .b = 3376200.0},         // IAU 2015
    };
    int found = find_name(value, names, 3);
    if (found >= 0) {
        o->ellipsoid = ellipsoids[found];
        o->body_name = titles[found];
        return OK;
    }
    if (access(value, F_OK) != 0)
        return refuse(name, value, "earth, moon, mars or a JSON file that is there");
    status s = body_file_load(value, &o->ellipsoid, o->body_text, sizeof o->body_text);
    if (!s) o->body_name = o->body_text;
    return s;
}

static status set_layer(struct options *o, enum tile_layer layer, const char *value)
{
    o->source_layer = layer;
    return value ? option_add_source(o, value) : OK;
}

status option_height_layer(struct options *o, const char *name, const char *value)
{
    (void)name;
    return set_layer(o, LAYER_HEIGHT, value);
}

status option_color_layer(struct options *o, const char *name, const char *value)
{
    (void)name;
    return set_layer(o, LAYER_COLOR, value);
}

status option_night_layer(struct options *o, const char *name, const char *value)
{
    (void)name;
    return set_layer(o, LAYER_NIGHT, value);
}

status option_vertical(struct options *o, const char *name, const char *value)
{
    static const char *const names[] = {"ellipsoid", "egm96", "egm2008", "declared"};
    long long code = 0;
    int found = find_name(value, names, 4);
    bool is_code = strncmp(value, "EPSG:", 5) == 0 && number_parse_integer(value + 5, &code) &&
                   code >= 1 && code <= 999999;
    if (found < 0 && !is_code)
        return refuse(name, value, "declared, ellipsoid, egm96, egm2008 or EPSG:n");
    o->source_vertical = found == 3 ? NULL : value;
    return OK;
}

status option_add_source(struct options *o, const char *path)
{
    if (o->source_layer == LAYER_COUNT) {
        log_error("%s: --height, --color or --night must come before it and say what it is", path);
        return ERR_ARGUMENT;
    }
    o->sources[o->source_count++] = (import_source){.layer = o->source_layer,
                                                    .path = path,
                                                    .vertical = o->source_vertical,
                                                    .priority = o->source_priority};
    return OK;
}
