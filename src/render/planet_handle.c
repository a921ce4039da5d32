#include "render/planet_handle.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/log.h"
#include "base/memory.h"

#define RAD(deg) ((deg) * (M_PI / 180))
#define DEG(rad) ((rad) * (180 / M_PI))

enum { FINEST_ZOOM = 20 }; // of the finest level

const char *perigee_version(void)
{
    return PERIGEE_VERSION;
}

const char *perigee_last_error(void)
{
    return log_last_error();
}

static enum tile_layer layer_of(enum perigee_layer_kind kind)
{
    return kind == PERIGEE_LAYER_HEIGHT  ? LAYER_HEIGHT
           : kind == PERIGEE_LAYER_COLOR ? LAYER_COLOR
                                         : LAYER_COUNT;
}

static status add_sources(perigee_planet *p, const char *path, const perigee_planet_params *params)
{
    status s = source_set_add(p->sources, path, LAYER_COUNT, 1);
    for (int i = 0; !s && i < params->layer_count; i++) {
        const perigee_layer *l = &params->layers[i];
        if (!(l->transparency >= 0 && l->transparency <= 1)) {
            log_error("%s: transparency %g: not in 0..1", l->source, l->transparency);
            return ERR_ARGUMENT;
        }
        s = source_set_add(p->sources, l->source, layer_of(l->kind), 1 - l->transparency);
    }
    return s;
}

perigee_status perigee_planet_open(const char *path, const perigee_planet_params *params,
                                   perigee_planet **out)
{
    static const perigee_planet_params none;
    if (!params) params = &none;
    perigee_planet *p = NEW(perigee_planet);
    pyramid_params tiles = {.synthesis = params->no_synthesis      ? SYNTHESIS_NONE
                                         : params->plain_synthesis ? SYNTHESIS_PLAIN
                                                                   : SYNTHESIS_ERODED,
                            .cache_bytes = params->cache_bytes};
    source_set_params sources = {.flat = params->flat,
                                 .disk_path = params->tile_cache,
                                 .disk_bytes = params->tile_cache_bytes};
    p->sources = source_set_create(&sources);
    status s = add_sources(p, path, params);
    if (!s) s = source_set_pyramid(p->sources, &tiles, &p->pyramid);
    if (s) perigee_planet_close(&p);
    *out = p;
    return (perigee_status)s;
}

void perigee_planet_close(perigee_planet **planet)
{
    perigee_planet *p = *planet;
    if (!p) return;
    pyramid_destroy(&p->pyramid);
    source_set_destroy(&p->sources);
    free(p);
    *planet = NULL;
}

void perigee_planet_get_info(const perigee_planet *planet, perigee_planet_info *out)
{
    const struct planet_meta *m = pyramid_meta(planet->pyramid);
    *out = (perigee_planet_info){.equatorial_radius_m = m->ellipsoid.a,
                                 .polar_radius_m = m->ellipsoid.b,
                                 .map_south_deg = DEG(m->ellipsoid.south),
                                 .map_north_deg = DEG(m->ellipsoid.north),
                                 .map_west_deg = DEG(m->ellipsoid.west),
                                 .map_east_deg = DEG(m->ellipsoid.east),
                                 .map_projected = source_set_map(planet->sources) != NULL,
                                 .height_min_m = m->height_min,
                                 .height_max_m = m->height_max,
                                 .height_zoom = m->max_zoom[LAYER_HEIGHT],
                                 .color_zoom = m->max_zoom[LAYER_COLOR],
                                 .night_zoom = m->max_zoom[LAYER_NIGHT]};
    snprintf(out->name, sizeof out->name, "%s", m->name);
    snprintf(out->attribution, sizeof out->attribution, "%s", m->attribution);
}

perigee_status perigee_planet_map_place(perigee_planet *planet, double *lat_deg, double *lon_deg)
{
    struct plane_map *map = source_set_map(planet->sources);
    double lat = *lat_deg, lon = *lon_deg;
    if (!map) return OK;
    plane_map_from_geographic(map, 1, &lat, &lon);
    if (!(fabs(lat) <= 90 && fabs(lon) <= 180)) {
        log_error("latitude %.10g, longitude %.10g: too far from the map of %s", *lat_deg, *lon_deg,
                  pyramid_meta(planet->pyramid)->name);
        return ERR_ARGUMENT;
    }
    *lat_deg = lat;
    *lon_deg = lon;
    return OK;
}

void perigee_planet_geographic(perigee_planet *planet, int count, double *lat_deg, double *lon_deg)
{
    struct plane_map *map = source_set_map(planet->sources);
    if (map) plane_map_to_geographic(map, count, lat_deg, lon_deg);
}

void perigee_planet_map_coordinates(const perigee_planet *planet, int count, double *lat_deg,
                                    double *lon_deg)
{
    struct plane_map *map = source_set_map(planet->sources);
    if (map) plane_map_coordinates(map, count, lat_deg, lon_deg);
}

perigee_status perigee_planet_height(perigee_planet *planet, double lat_deg, double lon_deg,
                                     double *height_m)
{
    *height_m = 0;
    if (!(fabs(lat_deg) <= 90) || !isfinite(lon_deg)) {
        log_error("no height at latitude %g, longitude %g: not a place", lat_deg, lon_deg);
        return ERR_ARGUMENT;
    }
    return (perigee_status)pyramid_height_at(planet->pyramid, FINEST_ZOOM, RAD(lat_deg),
                                             geo_wrap_lon(RAD(lon_deg)), height_m);
}

bool perigee_planet_height_now(perigee_planet *planet, double lat_deg, double lon_deg,
                               double *height_m)
{
    int zoom = -1;
    if (fabs(lat_deg) <= 90 && isfinite(lon_deg))
        zoom = pyramid_height_held(planet->pyramid, FINEST_ZOOM, RAD(lat_deg),
                                   geo_wrap_lon(RAD(lon_deg)), height_m);
    if (zoom < 0) *height_m = NAN;
    return zoom == FINEST_ZOOM;
}

void perigee_planet_stop_waiting(perigee_planet *planet)
{
    pyramid_give_up(planet->pyramid);
}
