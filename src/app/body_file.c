#include "app/body_file.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <string.h>

#include "app/json_file.h"
#include "base/log.h"

// Radii of a planet in metres, and how flat one may be: beyond that the ring geometry's bounds do
// not hold.
#define RADIUS_MIN     1.0
#define RADIUS_MAX     1e9
#define AXIS_RATIO_MIN 0.5
#define AXIS_RATIO_MAX 1.0

static void set_name(const char *path, const char *given, char *name, size_t size)
{
    const char *slash = strrchr(path, '/');
    const char *base = slash ? slash + 1 : path;
    const char *dot = strrchr(base, '.');
    int length = dot && dot != base ? (int)(dot - base) : (int)strlen(base);
    if (given && given[0]) snprintf(name, size, "%s", given);
    else snprintf(name, size, "%.*s", length, base);
}

static status read_body(const char *path, const cJSON *root, geo_ellipsoid *out, char *name,
                        size_t name_size)
{
    static const char *const members[] = {"name", "equatorialRadius", "polarRadius"};
    struct json_place place = {path, ""};
    const char *given = NULL;
    geo_ellipsoid e = {.a = 0};
    status s = json_check_members(place, root, members, 3);
    if (!s) s = json_text(place, root, "name", &given);
    if (!s) s = json_number(place, root, "equatorialRadius", RADIUS_MIN, RADIUS_MAX, true, &e.a);
    e.b = e.a;
    if (!s) s = json_number(place, root, "polarRadius", RADIUS_MIN, RADIUS_MAX, false, &e.b);
    if (s) return s;
    if (e.b / e.a < AXIS_RATIO_MIN || e.b / e.a > AXIS_RATIO_MAX) {
        log_error("%s: \"polarRadius\" is %.12g, not in 0.5..1 equatorial radii", path, e.b);
        return ERR_FORMAT;
    }
    *out = e;
    set_name(path, given, name, name_size);
    return OK;
}

status body_file_load(const char *path, geo_ellipsoid *out, char *name, size_t name_size)
{
    cJSON *root;
    status s = json_file_load(path, &root);
    if (!s) s = read_body(path, root, out, name, name_size);
    cJSON_Delete(root);
    return s;
}
