#include "reference/light.h"

#include <math.h>

#define RAD (M_PI / 180)

#define CONVEX_CONTRAST 0.6
#define HALF_CONVEX     0.03
#define LAMP_FLOOR      0.2

static double smoothstep(double low, double high, double x)
{
    double s = clamp_double((x - low) / (high - low), 0, 1);
    return s * s * (3 - 2 * s);
}

// Heights about a place at `reach` radians of latitude, and as far to east and west on the ground
// but never past the pole.
struct star {
    double centre, north, south, west, east;
    double lat_reach, lon_reach; // rad
};

static struct star read_star(struct field_reader *reader, const ray_hit *hit, double reach)
{
    struct star s = {.lat_reach = reach};
    s.lon_reach = fmin(reach / fmax(cos(hit->lat * RAD), 1e-12), M_PI / 2);
    double north = hit->lat + reach / RAD, south = hit->lat - reach / RAD, lon = s.lon_reach / RAD;
    s.centre = hit->height;
    s.north = north > 90 ? field_height(reader, 180 - north, hit->lon + 180)
                         : field_height(reader, north, hit->lon);
    s.south = south < -90 ? field_height(reader, -180 - south, hit->lon + 180)
                          : field_height(reader, south, hit->lon);
    s.west = field_height(reader, hit->lat, hit->lon - lon);
    s.east = field_height(reader, hit->lat, hit->lon + lon);
    return s;
}

static double convexity(const struct star *s, double radius)
{
    double above =
        (s->centre - 0.25 * (s->north + s->south + s->west + s->east)) / (s->lat_reach * radius);
    return above / (fabs(above) + HALF_CONVEX);
}

// The frame of a place and the ellipsoid's radii of curvature there.
struct place {
    dvec3 east, north, up;
    double prime, meridian;
};

static struct place place_of(geo_ellipsoid e, const ray_hit *hit)
{
    double sl = sin(hit->lat * RAD), cl = cos(hit->lat * RAD), so = sin(hit->lon * RAD),
           co = cos(hit->lon * RAD);
    double e2 = 1 - (e.b / e.a) * (e.b / e.a), w2 = 1 - e2 * sl * sl;
    double prime = e.a / sqrt(w2);
    return (struct place){.east = {-so, co, 0},
                          .north = {-sl * co, -sl * so, cl},
                          .up = {cl * co, cl * so, sl},
                          .prime = prime,
                          .meridian = prime * (1 - e2) / w2};
}

static dvec3 normal_of(const struct place *p, const struct star *s, double lat)
{
    double to_north = (s->north - s->south) / (2 * s->lat_reach * (p->meridian + s->centre));
    double to_east = (s->east - s->west) /
                     (2 * s->lon_reach * fmax(cos(lat * RAD), 1e-12) * (p->prime + s->centre));
    return dvec3_normalize(dvec3_mad(dvec3_mad(p->up, p->north, -to_north), p->east, -to_east));
}

void light_at(struct field_reader *reader, const ray_hit *hit, dvec3 dir, dvec3 sun, double pixel,
              double rgb[3])
{
    static const double sky[3] = {0.16, 0.19, 0.25}, lamp[3] = {1.0, 0.78, 0.45},
                        rock[3] = {0.14, 0.12, 0.10};
    geo_ellipsoid e = field_ellipsoid(reader->field);
    struct place p = place_of(e, hit);
    // The shader's vertical is that of the scaled space.
    double cl = cos(hit->lat * RAD) * e.a, sl = sin(hit->lat * RAD) * e.b;
    dvec3 flat = {p.up.x * e.a, p.up.y * e.a, p.up.z * e.b};
    dvec3 up = dvec3_scale(flat, 1 / hypot(cl, sl));
    double facing = clamp_double(-dvec3_dot(up, dir), 0.04, 1);
    double footprint = fmax(hit->t, 1e-3) * pixel / sqrt(facing);
    double reach = fmax(grid_step_lat(field_zoom(reader->field)), footprint / e.a);
    struct star near = read_star(reader, hit, reach), far = read_star(reader, hit, 8 * reach);
    dvec3 normal = normal_of(&p, &near, hit->lat);
    double convex = 0.5 * (convexity(&near, p.meridian) + convexity(&far, p.meridian));
    double texel[4], steep = smoothstep(0.10, 0.45, 1 - dvec3_dot(normal, up));
    field_color(reader, log2(M_PI * e.a / (TILE_SIZE * footprint)), hit->lat, hit->lon, texel);
    double lit = smoothstep(-0.12, 0.2, dvec3_dot(up, sun));
    double direct = fmax(dvec3_dot(normal, sun), 0) * lit;
    double lamps = fmax(texel[3] - LAMP_FLOOR, 0) / (1 - LAMP_FLOOR);
    for (int i = 0; i < 3; i++) {
        double albedo = texel[i] + (rock[i] - texel[i]) * 0.55 * steep;
        albedo *= 1 + CONVEX_CONTRAST * convex;
        rgb[i] =
            albedo * (1.6 * direct + sky[i] * lit + 0.004) + lamps * lamps * (1 - lit) * lamp[i];
    }
}
