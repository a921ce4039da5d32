// The light of the reference against the clipmap's: two programs of one law (src/reference/light.c,
// shaders/shade). By day, at the terminator, by night with its lamps, over the default Earth; low
// sun on rough ground without imagery. What differs pixel by pixel is over how much ground slopes
// and convexity are taken; in the mean that cancels.
//
// Fails when broken, in the reference: the sun or the sky a sixteenth or a quarter off, no lamps,
// the twilight narrower, half the convexity, a slope's sign. Not seen: how bare steep slopes are,
// as none here is beyond 26 degrees.
#include "render/temporal.h"

#include <unistd.h>

#include "reference/compare.h"

static const struct scene_light {
    const char *name;
    perigee_camera camera;
    double sun[3];    // east, north, up over the camera; 0: always day
    double mean, rms; // bounds, of 255: a fifth above what was measured
    bool rough;       // ground of waves without imagery, for the default Earth
} scenes[] = {
    {.name = "day, Africa",
     .camera = {.lat_deg = 5, .lon_deg = 20, .alt_m = 1.2e7, .pitch_deg = -90},
     .mean = 1.9,
     .rms = 10.7},
    {.name = "terminator, Europe",
     .camera = {.lat_deg = 48, .lon_deg = 10, .alt_m = 3e6, .pitch_deg = -90},
     .sun = {1, 0, 0},
     .mean = 0.2,
     .rms = 4.3},
    {.name = "night, Europe",
     .camera = {.lat_deg = 48, .lon_deg = 10, .alt_m = 3e6, .pitch_deg = -90},
     .sun = {0, 0, -1},
     .mean = 0.2,
     .rms = 6.1},
    {.name = "the Alps from 400 km",
     .camera = {.lat_deg = 46, .lon_deg = 10, .alt_m = 4e5, .pitch_deg = -60},
     .mean = 1.0,
     .rms = 6.3},
    {.name = "rough ground, low sun",
     .camera = {.lat_deg = 31, .lon_deg = 12, .alt_m = 2e4, .pitch_deg = -60},
     .sun = {0.85, 0.4, 0.34},
     .mean = 0.08,
     .rms = 2.5,
     .rough = true},
};

static dvec3 sun_of(const struct scene_light *l)
{
    double lat = l->camera.lat_deg * (M_PI / 180), lon = l->camera.lon_deg * (M_PI / 180);
    dvec3 up = {cos(lat) * cos(lon), cos(lat) * sin(lon), sin(lat)},
          east = {-sin(lon), cos(lon), 0};
    dvec3 north = dvec3_cross(up, east), sun = dvec3_scale(east, l->sun[0]);
    sun = dvec3_mad(dvec3_mad(sun, north, l->sun[1]), up, l->sun[2]);
    return dvec3_length(sun) > 0 ? dvec3_normalize(sun) : sun;
}

static void see_truth(const temporal_scene *s, const struct scene_light *l, temporal_picture *out)
{
    const perigee_camera *c = &l->camera;
    reference_params p = {
        .pyramid = s->pyramid,
        .camera = {c->lat_deg, c->lon_deg, c->alt_m, c->heading_deg, c->pitch_deg, 0, 60},
        .width = TEMPORAL_WIDTH,
        .height = TEMPORAL_HEIGHT,
        .zoom = SIGHT_AUTO,
        .sun = sun_of(l)};
    p.has_sun = dvec3_length(p.sun) > 0.5;
    reference_planes planes = {.r = out->r, .g = out->g, .b = out->b, .z_m = out->z};
    assert_int_equal(reference_render(&p, &planes), OK);
}

static void check(const temporal_scene *s, const struct scene_light *l)
{
    static temporal_picture seen, truth;
    dvec3 sun = sun_of(l);
    perigee_camera c = l->camera;
    c.fov_deg = 60;
    if (dvec3_length(sun) > 0.5) perigee_view_set_sun(s->view, (double[]){sun.x, sun.y, sun.z});
    else perigee_view_set_time_noon(s->view);
    temporal_see(s, &c, &seen);
    see_truth(s, l, &truth);
    const float *const a[3] = {seen.r, seen.g, seen.b}, *const b[3] = {truth.r, truth.g, truth.b};
    double sum[3] = {0}, squares = 0, bright = 0, most = 0;
    int count = 0;
    for (int i = 0; i < TEMPORAL_PIXELS; i++) {
        if (isnan(seen.z[i]) || isnan(truth.z[i])) continue;
        count++;
        for (int k = 0; k < 3; k++) {
            double d = 255 * (compare_encoded((double)a[k][i]) - compare_encoded((double)b[k][i]));
            sum[k] += d;
            squares += d * d;
            bright = fmax(bright, 255 * compare_encoded((double)b[k][i]));
        }
    }
    assert_true(count > TEMPORAL_PIXELS / 5);
    for (int k = 0; k < 3; k++) most = fmax(most, fabs(sum[k] / count));
    double rms = sqrt(squares / (3 * count));
    print_message("%-22s: a channel's mean off by %.3f at most, rms %.2f of 255; brightest %.0f\n",
                  l->name, most, rms, bright);
    assert_true(bright > 50);
    assert_true(most <= l->mean);
    assert_true(rms <= l->rms);
}

static void check_all(const char *planet, bool rough)
{
    temporal_scene s = temporal_open(planet, true, NULL);
    for (size_t i = 0; i < sizeof scenes / sizeof scenes[0]; i++)
        if (scenes[i].rough == rough) check(&s, &scenes[i]);
    temporal_close(&s);
}

static void test_earth(void **state)
{
    (void)state;
    if (access(EARTH_PLANET, R_OK)) {
        print_message("%s: not there, nothing tested\n", EARTH_PLANET);
        skip();
    }
    check_all(EARTH_PLANET, false);
}

static void test_rough(void **state)
{
    (void)state;
    check_all(temporal_rough(), true);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_earth), cmocka_unit_test(test_rough)};
    int rc = scene_open();
    return rc ? rc : scene_close(cmocka_run_group_tests(tests, NULL, NULL));
}
