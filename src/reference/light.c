#include "reference/light.h"

#include <math.h>

#include "reference/body.h"

#define RAD (M_PI / 180)

#define CONVEX_CONTRAST 0.6
#define HALF_CONVEX     0.03
#define LAMP_FLOOR      0.2

static double smoothstep(double low, double high, double x)
{
    double s = clamp_double((x - low) / (high - low), 0, 1);
    return s * s * (3 - 2 * s);
}

// Heights about a place along great circles: north, east, south and west at `reach`, and between
// them at sqrt(2) of it.
enum { NORTH, NORTH_EAST, EAST, SOUTH_EAST, SOUTH, SOUTH_WEST, WEST, NORTH_WEST, AROUND };

struct star {
    double centre, around[AROUND];
    double reach; // rad
};

static struct star read_star(struct field_reader *reader, const ray_hit *hit, double reach)
{
    struct star s = {.centre = hit->height, .reach = reach};
    bool plane = geo_is_plane(field_ellipsoid(reader->field));
    double sin_lat = sin(hit->lat * RAD), cos_lat = cos(hit->lat * RAD);
    for (int k = 0; k < AROUND; k++) {
        double azimuth = k * M_PI / 4, far = k % 2 ? M_SQRT2 * reach : reach;
        if (plane) {
            double to = hit->lat + far * cos(azimuth) / RAD;
            s.around[k] = field_height(reader, clamp_double(to, -90, 90),
                                       hit->lon + far * sin(azimuth) / RAD);
            continue;
        }
        double along = sin(far) * cos(azimuth), across = sin(far) * sin(azimuth);
        double to_axis = cos_lat * cos(far) - sin_lat * along;
        double lat = atan2(sin_lat * cos(far) + cos_lat * along, hypot(to_axis, across));
        s.around[k] = field_height(reader, lat / RAD, hit->lon + atan2(across, to_axis) / RAD);
    }
    return s;
}

// Nine-point Laplacian: alike in all directions to the fourth order.
static double convexity(const struct star *s, double radius)
{
    double edges = 0, corners = 0;
    for (int k = 0; k < AROUND; k += 2) edges += s->around[k], corners += s->around[k + 1];
    double above = 5.0 / 6 * (s->centre - edges / 5 - corners / 20) / (s->reach * radius);
    return above / (fabs(above) + HALF_CONVEX);
}

static dvec3 normal_of(const body_frame *p, const struct star *s)
{
    double to_north = (s->around[NORTH] - s->around[SOUTH]) / (2 * s->reach * p->per_lat);
    double to_east = (s->around[EAST] - s->around[WEST]) / (2 * s->reach * p->per_east);
    return dvec3_normalize(dvec3_mad(dvec3_mad(p->up, p->north, -to_north), p->east, -to_east));
}

void light_at(struct field_reader *reader, const ray_hit *hit, dvec3 dir, dvec3 sun, double pixel,
              double rgb[3])
{
    static const double sky[3] = {0.16, 0.19, 0.25}, lamp[3] = {1.0, 0.78, 0.45},
                        rock[3] = {0.14, 0.12, 0.10};
    geo_ellipsoid e = field_ellipsoid(reader->field);
    body_frame p = body_frame_at(e, hit->lat, hit->lon, hit->height);
    // The shader's vertical is that of the scaled space.
    double cl = cos(hit->lat * RAD) * e.a, sl = sin(hit->lat * RAD) * e.b;
    dvec3 flat = {p.up.x * e.a, p.up.y * e.a, p.up.z * e.b};
    dvec3 up = geo_is_plane(e) ? p.up : dvec3_scale(flat, 1 / hypot(cl, sl));
    double facing = clamp_double(-dvec3_dot(up, dir), 0.04, 1);
    double footprint = fmax(hit->t, 1e-3) * pixel / sqrt(facing);
    double reach = fmax(grid_step_lat(field_zoom(reader->field)), footprint / e.a);
    struct star near = read_star(reader, hit, reach), far = read_star(reader, hit, 8 * reach);
    dvec3 normal = normal_of(&p, &near);
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
