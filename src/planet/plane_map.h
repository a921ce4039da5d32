// The map of a raster in a projected reference system, as the store holds it: its metres over a
// radius, as if they were longitude and latitude about the raster's middle, so small that no row of
// tiles merges. The radius is such that the raster's samples are those of a zoom, one by one.
// Everything above sees a planet; that it is a plane its ellipsoid says. Any thread.
#ifndef PERIGEE_PLANET_PLANE_MAP_H
#define PERIGEE_PLANET_PLANE_MAP_H

#include "base/status.h"
#include "geo/ellipsoid.h"

struct plane_map;

// *out NULL: the raster's reference system is longitude and latitude. ERR_NOT_FOUND, ERR_FORMAT (no
// raster), ERR_ARGUMENT: no reference system, none on a planet, or none with a unit of length;
// logged.
status plane_map_open(const char *path, struct plane_map **out);
void plane_map_destroy(struct plane_map **map);

geo_ellipsoid plane_map_body(const struct plane_map *map);

// Gives a GDAL dataset of the VRT format, or what warps it when it lies in another system, the
// map's place. What is returned is the dataset itself or holds on to it. NULL, logged, when it
// cannot be.
void *plane_map_place(const struct plane_map *map, const char *path, void *dataset);

// Geographic degrees to the map's, and back, in place. NaN where there is no such place.
void plane_map_from_geographic(struct plane_map *map, int count, double *lat_deg, double *lon_deg);
void plane_map_to_geographic(struct plane_map *map, int count, double *lat_deg, double *lon_deg);
// A place of the map in degrees to the raster's reference system and its units, in place: northing
// instead of latitude, easting instead of longitude.
void plane_map_coordinates(const struct plane_map *map, int count, double *lat_deg,
                           double *lon_deg);

#endif
