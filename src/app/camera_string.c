#include "app/camera_string.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "app/number.h"
#include "base/log.h"

struct field {
    const char *name;
    size_t offset;
    double low, high;
};

// In the order of the comma form.
static const struct field fields[] = {
    {"lat", offsetof(perigee_camera, lat_deg), -90, 90},
    {"lon", offsetof(perigee_camera, lon_deg), -360, 360},
    {"alt", offsetof(perigee_camera, alt_m), CAMERA_ALT_MIN, CAMERA_ALT_MAX},
    {"heading", offsetof(perigee_camera, heading_deg), -360, 360},
    {"pitch", offsetof(perigee_camera, pitch_deg), -90, 90},
    {"roll", offsetof(perigee_camera, roll_deg), -180, 180},
    {"fov", offsetof(perigee_camera, fov_deg), CAMERA_FOV_MIN, CAMERA_FOV_MAX},
};

enum { FIELD_COUNT = sizeof fields / sizeof fields[0] };

static status set_field(const char *text, const struct field *f, double value,
                        perigee_camera *camera)
{
    if (!(value >= f->low && value <= f->high)) {
        log_error("camera '%s': %s %.12g is not in %g..%g", text, f->name, value, f->low, f->high);
        return ERR_ARGUMENT;
    }
    *(double *)((char *)camera + f->offset) = value;
    return OK;
}

static status set_list(const char *text, const char *list, int least, int most,
                       perigee_camera *camera)
{
    double values[FIELD_COUNT];
    int count = number_parse_list(list, ',', values, most);
    if (count < least || count == 4) {
        log_error("camera '%s': not lat,lon,alt[,heading,pitch[,roll[,fov]]] nor "
                  "geo:lat,lon,alt;heading=..;pitch=..",
                  text);
        return ERR_ARGUMENT;
    }
    status s = OK;
    for (int i = 0; i < count && !s; i++) s = set_field(text, &fields[i], values[i], camera);
    return s;
}

static status set_parameter(const char *text, const char *parameter, perigee_camera *camera)
{
    if (strcasecmp(parameter, "crs=wgs84") == 0) return OK;
    const char *equals = strchr(parameter, '=');
    size_t length = equals ? (size_t)(equals - parameter) : 0;
    for (int i = 3; i < FIELD_COUNT && equals; i++) {
        if (strlen(fields[i].name) != length || strncasecmp(parameter, fields[i].name, length) != 0)
            continue;
        double value;
        if (number_parse(equals + 1, &value)) return set_field(text, &fields[i], value, camera);
    }
    log_error("camera '%s': '%s' is not heading=, pitch=, roll= or fov= and a number", text,
              parameter);
    return ERR_ARGUMENT;
}

static status parse_uri(const char *text, perigee_camera *camera)
{
    char copy[CAMERA_STRING_SIZE];
    if (strlen(text) >= sizeof copy) {
        log_error("camera '%.40s...': longer than %d characters", text, CAMERA_STRING_SIZE - 1);
        return ERR_ARGUMENT;
    }
    strcpy(copy, text + strlen("geo:"));
    char *rest = copy;
    const char *part = strsep(&rest, ";");
    status s = set_list(text, part, 2, 3, camera);
    while (!s && (part = strsep(&rest, ";")) != NULL) s = set_parameter(text, part, camera);
    return s;
}

status camera_string_parse(const char *text, perigee_camera *camera)
{
    perigee_camera c = *camera;
    status s = strncasecmp(text, "geo:", 4) == 0 ? parse_uri(text, &c)
                                                 : set_list(text, text, 3, FIELD_COUNT, &c);
    if (!s) *camera = c;
    return s;
}

void camera_string_format(const perigee_camera *c, char *text, size_t size)
{
    snprintf(text, size, "%.9f,%.9f,%.3f,%.6f,%.6f,%.6f,%.6f", c->lat_deg, c->lon_deg, c->alt_m,
             c->heading_deg, c->pitch_deg, c->roll_deg, c->fov_deg > 0 ? c->fov_deg : 60.0);
}
