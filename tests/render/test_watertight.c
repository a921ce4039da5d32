// Never a hole: random views, and views aimed at every kind of place where something meets, with
// all data there and with what happens to be there. An argument multiplies the number of views, a
// second one chooses tests (test_aimed*).
#include "render/gaps.h"

enum { RANDOM_VIEWS = 100, AIMED_VIEWS = 4, MET_PAIRS = 5 };

static const double RAD = M_PI / 180, A = 6378137.0, FLAT = 6356752.314245179 / 6378137.0;

static int times = 1;
// By how much the limb may lie too low: what the chords between rings are allowed (SAG_PX of
// render/stride.c). Without it the 520th of 2,000 random views fails: three pixels of sky, for
// which 0.005 px are enough.
#define CHORDS_PX 0.0165
static double limb_px = CHORDS_PX;
static struct gaps_frame seen;
static int inside, late;

static void check_frame(const char *what, int number, const perigee_camera *c, bool ground)
{
    struct gaps_counts n = gaps_find(c, &seen, limb_px);
    late += seen.late;
    if (!ground) return;
    inside += n.inside;
    if (n.background + n.cracks + n.unidentified)
        fail_msg("%s %d (%s): lat %.9g lon %.9g alt %.9g heading %g pitch %g fov %g: %d background "
                 "pixels, %d cracks, %d without an identifier",
                 what, number, seen.late ? "late" : "complete", c->lat_deg, c->lon_deg, c->alt_m,
                 c->heading_deg, c->pitch_deg, c->fov_deg, n.background, n.cracks, n.unidentified);
}

// First with whatever is there of the new place, then complete. Where data is late the ground may
// lie above a camera near it, so that it looks at its underside.
static void check_view(perigee_view *view, const char *what, int number, const perigee_camera *c,
                       double above)
{
    scene_bind(GAPS_WIDTH, GAPS_HEIGHT);
    assert_int_equal(perigee_view_set_camera(view, c), 0);
    assert_int_equal(perigee_view_render(view, GAPS_WIDTH, GAPS_HEIGHT), 0);
    gaps_read(view, &seen);
    check_frame(what, number, c, !seen.late || above > 200);
    scene_render(view, c, GAPS_WIDTH, GAPS_HEIGHT);
    gaps_read(view, &seen);
    check_frame(what, number, c, true);
}

// What met in the middle of the complete frames seen: in how many of them, and over how many pairs
// of neighbouring pixels.
struct meetings {
    int views[GAPS_BORDERS], pairs[GAPS_BORDERS];
};

static void add_meetings(struct meetings *m)
{
    for (enum gaps_border b = 0; b < GAPS_BORDERS; b++) {
        int pairs = gaps_met(&seen, b);
        m->views[b] += pairs > 0;
        m->pairs[b] += pairs;
    }
}

static void print_meetings(const struct meetings *m)
{
    for (enum gaps_border b = 0; b < GAPS_BORDERS; b++) {
        print_message("  %s in %d views", gaps_border_names[b], m->views[b]);
        if (b != GAPS_POLE) print_message(", %d pairs of pixels", m->pairs[b]);
        print_message("\n");
    }
}

// A pole falls into the middle by aim only.
static void assert_borders_met(const struct meetings *m)
{
    for (enum gaps_border b = 0; b < GAPS_BORDERS; b++)
        if (b != GAPS_POLE) assert_true(m->views[b] > 0);
}

static double ground(const perigee_camera *c)
{
    return analytic_height(c->lat_deg * RAD, c->lon_deg * RAD);
}

// A third of the views stand at odd places.
static perigee_camera random_camera(struct check_random *r, int i, double *above)
{
    static const double odd[][2] = {{90, 0},  {-90, 12},  {89.99999, 170},
                                    {0, 180}, {45, -180}, {-89.7, 90}};
    perigee_camera c = {.lat_deg = asin(check_random_range(r, -1, 1)) / RAD,
                        .lon_deg = check_random_range(r, -180, 180),
                        .heading_deg = check_random_range(r, 0, 360),
                        .pitch_deg = check_random_range(r, -90, 5),
                        .fov_deg = pow(10, check_random_range(r, 0.5, 2))};
    if (i % 3 == 0) {
        c.lat_deg = odd[i / 3 % 6][0];
        c.lon_deg = odd[i / 3 % 6][1];
    }
    *above = pow(10, check_random_range(r, 0.5, 7.5));
    c.alt_m = *above + ground(&c);
    return c;
}

static void look_from_everywhere(const char *what, const perigee_view_params *params, int views,
                                 uint64_t seed)
{
    perigee_planet *planet = scene_planet();
    perigee_view_params with = *params;
    with.identify = true;
    perigee_view *view = scene_view(planet, &with);
    struct check_random r = {seed};
    struct meetings met = {0};
    inside = late = 0;
    for (int i = 0; i < views; i++) {
        double above;
        perigee_camera c = random_camera(&r, i, &above);
        check_view(view, what, i, &c, above);
        add_meetings(&met);
    }
    print_message("%s: %d views twice, %d frames late, %d pixels inside the limb, no hole\n", what,
                  views, late, inside);
    print_meetings(&met);
    if (views >= RANDOM_VIEWS && params->mode == PERIGEE_MODE_SPHERICAL) assert_borders_met(&met);
    assert_true(late > views / 2);
    assert_true(inside > views * (GAPS_PIXELS / 4));
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
}

static void test_random_views(void **state)
{
    (void)state;
    look_from_everywhere("default", &(perigee_view_params){0}, RANDOM_VIEWS * times, 31);
}

// Fields of view from the least to the most there is, over the ground and above it. In the widest
// the nearest ground lies at a hundredth of its distance along the view axis.
static void look_through_fields(const char *what, enum perigee_mode mode)
{
    static const double fovs[] = {0.01, 0.1, 1, 120, 150, 170, 178, 179};
    static const double heights[] = {2, 100, 5000, 400e3};
    perigee_planet *planet = scene_planet();
    perigee_view *view = scene_view(planet, &(perigee_view_params){.mode = mode, .identify = true});
    inside = late = 0;
    for (int i = 0; i < 64; i++) {
        double above = heights[i / 8 % 4], pitch = i < 32 ? -5 : -40;
        perigee_camera c = {.lat_deg = 38,
                            .lon_deg = 128.4,
                            .heading_deg = 30,
                            .pitch_deg = pitch - (i / 8 % 4 == 3 ? 20 : 0),
                            .fov_deg = fovs[i % 8]};
        c.alt_m = above + ground(&c);
        check_view(view, what, i, &c, above);
    }
    assert_true(inside > 64 * (GAPS_PIXELS / 4));
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
}

static void test_fields_of_view(void **state)
{
    (void)state;
    look_through_fields("field of view", PERIGEE_MODE_SPHERICAL);
}

static void test_fields_of_view_of_grid(void **state)
{
    (void)state;
    look_through_fields("field of view, grid", PERIGEE_MODE_GRID);
}

// The persistent grid, also a coarse one and one that is denser in the middle.
static void test_grids(void **state)
{
    (void)state;
    static const perigee_view_params grids[] = {
        {.mode = PERIGEE_MODE_GRID},
        {.mode = PERIGEE_MODE_GRID, .grid_rows = 60, .grid_columns = 80},
        {.mode = PERIGEE_MODE_GRID, .grid_rows = 150, .grid_columns = 150, .grid_denser = 0.7},
    };
    static const char *const names[] = {"grid", "a coarse grid", "a grid denser in the middle"};
    // A column's chord to the outermost one runs under the limb by a quarter of their distance.
    static const double limbs_px[] = {0, GAPS_WIDTH / 80.0 / 4, GAPS_WIDTH / 150.0 / 4};
    for (int i = 0; i < 3; i++) {
        limb_px = limbs_px[i];
        look_from_everywhere(names[i], &grids[i], (i ? 6 : 24) * times, 200 + (uint64_t)i);
    }
    limb_px = CHORDS_PX;
}

// Coarser meshes, rings and columns left out, the other transforms, coordinates from vertices, no
// culling. Where up to seven of eight rings are left out, the chord between two at the limb, 0.13
// of its angle t from the nadir long, runs under it by R (0.13 t)^2 / 8: at most a quarter of a
// pixel of 45 degrees at the distance R tan(t); narrower views do not leave them out
// (render/stride.c).
static void test_other_settings(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        perigee_view_params params;
        double limb_px;
    } settings[] = {
        {"the paper's mesh", {.azimuth_steps = 512, .rings_per_level = 20}, CHORDS_PX},
        {"a coarse mesh", {.azimuth_steps = 256, .rings_per_level = 20}, CHORDS_PX},
        {"rings and columns left out", {.ring_spacing_px = 6}, 0.25},
        {"low, most left out", {.quality = PERIGEE_QUALITY_LOW}, 0.25},
        {"exact, by vertex",
         {.transform = PERIGEE_TRANSFORM_EXACT, .texcoord_vertex = true},
         CHORDS_PX},
        {"blend, hardware filter",
         {.transform = PERIGEE_TRANSFORM_BLEND, .filter = PERIGEE_FILTER_HARDWARE, .no_cull = true},
         CHORDS_PX},
    };
    for (size_t i = 0; i < sizeof settings / sizeof *settings; i++) {
        limb_px = settings[i].limb_px;
        look_from_everywhere(settings[i].name, &settings[i].params, 6 * times, 100 + i);
    }
    limb_px = CHORDS_PX;
}

// The paper's exact transform, 24 m above the ground: the finest levels' heights come from places
// outside their windows, so from coarser levels, and cells were culled by bounds that did not hold.
static void test_exact_near_the_ground(void **state)
{
    (void)state;
    perigee_planet *planet = scene_planet();
    perigee_view_params params = {.identify = true, .transform = PERIGEE_TRANSFORM_EXACT};
    perigee_view *view = scene_view(planet, &params);
    perigee_camera c = {.lat_deg = -31.371139,
                        .lon_deg = -104.332404,
                        .alt_m = -1142.79415,
                        .heading_deg = 288.106,
                        .pitch_deg = -75.9052,
                        .fov_deg = 35.7512};
    check_view(view, "exact near the ground", 0, &c, 24);
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
}

// Geodetic place (deg) at an angle and azimuth from the camera's nadir, on the sphere of reduced
// latitude.
static void place_about(const perigee_camera *c, double angle, double azimuth, double *lat,
                        double *lon)
{
    double b = atan(FLAT * tan(c->lat_deg * RAD)), l = c->lon_deg * RAD;
    double n = sin(angle) * cos(azimuth), e = sin(angle) * sin(azimuth), u = cos(angle);
    double x = cos(b) * u - sin(b) * n, z = sin(b) * u + cos(b) * n;
    *lat = atan2(z, FLAT * hypot(x, e)) / RAD;
    *lon = atan2(x * sin(l) + e * cos(l), x * cos(l) - e * sin(l)) / RAD;
}

// Turns the camera to the terrain at a place.
static void aim(perigee_camera *c, double lat_deg, double lon_deg)
{
    perigee_camera there = {.lat_deg = lat_deg, .lon_deg = lon_deg}, north = *c, up = *c;
    there.alt_m = ground(&there);
    north.heading_deg = north.pitch_deg = north.roll_deg = up.heading_deg = up.roll_deg = 0;
    up.pitch_deg = 90;
    double from[3], to[3], n[3], u[3], d[3], length = 0;
    scene_ray(&there, 2, 2, 1, 1, to, d);
    scene_ray(&north, 2, 2, 1, 1, from, n);
    scene_ray(&up, 2, 2, 1, 1, from, u);
    double east[3] = {n[1] * u[2] - n[2] * u[1], n[2] * u[0] - n[0] * u[2],
                      n[0] * u[1] - n[1] * u[0]};
    double de = 0, dn = 0, du = 0;
    for (int i = 0; i < 3; i++) {
        double s = to[i] - from[i];
        de += s * east[i];
        dn += s * n[i];
        du += s * u[i];
        length += s * s;
    }
    c->heading_deg = atan2(de, dn) / RAD;
    c->pitch_deg = asin(fmax(-1, du / sqrt(length))) / RAD;
}

// A camera that stands at a distance (rad, at most 0.35) from what it will be aimed at.
static perigee_camera camera_about(struct check_random *r, double *angle, double *above)
{
    *above = pow(10, check_random_range(r, 0.7, 6.3));
    *angle = fmin(*above / A * check_random_range(r, 0.3, 2.5), 0.35);
    return (perigee_camera){.lat_deg = asin(check_random_range(r, -1, 1)) / RAD,
                            .lon_deg = check_random_range(r, -180, 180),
                            .fov_deg = 60};
}

// The border's angle is pi 2^-level, which shows as a ring when it is about the altitude or more
// away: then the camera is low enough for the level to be drawn.
static perigee_camera aimed_at_level(struct check_random *r, double *above)
{
    double angle = M_PI / pow(2, (int)check_random_range(r, 3, 21)), lat, lon;
    perigee_camera c = camera_about(r, &(double){0}, above);
    *above = angle * A * check_random_range(r, 0.3, 0.95);
    c.alt_m = *above + ground(&c);
    place_about(&c, angle, check_random_range(r, 0, 2 * M_PI), &lat, &lon);
    aim(&c, lat, lon);
    return c;
}

static perigee_camera aimed_at_fill(perigee_view *view, struct check_random *r, double *above)
{
    double angle, lat, lon;
    perigee_camera c = camera_about(r, &angle, above);
    c.alt_m = *above + ground(&c);
    scene_render(view, &c, GAPS_WIDTH, GAPS_HEIGHT); // says which level is the last
    gaps_read(view, &seen);
    perigee_camera away = {.lat_deg = -c.lat_deg, .lon_deg = c.lon_deg + 170, .alt_m = c.alt_m};
    scene_render(view, &away, GAPS_WIDTH, GAPS_HEIGHT);
    angle = M_PI / pow(2, seen.last_level + 1);
    place_about(&c, angle, check_random_range(r, 0, 2 * M_PI), &lat, &lon);
    aim(&c, lat, lon);
    return c;
}

// Every second seam is looked at beyond a pole.
static perigee_camera aimed_at_azimuth(struct check_random *r, int i, bool seam, double *above)
{
    double angle, lat, lon;
    perigee_camera c = camera_about(r, &angle, above);
    int sector = 1 + (int)check_random_range(r, 0, 15) + (i % 2) * 16;
    double azimuth = seam ? (i / 2 % 2) * M_PI : sector * (2 * M_PI / 32);
    if (seam && i % 2) {
        double colatitude = angle * check_random_range(r, 0, 0.95) / RAD;
        c.lat_deg = azimuth > 1 ? colatitude - 90 : 90 - colatitude;
    }
    c.alt_m = *above + ground(&c);
    place_about(&c, angle, azimuth, &lat, &lon);
    aim(&c, lat, lon);
    return c;
}

static perigee_camera aimed_at_pole(struct check_random *r, int i, double *above)
{
    double angle;
    perigee_camera c = camera_about(r, &angle, above);
    c.lat_deg = (i % 2 ? -1 : 1) * (90 - angle / RAD);
    c.alt_m = *above + ground(&c);
    aim(&c, i % 2 ? -90 : 90, c.lon_deg);
    return c;
}

static perigee_camera aimed_at_antimeridian(struct check_random *r, double *above)
{
    double angle, lat;
    perigee_camera c = camera_about(r, &angle, above), there = {.lat_deg = c.lat_deg * 0.9};
    there.lon_deg = 180;
    lat = there.lat_deg;
    place_about(&there, angle, check_random_range(r, 0, 2 * M_PI), &c.lat_deg, &c.lon_deg);
    c.alt_m = *above + ground(&c);
    aim(&c, lat, 180);
    return c;
}

static perigee_camera aimed_camera(perigee_view *view, struct check_random *r,
                                   enum gaps_border border, int i, double *above)
{
    switch (border) {
    case GAPS_LEVEL:
        return aimed_at_level(r, above);
    case GAPS_FILL:
        return aimed_at_fill(view, r, above);
    case GAPS_POLE:
        return aimed_at_pole(r, i, above);
    case GAPS_ANTIMERIDIAN:
        return aimed_at_antimeridian(r, above);
    default:
        return aimed_at_azimuth(r, i, border == GAPS_SEAM, above);
    }
}

static void test_aimed_views(void **state)
{
    (void)state;
    perigee_planet *planet = scene_planet();
    perigee_view_params params = {.identify = true};
    perigee_view *view = scene_view(planet, &params);
    struct check_random r = {77};
    for (enum gaps_border b = 0; b < GAPS_BORDERS; b++) {
        int least = 1 << 20, all = 0, views = AIMED_VIEWS * times;
        inside = late = 0;
        for (int i = 0; i < views; i++) {
            double above;
            perigee_camera c = aimed_camera(view, &r, b, i, &above);
            check_view(view, gaps_border_names[b], i, &c, above);
            int met = gaps_met(&seen, b);
            all += met;
            if (met < least) least = met;
            if (met < (b == GAPS_POLE ? 4 : MET_PAIRS))
                fail_msg("%s %d: lat %.9g lon %.9g alt %.9g heading %g pitch %g: not in the middle "
                         "(%d pairs of pixels)",
                         gaps_border_names[b], i, c.lat_deg, c.lon_deg, c.alt_m, c.heading_deg,
                         c.pitch_deg, met);
        }
        print_message("aimed at %s: %d views twice, %d frames late, %d pixels, no hole; both sides "
                      "met in at least %d pairs of pixels a view, %d in all\n",
                      gaps_border_names[b], views, late, inside, least, all);
    }
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
}

int main(int argc, char **argv)
{
    if (argc > 1) times = atoi(argv[1]);
    if (times < 1 || times > 1000) {
        fprintf(stderr, "views: 1 to 1000 times the usual number, not '%s'\n", argv[1]);
        return 2;
    }
    if (argc > 2) cmocka_set_test_filter(argv[2]);
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_aimed_views),
                                       cmocka_unit_test(test_random_views),
                                       cmocka_unit_test(test_fields_of_view),
                                       cmocka_unit_test(test_fields_of_view_of_grid),
                                       cmocka_unit_test(test_exact_near_the_ground),
                                       cmocka_unit_test(test_other_settings),
                                       cmocka_unit_test(test_grids)};
    int rc = scene_open();
    return rc ? rc : scene_close(cmocka_run_group_tests(tests, NULL, NULL));
}
