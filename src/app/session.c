#include "app/session.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "app/camera_string.h"
#include "app/default_earth.h"
#include "app/layers.h"
#include "app/output_file.h"
#include "base/log.h"
#include "base/vec.h"
#include "gpu/context.h"
#include "gpu/program.h"

static status check_shader_dir(const char *folder)
{
    struct stat info;
    if (!folder || (stat(folder, &info) == 0 && S_ISDIR(info.st_mode))) return OK;
    log_error("--shader-dir %s: no such folder", folder);
    return ERR_ARGUMENT;
}

status session_open_planet(const struct options *o, struct session *out)
{
    *out = (struct session){.options = o};
    char earth[OUTPUT_PATH_SIZE];
    status s = check_shader_dir(o->shader_dir);
    if (!s && !o->planet) s = default_earth_find(o, earth, sizeof earth);
    if (s) return s;
    s = layers_open_planet(o, o->planet ? o->planet : earth, &out->planet);
    if (s) return s;
    perigee_planet_get_info(out->planet, &out->info);
    return OK;
}

void session_credit(const struct session *s)
{
    if (s->info.attribution[0]) log_info("%s: %s", s->info.name, s->info.attribution);
}

status session_open_gpu(struct session *s)
{
    status result = gpu_context_create(&s->gpu);
    if (!result) gpu_program_set_dir(s->options->shader_dir);
    return result;
}

status session_open_view(struct session *s)
{
    const struct options *o = s->options;
    status result = session_open_gpu(s);
    if (result) return result;
    result = (status)perigee_view_create(s->planet, &o->view_params, &s->view);
    if (!result && o->time_given) result = (status)perigee_view_set_time(s->view, o->unix_time_s);
    if (result) return result;
    session_credit(s);
    perigee_stats stats;
    perigee_view_get_stats(s->view, &stats);
    log_info("GPU memory: %.1f MiB for terrain and geometry", (double)stats.gpu_bytes / 0x1p20);
    return OK;
}

void session_close(struct session *s)
{
    if (s->view) perigee_view_destroy(&s->view);
    gpu_context_destroy(&s->gpu);
    if (s->planet) perigee_planet_close(&s->planet);
}

static double given_or(double value, double otherwise)
{
    return isnan(value) ? otherwise : value;
}

static status place_over_ground(const struct session *s, perigee_camera *c)
{
    const struct options *o = s->options;
    double ground;
    if (isnan(o->above_ground_m) && c->alt_m > s->info.height_max_m) return OK;
    status result = (status)perigee_planet_height(s->planet, c->lat_deg, c->lon_deg, &ground);
    if (result) return result;
    if (!isnan(o->above_ground_m)) c->alt_m = ground + o->above_ground_m;
    if (c->alt_m > ground) return OK;
    log_error("--alt %.10g: below the terrain, which is %.1f m high there (--above-ground counts "
              "from it)",
              c->alt_m, ground);
    return ERR_ARGUMENT;
}

// So high that the map is seen whole from over its middle.
static status rise_over_map(const struct session *s, perigee_camera *c)
{
    double ground;
    const perigee_planet_info *i = &s->info;
    double half = fmax(-i->map_south_deg, i->map_east_deg) * (M_PI / 180) * i->equatorial_radius_m;
    status failed = (status)perigee_planet_height(s->planet, c->lat_deg, c->lon_deg, &ground);
    if (!failed) c->alt_m = ground + 2 * half;
    return failed;
}

static status default_over_map(const struct session *s, perigee_camera *c)
{
    c->lat_deg = c->lon_deg = 0;
    return isnan(s->options->camera.alt_m) ? rise_over_map(s, c) : OK;
}

status session_place(const struct session *s, perigee_camera *c)
{
    return (status)perigee_planet_map_place(s->planet, &c->lat_deg, &c->lon_deg);
}

perigee_camera session_geographic(const struct session *s, const perigee_camera *camera)
{
    perigee_camera c = *camera;
    perigee_planet_geographic(s->planet, 1, &c.lat_deg, &c.lon_deg);
    return c;
}

bool session_map_coordinates(const struct session *s, const perigee_camera *camera, double *easting,
                             double *northing)
{
    bool projected = s->planet && s->info.map_projected;
    *northing = projected ? camera->lat_deg : NAN;
    *easting = projected ? camera->lon_deg : NAN;
    if (projected) perigee_planet_map_coordinates(s->planet, 1, northing, easting);
    return projected;
}

status session_tell_places(const struct session *s, size_t count, double *lat_deg, double *lon_deg,
                           double **coordinates)
{
    *coordinates = NULL;
    if (!s->info.map_projected) return OK;
    double *easting = calloc(count, 2 * sizeof *easting), *northing = easting + count;
    if (!easting) {
        log_error("out of memory for the places of %zu pixels", count);
        return ERR_MEMORY;
    }
    memcpy(easting, lon_deg, count * sizeof *easting);
    memcpy(northing, lat_deg, count * sizeof *northing);
    perigee_planet_map_coordinates(s->planet, (int)count, northing, easting);
    perigee_planet_geographic(s->planet, (int)count, lat_deg, lon_deg);
    *coordinates = easting;
    return OK;
}

// The camera's place is given, its height perhaps not.
static status place_on_map(const struct session *s, perigee_camera *c)
{
    const perigee_planet_info *i = &s->info;
    perigee_camera given = *c;
    status failed = session_place(s, c);
    if (failed) return failed;
    double lat = clamp_double(c->lat_deg, i->map_south_deg, i->map_north_deg),
           lon = clamp_double(c->lon_deg, i->map_west_deg, i->map_east_deg);
    double off_deg = hypot(c->lat_deg - lat, c->lon_deg - lon);
    if (off_deg > 0)
        log_warn("latitude %.10g, longitude %.10g: %.1f km off the map", given.lat_deg,
                 given.lon_deg, off_deg * (M_PI / 180) * i->equatorial_radius_m / 1e3);
    return isnan(s->options->camera.alt_m) ? rise_over_map(s, c) : OK;
}

status session_camera(const struct session *s, perigee_camera *out)
{
    const perigee_camera *c = &s->options->camera;
    *out = (perigee_camera){
        .lat_deg = given_or(c->lat_deg, 20),
        .lon_deg = remainder(given_or(c->lon_deg, 10), 360),
        .alt_m = given_or(c->alt_m, M_PI * s->info.equatorial_radius_m),
        .heading_deg = given_or(c->heading_deg, 0),
        .pitch_deg = given_or(c->pitch_deg, -90),
        .roll_deg = given_or(c->roll_deg, 0),
        .fov_deg = given_or(c->fov_deg, 60),
    };
    if (!s->info.map_projected) return place_over_ground(s, out);
    bool middle = isnan(c->lat_deg) && isnan(c->lon_deg);
    status placed = middle ? default_over_map(s, out) : place_on_map(s, out);
    return placed ? placed : place_over_ground(s, out);
}

status session_wait(const struct session *s, int width, int height)
{
    const struct options *o = s->options;
    if (o->no_wait) return OK;
    return (status)perigee_view_wait(s->view, width, height, o->timeout_s);
}

int session_texts(const struct session *s, const perigee_camera *camera,
                  char line[SESSION_CAMERA_SIZE], struct image_text texts[SESSION_TEXTS])
{
    perigee_camera geographic = session_geographic(s, camera);
    camera_string_format(&geographic, line, SESSION_CAMERA_SIZE);
    texts[0] = (struct image_text){"Software", "Perigee"};
    texts[1] = (struct image_text){"Camera", line};
    texts[2] = (struct image_text){"Source", s->info.attribution};
    return s->info.attribution[0] ? 3 : 2;
}
