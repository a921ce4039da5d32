#include "reference/normal.h"

#define RAD       (M_PI / 180)
#define POLE_ROOM 1e-12

dvec3 normal_at_hit(struct field_reader *reader, const ray_hit *hit)
{
    geo_ellipsoid e = field_ellipsoid(reader->field);
    double per_lat, per_lon;
    field_gradient(reader, hit->lat, hit->lon, &per_lat, &per_lon);
    double sl = sin(hit->lat * RAD), cl = cos(hit->lat * RAD), so = sin(hit->lon * RAD),
           co = cos(hit->lon * RAD);
    double e2 = 1 - (e.b / e.a) * (e.b / e.a), w2 = 1 - e2 * sl * sl;
    double prime = e.a / sqrt(w2), meridian = prime * (1 - e2) / w2;
    double to_north = per_lat / RAD / (meridian + hit->height);
    double to_east = per_lon / RAD / ((prime + hit->height) * fmax(cl, POLE_ROOM));
    dvec3 east = {-so, co, 0}, north = {-sl * co, -sl * so, cl}, up = {cl * co, cl * so, sl};
    return dvec3_normalize(dvec3_mad(dvec3_mad(up, north, -to_north), east, -to_east));
}
