#include "render/temporal.h"

#include <unistd.h>

#include "base/vec.h"
#include "planet/planet_fixture.h"
#include "reference/flicker.h"
#include "reference/geographic.h"
#include "reference/reference.h"

static const double RAD = M_PI / 180;

temporal_scene temporal_open(const char *path, bool synthesis, const perigee_view_params *params)
{
    temporal_scene s = {0};
    perigee_planet_params planet = {.no_synthesis = !synthesis};
    perigee_view_params view = params ? *params : (perigee_view_params){0};
    pyramid_params tiles = {.synthesis = synthesis};
    view.no_sky_glow = true;
    assert_int_equal(perigee_planet_open(path, &planet, &s.planet), 0);
    s.view = scene_view(s.planet, &view);
    assert_int_equal(planet_file_open(path, &s.file), OK);
    assert_int_equal(pyramid_create(s.file, &tiles, &s.pyramid), OK);
    s.ellipsoid = pyramid_meta(s.pyramid)->ellipsoid;
    return s;
}

void temporal_close(temporal_scene *s)
{
    pyramid_destroy(&s->pyramid);
    planet_file_close(&s->file);
    perigee_view_destroy(&s->view);
    perigee_planet_close(&s->planet);
}

const char *temporal_analytic(void)
{
    perigee_planet *made = scene_planet();
    perigee_planet_close(&made);
    return "analytic.planet";
}

const char *temporal_pebble(void)
{
    const char *path = "pebble.planet";
    char own[64];
    if (!access(path, R_OK)) return path;
    snprintf(own, sizeof own, "pebble-%d.planet", (int)getpid());
    assert_int_equal(
        analytic_planet_make_rotated(own, 4, NULL, (geo_ellipsoid){.a = 1e5, .b = 99664}), 0);
    assert_int_equal(rename(own, path), 0);
    return path;
}

static float rough_height(tile_id id, int row, int col, double lat, double lon)
{
    return fixture_land_height(id, row, col, lat, lon) - 50000;
}

const char *temporal_rough(void)
{
    const char *path = "rough.planet";
    fixture f;
    if (!access(path, R_OK)) return path;
    fixture_init(&f, "rough");
    fixture_write(&f, 2, 0.4, rough_height, NULL);
    assert_int_equal(rename(f.path, path), 0);
    fixture_deinit(&f);
    return path;
}

static void read_frame(const temporal_scene *s, temporal_picture *out)
{
    perigee_planes planes = {.r = out->r, .g = out->g, .b = out->b, .z_m = out->z};
    assert_int_equal(perigee_view_read_planes(s->view, &planes), 0);
}

int temporal_see(const temporal_scene *s, const perigee_camera *camera, temporal_picture *out)
{
    perigee_stats stats;
    scene_render(s->view, camera, TEMPORAL_WIDTH, TEMPORAL_HEIGHT);
    read_frame(s, out);
    perigee_view_get_stats(s->view, &stats);
    return (int)stats.last_level;
}

void temporal_see_now(const temporal_scene *s, const perigee_camera *camera, temporal_picture *out)
{
    scene_bind(TEMPORAL_WIDTH, TEMPORAL_HEIGHT);
    assert_int_equal(perigee_view_set_camera(s->view, camera), 0);
    assert_int_equal(perigee_view_render(s->view, TEMPORAL_WIDTH, TEMPORAL_HEIGHT), 0);
    read_frame(s, out);
}

static reference_camera judge(const perigee_camera *c)
{
    return (reference_camera){c->lat_deg,   c->lon_deg,  c->alt_m,  c->heading_deg,
                              c->pitch_deg, c->roll_deg, c->fov_deg};
}

void temporal_see_reference(const temporal_scene *s, const perigee_camera *camera, int zoom,
                            temporal_picture *out)
{
    reference_params params = {.pyramid = s->pyramid,
                               .camera = judge(camera),
                               .width = TEMPORAL_WIDTH,
                               .height = TEMPORAL_HEIGHT,
                               .zoom = zoom};
    reference_planes planes = {.r = out->r, .g = out->g, .b = out->b, .z_m = out->z};
    assert_int_equal(reference_render(&params, &planes), OK);
}

static dvec3 vertical(geo_ellipsoid e, dvec3 p)
{
    return dvec3_normalize(dvec3_make(p.x / (e.a * e.a), p.y / (e.a * e.a), p.z / (e.b * e.b)));
}

// Geometric error of a against b at every pixel, NaN where it is not plain ground in both.
static void geometry(const temporal_scene *s, const perigee_camera *camera,
                     const temporal_picture *a, const temporal_picture *b, float *px)
{
    static unsigned char kind[TEMPORAL_PIXELS];
    compare_params p = {.ellipsoid = s->ellipsoid,
                        .camera = judge(camera),
                        .width = TEMPORAL_WIDTH,
                        .height = TEMPORAL_HEIGHT,
                        .a = {.z_m = a->z},
                        .b = {.z_m = b->z}};
    compare_maps maps = {.geometric_px = px, .kind = kind};
    compare_result result;
    assert_int_equal(compare_pictures(&p, &maps, &result), OK);
    for (int i = 0; i < TEMPORAL_PIXELS; i++)
        if (kind[i] != COMPARE_GROUND) px[i] = NAN;
}

temporal_change temporal_compare(const temporal_scene *s, const perigee_camera *camera,
                                 const temporal_picture *a, const temporal_picture *b,
                                 const temporal_picture *ra, const temporal_picture *rb)
{
    static float before[TEMPORAL_PIXELS], after[TEMPORAL_PIXELS];
    flicker_moment first = {.r = a->r, .g = a->g, .b = a->b},
                   then = {.r = b->r, .g = b->g, .b = b->b};
    flicker_result f;
    geometry(s, camera, b, ra ? rb : a, after);
    then.geometric_px = after;
    if (ra) {
        geometry(s, camera, a, ra, before);
        first.geometric_px = before;
        first.true_r = ra->r, first.true_g = ra->g, first.true_b = ra->b;
        then.true_r = rb->r, then.true_g = rb->g, then.true_b = rb->b;
    }
    assert_int_equal(flicker_measure(&first, &then, TEMPORAL_WIDTH, TEMPORAL_HEIGHT, &f), OK);
    temporal_change c = {.compared = (int)f.moved_px.count};
    for (int i = 0; i < TEMPORAL_PIXELS; i++)
        c.silhouette +=
            !isnan(a->z[i]) && !isnan(b->z[i]) && (isnan(after[i]) || (ra && isnan(before[i])));
    if (!c.compared) return c;
    c.rms_px = f.moved_px.rms, c.p999_px = f.moved_px.rank_999, c.worst_px = f.moved_px.max;
    c.rms = f.color.rms, c.p999 = f.color.rank_999, c.worst = f.color.max;
    return c;
}

void temporal_cross_pole(perigee_camera *camera, double sign, double lon, double angle)
{
    bool before = angle <= 0;
    camera->lat_deg = sign * (90 - fabs(angle));
    camera->lon_deg = before ? lon : lon + 180;
    camera->heading_deg = before == (sign > 0) ? 0 : 180;
}

double temporal_ground(const temporal_scene *s, double lat_deg, double lon_deg)
{
    double h;
    assert_int_equal(perigee_planet_height(s->planet, lat_deg, lon_deg, &h), 0);
    return h;
}

static dvec3 ecef(const temporal_scene *s, double lat, double lon, double height)
{
    double p[3];
    reference_ecef(s->ellipsoid.a, s->ellipsoid.b, lat / RAD, lon / RAD, height, p);
    return dvec3_make(p[0], p[1], p[2]);
}

static double above_ground(const temporal_scene *s, dvec3 p)
{
    double lat, lon, h;
    const double q[3] = {p.x, p.y, p.z};
    reference_geodetic(s->ellipsoid.a, s->ellipsoid.b, q, &lat, &lon, &h);
    return h - temporal_ground(s, lat, lon);
}

// Is the ray from the point up to the camera free of other ground, by more the farther from the
// point?
static bool in_sight(const temporal_scene *s, dvec3 point, dvec3 to_camera, double distance,
                     double pixel)
{
    double highest = pyramid_meta(s->pyramid)->height_max;
    for (double t = 2 * pixel; t < 0.9 * distance; t *= 1.15) {
        dvec3 p = dvec3_mad(point, to_camera, t);
        double clear = above_ground(s, p);
        if (clear < 0.02 * t) return false;
        if (clear > 2 * highest) return true;
    }
    return true;
}

// The ground's normal about a point, over `reach` metres.
static dvec3 normal_at(const temporal_scene *s, double lat, double lon, double reach)
{
    double dlat = reach / s->ellipsoid.a, dlon = dlat / fmax(cos(lat), 1e-9);
    dvec3 p[4];
    for (int k = 0; k < 4; k++) {
        double la = lat + (k == 0   ? dlat
                           : k == 1 ? -dlat
                                    : 0),
               lo = lon + (k == 2   ? dlon
                           : k == 3 ? -dlon
                                    : 0);
        p[k] = ecef(s, la, lo, temporal_ground(s, la / RAD, lo / RAD));
    }
    return dvec3_normalize(dvec3_cross(dvec3_sub(p[2], p[3]), dvec3_sub(p[0], p[1])));
}

// Where a point is on the screen (pixels from the top left corner) and how far along the view axis.
static void project(const temporal_scene *s, const perigee_camera *camera, dvec3 point, double *x,
                    double *y, double *z)
{
    reference_camera c = judge(camera);
    dvec3 o, centre, right, down;
    reference_ray(s->ellipsoid, &c, TEMPORAL_WIDTH, TEMPORAL_HEIGHT, 0.5 * TEMPORAL_WIDTH,
                  0.5 * TEMPORAL_HEIGHT, &o, &centre);
    reference_ray(s->ellipsoid, &c, TEMPORAL_WIDTH, TEMPORAL_HEIGHT, 0.5 * TEMPORAL_WIDTH + 1,
                  0.5 * TEMPORAL_HEIGHT, &o, &right);
    reference_ray(s->ellipsoid, &c, TEMPORAL_WIDTH, TEMPORAL_HEIGHT, 0.5 * TEMPORAL_WIDTH,
                  0.5 * TEMPORAL_HEIGHT + 1, &o, &down);
    dvec3 from = dvec3_sub(point, o);
    right = dvec3_sub(right, centre);
    down = dvec3_sub(down, centre);
    *z = dvec3_dot(from, centre);
    *x = 0.5 * TEMPORAL_WIDTH + dvec3_dot(from, right) / dvec3_dot(right, right) / *z;
    *y = 0.5 * TEMPORAL_HEIGHT + dvec3_dot(from, down) / dvec3_dot(down, down) / *z;
}

// Depth of a frame between its pixels; NaN outside, beside sky and across a step.
static double depth_at(const temporal_picture *frame, double x, double y)
{
    int i = (int)floor(x - 0.5), j = (int)floor(y - 0.5);
    if (!(x > 1 && y > 1 && x < TEMPORAL_WIDTH - 1 && y < TEMPORAL_HEIGHT - 1)) return NAN;
    const float *p = frame->z + j * TEMPORAL_WIDTH + i;
    double u = x - 0.5 - i, v = y - 0.5 - j;
    double a = 1 / (double)p[0], b = 1 / (double)p[1], c = 1 / (double)p[TEMPORAL_WIDTH],
           d = 1 / (double)p[TEMPORAL_WIDTH + 1];
    if (!(fabs(a + d - b - c) <= 0.05 * a)) return NAN;
    return 1 / ((1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * c + u * d));
}

double temporal_deviation(const temporal_scene *s, const perigee_camera *camera,
                          const temporal_picture *frame, double lat, double lon, double height)
{
    dvec3 point = ecef(s, lat, lon, height),
          eye = ecef(s, camera->lat_deg * RAD, camera->lon_deg * RAD, camera->alt_m);
    double distance = dvec3_length(dvec3_sub(point, eye)), x, y, z;
    dvec3 d = dvec3_scale(dvec3_sub(point, eye), 1 / distance), up = vertical(s->ellipsoid, point);
    project(s, camera, point, &x, &y, &z);
    double drawn = z > 0 ? depth_at(frame, x, y) : NAN;
    if (isnan(drawn)) return NAN;
    double pixel = z * 2 * tan(camera->fov_deg * RAD / 2) / TEMPORAL_HEIGHT;
    dvec3 normal = normal_at(s, lat, lon, pixel);
    double facing = -dvec3_dot(d, normal), sine = dvec3_dot(d, up);
    if (facing < 0.05 || !in_sight(s, point, dvec3_scale(d, -1), distance, pixel)) return NAN;
    double rise = distance * (1 - drawn / z) * facing / dvec3_dot(normal, up);
    return rise * sqrt(fmax(0, 1 - sine * sine)) / pixel;
}
