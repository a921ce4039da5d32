// Rotation invariance, the acceptance test of the whole design: an analytic planet turned by a
// rotation, seen by a camera turned with it, must have the same geometry, at the pole as at the
// equator. A sphere of the Moon's size.
#include "render/scene.h"

#include <unistd.h>

#include "base/vec.h"

static const double RADIUS = 1737400;

enum { PIXELS = SCENE_WIDTH * SCENE_HEIGHT };

static dmat3 about_z(double a)
{
    return (dmat3){{{cos(a), -sin(a), 0}, {sin(a), cos(a), 0}, {0, 0, 1}}};
}

static dmat3 about_y(double a)
{
    return (dmat3){{{cos(a), 0, sin(a)}, {0, 1, 0}, {-sin(a), 0, cos(a)}}};
}

static dmat3 product(dmat3 a, dmat3 b)
{
    dmat3 t = dmat3_transpose(b);
    return (dmat3){{dmat3_mul(t, a.row[0]), dmat3_mul(t, a.row[1]), dmat3_mul(t, a.row[2])}};
}

// The camera at the unit vector `at`, looking along `ahead`.
static perigee_camera camera_of(dvec3 at, dvec3 ahead, double altitude)
{
    double lat = asin(clamp_double(at.z, -1, 1)), lon = atan2(at.y, at.x);
    dvec3 east = {-sin(lon), cos(lon), 0},
          north = {-sin(lat) * cos(lon), -sin(lat) * sin(lon), cos(lat)};
    const double deg = 180 / M_PI;
    return (perigee_camera){.lat_deg = lat * deg,
                            .lon_deg = lon * deg,
                            .alt_m = altitude,
                            .heading_deg =
                                atan2(dvec3_dot(ahead, east), dvec3_dot(ahead, north)) * deg,
                            .pitch_deg = asin(dvec3_dot(ahead, at)) * deg,
                            .fov_deg = 60};
}

enum { VIEWS = 2 };

static const double ALTITUDES[VIEWS] = {3000000, 30000};

struct picture {
    float height[PIXELS], z[PIXELS];
};

// What is seen of the planet turned by r from each altitude, the camera turned along.
static void see(const dmat3 *r, struct picture pictures[VIEWS])
{
    char path[64];
    snprintf(path, sizeof path, "rotation-%d.planet", (int)getpid());
    assert_int_equal(analytic_planet_make_rotated(path, 3, r, (geo_ellipsoid){RADIUS, RADIUS}), 0);
    perigee_planet *planet;
    perigee_planet_params params = {.no_synthesis = true};
    assert_int_equal(perigee_planet_open(path, &params, &planet), 0);
    perigee_view *view = scene_view(planet, NULL);
    dvec3 at = dvec3_normalize(dvec3_make(0.9, 0.2, 0.3));
    dvec3 level = dvec3_normalize(dvec3_cross(at, dvec3_make(0.3, -0.5, 0.8)));
    for (int k = 0; k < VIEWS; k++) {
        dvec3 ahead = dvec3_normalize(dvec3_mad(level, at, ALTITUDES[k] > 1e6 ? -4 : -0.35));
        perigee_camera c = camera_of(dmat3_mul(*r, at), dmat3_mul(*r, ahead), ALTITUDES[k]);
        scene_render(view, &c, SCENE_WIDTH, SCENE_HEIGHT);
        perigee_planes planes = {.height_m = pictures[k].height, .z_m = pictures[k].z};
        assert_int_equal(perigee_view_read_planes(view, &planes), 0);
    }
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
    remove(path);
}

// Bounds: five times what was measured (worst 0.0008 px, no pixel of the limb).
static void compare(const char *name, double altitude, const struct picture *a,
                    const struct picture *b)
{
    double sum = 0, worst = 0, pixel = 2 * tan(M_PI / 6) / SCENE_HEIGHT;
    int both = 0, limb = 0;
    for (int p = 0; p < PIXELS; p++) {
        limb += isnan(a->z[p]) != isnan(b->z[p]);
        if (isnan(a->z[p]) || isnan(b->z[p])) continue;
        double e = fabs(a->height[p] - b->height[p]) / (a->z[p] * pixel);
        sum += e * e;
        worst = fmax(worst, e);
        both++;
    }
    print_message("%8.0f m, %-25s: rms %.5f px, worst %.5f px, %d pixels, %d on the limb\n",
                  altitude, name, sqrt(sum / both), worst, both, limb);
    assert_true(both > PIXELS / 10);
    assert_true(worst <= 0.005);
    assert_true(limb <= 5);
}

static void test_turned_planets_look_the_same(void **state)
{
    (void)state;
    static struct picture plain[VIEWS], turned[VIEWS];
    dvec3 at = dvec3_normalize(dvec3_make(0.9, 0.2, 0.3));
    // Takes the camera's place to the north pole exactly.
    dmat3 to_pole = product(about_y(-acos(at.z)), about_z(-atan2(at.y, at.x))), none = about_z(0);
    const struct {
        const char *name;
        dmat3 r;
    } turns[] = {
        {"to the north pole", to_pole},
        {"a quarter degree from it", product(about_y(0.25 * M_PI / 180), to_pole)},
        {"to the south pole", product(about_y(M_PI), to_pole)},
        {"180 degrees of longitude", about_z(M_PI)},
        {"to the antimeridian", about_z(M_PI - atan2(at.y, at.x))},
        {"anywhere", product(about_z(1.1), product(about_y(0.7), about_z(-2.3)))},
    };
    see(&none, plain);
    for (size_t i = 0; i < sizeof turns / sizeof *turns; i++) {
        see(&turns[i].r, turned);
        for (int k = 0; k < VIEWS; k++) compare(turns[i].name, ALTITUDES[k], &plain[k], &turned[k]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_turned_planets_look_the_same)};
    int rc = scene_open();
    return rc ? rc : scene_close(cmocka_run_group_tests(tests, NULL, NULL));
}
