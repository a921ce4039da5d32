#include "app/camera_json.h"

#include <cjson/cJSON.h>

#include "app/camera_string.h"
#include "base/log.h"

static status read_place(struct json_place at, const cJSON *object, perigee_camera *c,
                         bool *above_ground)
{
    bool has_alt = cJSON_GetObjectItemCaseSensitive(object, "alt") != NULL;
    *above_ground = cJSON_GetObjectItemCaseSensitive(object, "aboveGround") != NULL;
    status s = json_number(at, object, "lat", -90, 90, true, &c->lat_deg);
    if (!s) s = json_number(at, object, "lon", -360, 360, true, &c->lon_deg);
    if (!s && has_alt == *above_ground) {
        log_error("%s: %s: exactly one of \"alt\" and \"aboveGround\" is needed", at.path,
                  at.where);
        s = ERR_FORMAT;
    }
    if (s) return s;
    return json_number(at, object, has_alt ? "alt" : "aboveGround", CAMERA_JSON_ALT_MIN,
                       CAMERA_ALT_MAX, true, &c->alt_m);
}

status camera_json_read(struct json_place at, const cJSON *object, perigee_camera *out,
                        bool *above_ground)
{
    status s = read_place(at, object, out, above_ground);
    if (!s) s = json_number(at, object, "heading", -360, 360, true, &out->heading_deg);
    if (!s) s = json_number(at, object, "pitch", -90, 90, true, &out->pitch_deg);
    if (!s) s = json_number(at, object, "roll", -180, 180, false, &out->roll_deg);
    if (s) return s;
    return json_number(at, object, "fov", CAMERA_FOV_MIN, CAMERA_FOV_MAX, false, &out->fov_deg);
}
