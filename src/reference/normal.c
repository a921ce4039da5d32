#include "reference/normal.h"

#include "reference/body.h"

#define RAD (M_PI / 180)

dvec3 normal_at_hit(struct field_reader *reader, const ray_hit *hit)
{
    geo_ellipsoid e = field_ellipsoid(reader->field);
    double per_lat, per_lon;
    field_gradient(reader, hit->lat, hit->lon, &per_lat, &per_lon);
    body_frame f = body_frame_at(e, hit->lat, hit->lon, hit->height);
    double to_north = per_lat / RAD / f.per_lat, to_east = per_lon / RAD / f.per_lon;
    return dvec3_normalize(dvec3_mad(dvec3_mad(f.up, f.north, -to_north), f.east, -to_east));
}
