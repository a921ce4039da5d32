#include "app/path_file.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>

#include "app/camera_json.h"
#include "app/camera_string.h"
#include "app/json_file.h"
#include "base/log.h"
#include "base/memory.h"
#include "geo/sun.h"

enum { MAX_KEYS = 10000 };

#define TIME_MAX_S 1e6
#define DEG        (M_PI / 180)

static status read_key(struct json_place at, const cJSON *object, double fov_deg,
                       struct path_key *key)
{
    static const char *const members[] = {"time",    "lat",   "lon",  "alt", "aboveGround",
                                          "heading", "pitch", "roll", "fov"};
    key->camera.fov_deg = fov_deg;
    status s = json_check_object(at, object);
    if (!s) s = json_check_members(at, object, members, sizeof members / sizeof members[0]);
    if (!s) s = json_number(at, object, "time", 0, TIME_MAX_S, true, &key->time_s);
    return s ? s : camera_json_read(at, object, &key->camera, &key->above_ground);
}

static status read_keys(const char *path, const cJSON *keys, double fov_deg, struct path_file *out)
{
    int count = cJSON_IsArray(keys) ? cJSON_GetArraySize(keys) : 0;
    if (count < 1 || count > MAX_KEYS) {
        log_error("%s: \"keys\" is not a list of 1 to %d views", path, MAX_KEYS);
        return ERR_FORMAT;
    }
    out->keys = NEW_ARRAY(struct path_key, (size_t)count);
    const cJSON *object;
    status s = OK;
    cJSON_ArrayForEach(object, keys)
    {
        char where[32];
        struct path_key *key = &out->keys[out->count];
        snprintf(where, sizeof where, "key %d", ++out->count);
        s = read_key((struct json_place){path, where}, object, fov_deg, key);
        if (s) break;
        if (out->count > 1 && key->time_s <= key[-1].time_s) {
            log_error("%s: %s: \"time\" %g does not come after %g", path, where, key->time_s,
                      key[-1].time_s);
            s = ERR_FORMAT;
            break;
        }
    }
    return s;
}

static status read_time(const char *path, const char *text, struct path_file *out)
{
    if (!text) return OK;
    out->time_given = true;
    if (geo_time_parse(text, &out->unix_time_s) == 0) return OK;
    log_error("%s: \"time\" is '%.40s', not a time such as 2026-06-21T10:00Z", path, text);
    return ERR_FORMAT;
}

static status read_root(const char *path, const cJSON *root, struct path_file *out)
{
    static const char *const members[] = {"name", "fov", "time", "keys"};
    struct json_place at = {path, ""};
    const char *name, *time;
    double fov_deg = CAMERA_JSON_FOV;
    status s = json_check_members(at, root, members, sizeof members / sizeof members[0]);
    if (!s) s = json_text(at, root, "name", &name);
    if (!s) s = json_text(at, root, "time", &time);
    if (!s) s = json_number(at, root, "fov", CAMERA_FOV_MIN, CAMERA_FOV_MAX, false, &fov_deg);
    if (!s) s = read_time(path, time, out);
    if (s) return s;
    snprintf(out->name, sizeof out->name, "%s", name ? name : path);
    snprintf(out->path, sizeof out->path, "%s", path);
    return read_keys(path, cJSON_GetObjectItemCaseSensitive(root, "keys"), fov_deg, out);
}

status path_file_load(const char *path, struct path_file *out)
{
    *out = (struct path_file){0};
    cJSON *root;
    status s = json_file_load(path, &root);
    if (!s) s = read_root(path, root, out);
    if (s) path_file_deinit(out);
    cJSON_Delete(root);
    return s;
}

void path_file_deinit(struct path_file *file)
{
    free(file->keys);
    *file = (struct path_file){0};
}

static status resolve(const struct path_file *file, int i, perigee_planet *planet, flight_key *out)
{
    const struct path_key *key = &file->keys[i];
    perigee_camera placed = key->camera, *c = &placed;
    double ground = 0;
    status s = (status)perigee_planet_map_place(planet, &c->lat_deg, &c->lon_deg);
    if (s) return s;
    if (key->above_ground)
        s = (status)perigee_planet_height(planet, c->lat_deg, c->lon_deg, &ground);
    if (s) return s;
    double altitude = c->alt_m + ground;
    if (altitude < CAMERA_JSON_ALT_MIN) {
        log_error("%s: key %d: \"aboveGround\" %g is %.1f m above the ellipsoid, less than %g m",
                  file->path, i + 1, c->alt_m, altitude, CAMERA_JSON_ALT_MIN);
        return ERR_FORMAT;
    }
    *out = (flight_key){
        .time_s = key->time_s - file->keys[0].time_s,
        .camera = {.position = {c->lat_deg * DEG, geo_wrap_lon(c->lon_deg * DEG), altitude},
                   .heading = c->heading_deg * DEG,
                   .pitch = c->pitch_deg * DEG,
                   .roll = c->roll_deg * DEG,
                   .fov_y = c->fov_deg * DEG},
    };
    return OK;
}

status path_file_flight(const struct path_file *file, perigee_planet *planet, struct flight **out)
{
    perigee_planet_info info;
    perigee_planet_get_info(planet, &info);
    flight_key *keys = NEW_ARRAY(flight_key, (size_t)file->count);
    status s = OK;
    for (int i = 0; i < file->count && !s; i++) s = resolve(file, i, planet, &keys[i]);
    geo_ellipsoid e = {.a = info.equatorial_radius_m, .b = info.polar_radius_m};
    *out = s ? NULL : flight_create(e, keys, file->count);
    free(keys);
    if (!s && !*out) {
        log_error("%s: not a flight over %s", file->path, info.name);
        s = ERR_FORMAT;
    }
    return s;
}

static double in_range(double degrees, double limit)
{
    return clamp_double(degrees, -limit, limit);
}

status path_file_camera(const struct flight *flight, perigee_planet *planet, double time_s,
                        perigee_camera *out)
{
    geo_camera c = flight_at(flight, time_s);
    *out = (perigee_camera){.lat_deg = in_range(c.position.lat / DEG, 90),
                            .lon_deg = in_range(c.position.lon / DEG, 180),
                            .alt_m = c.position.height,
                            .heading_deg = c.heading / DEG,
                            .pitch_deg = in_range(c.pitch / DEG, 90),
                            .roll_deg = c.roll / DEG,
                            .fov_deg = c.fov_y / DEG};
    perigee_planet_info info;
    perigee_planet_get_info(planet, &info);
    if (out->alt_m > info.height_max_m + PATH_CLEARANCE_M) return OK;
    double ground;
    status s = (status)perigee_planet_height(planet, out->lat_deg, out->lon_deg, &ground);
    if (!s && out->alt_m < ground + PATH_CLEARANCE_M) out->alt_m = ground + PATH_CLEARANCE_M;
    return s;
}
