// Nothing pops and nothing swims. Frames on both sides of every place where the renderer changes
// its levels or windows, a millionth of a step apart, are the same within bounds; along flights the
// picture changes as the reference's does; a fixed point of the ground stays where it is. Bounds
// are two to three times what was measured (tests/ACCURACY.md, 6).
#include "render/temporal.h"

#include <gdal.h>
#include <ogr_srs_api.h>
#include <unistd.h>

#include "clipmap/window.h"
#include "gpu/gpu_fixture.h"
#include "planet/import.h"
#include "reference/sight.h"
#include "render/view.h"

static const double RAD = M_PI / 180;

// The rough planet, a place on it, and what the bounds of walks are multiplied by: real relief is
// several times as rough.
static const char *rough, *imagery = EARTH_PLANET;
static double lat_deg = 31, lon_deg = 12, on_walk = 1;

static void show(const char *name, const temporal_change *c)
{
    print_message("%-34s: %.4f %.4f %.4f px, colour %.3f %.2f %.2f / 255, %d pixels, %d at "
                  "silhouettes\n",
                  name, c->rms_px, c->p999_px, c->worst_px, c->rms, c->p999, c->worst, c->compared,
                  c->silhouette);
}

static int last_level(const temporal_scene *s, const perigee_camera *c)
{
    perigee_stats stats;
    scene_bind(TEMPORAL_WIDTH, TEMPORAL_HEIGHT);
    assert_int_equal(perigee_view_set_camera(s->view, c), 0);
    assert_int_equal(perigee_view_render(s->view, TEMPORAL_WIDTH, TEMPORAL_HEIGHT), 0);
    perigee_view_get_stats(s->view, &stats);
    return (int)stats.last_level;
}

// The heights above ground between which the finest level changes to `level` or finer, 1e-7 apart.
static void find_switch(const temporal_scene *s, perigee_camera c, double ground, int level,
                        double *low, double *high)
{
    *low = 1;
    *high = 4e7;
    while (*high / *low - 1 > 1e-7) {
        double middle = sqrt(*low * *high);
        c.alt_m = ground + middle;
        if (last_level(s, &c) >= level) *low = middle;
        else *high = middle;
    }
}

// Straight down through the switches of the finest level. Looking 25 degrees off the nadir, where
// the new level lies in the picture and its heights are seen.
static void test_level_switches(void **state)
{
    (void)state;
    static temporal_picture a, b;
    temporal_scene s = temporal_open(rough, true, NULL);
    perigee_camera c = {
        .lat_deg = lat_deg, .lon_deg = lon_deg, .heading_deg = 40, .pitch_deg = -65, .fov_deg = 60};
    double ground = temporal_ground(&s, c.lat_deg, c.lon_deg);
    for (int level = 4; level <= 20; level += 4) {
        double low, high;
        char name[64];
        find_switch(&s, c, ground, level, &low, &high);
        c.alt_m = ground + high;
        int above = temporal_see(&s, &c, &a);
        c.alt_m = ground + low;
        assert_int_equal(temporal_see(&s, &c, &b), above + 1);
        temporal_change change = temporal_compare(&s, &c, &a, &b, NULL, NULL);
        snprintf(name, sizeof name, "level %d to %d at %.4g m", above, above + 1, low);
        show(name, &change);
        assert_true(change.worst_px <= 0.002 + 2 * gpu_fixture_snap_px());
        assert_true(change.rms <= 0.03);
        assert_true(change.worst <= 0.5);
    }
    temporal_close(&s);
}

// What of a frame changes from one moment to the next as the camera descends: the finest rings and
// heights, and by the triangles of a frame that culls nothing how many rings and columns are left
// out.
struct mesh {
    int last, finest;
    uint64_t triangles;
};

static bool same_mesh(struct mesh a, struct mesh b)
{
    return a.last == b.last && a.finest == b.finest && a.triangles == b.triangles;
}

static struct mesh mesh_at(const temporal_scene *s, perigee_camera *c, double height)
{
    perigee_stats stats;
    c->alt_m = height;
    int last = last_level(s, c);
    perigee_view_get_stats(s->view, &stats);
    return (struct mesh){last, windows_last_height(s->view->windows), stats.triangles_drawn};
}

// Every such change on the way down through two octaves far from the ground and two near to it.
static void test_nothing_pops(void **state)
{
    (void)state;
    enum { STEPS = 40 };
    static temporal_picture a, b;
    temporal_scene s = temporal_open(rough, true, &(perigee_view_params){.no_cull = true});
    perigee_camera c = {
        .lat_deg = lat_deg, .lon_deg = lon_deg, .heading_deg = 40, .pitch_deg = -65, .fov_deg = 60};
    double ground = temporal_ground(&s, c.lat_deg, c.lon_deg), from[] = {2.3e6, 3.2e5, 120};
    const double snap = 2 * gpu_fixture_snap_px();
    int changes = 0;
    for (int f = 0; f < 3 * STEPS; f++) {
        double high = from[f / STEPS] * pow(0.25, (double)(f % STEPS) / STEPS),
               low = high * pow(0.25, 1.0 / STEPS);
        mesh_at(&s, &c, ground + low);
        temporal_see(&s, &c, &b); // so that what follows knows the ground
        struct mesh was = mesh_at(&s, &c, ground + high), is = mesh_at(&s, &c, ground + low);
        if (same_mesh(was, is)) continue;
        while (high / low - 1 > 1e-7) {
            double middle = sqrt(low * high);
            if (same_mesh(was, mesh_at(&s, &c, ground + middle))) high = middle;
            else low = middle;
        }
        c.alt_m = ground + high;
        temporal_see(&s, &c, &a);
        is = mesh_at(&s, &c, ground + low);
        temporal_see(&s, &c, &b);
        temporal_change change = temporal_compare(&s, &c, &a, &b, NULL, NULL);
        char name[64];
        snprintf(name, sizeof name, "%.4g m, rings %d, heights %d to %d", low, is.last, was.finest,
                 is.finest);
        show(name, &change);
        changes++;
        assert_true(change.worst_px <= (was.finest == is.finest ? 0.002 : 0.05) + snap);
        assert_true(change.worst <= 1);
    }
    assert_true(changes >= 12);
    temporal_close(&s);
}

// The distance by which levels are chosen is that to the ground with its synthesis, and has no step
// where finer samples of it are asked.
static void test_ground_is_where_it_is(void **state)
{
    (void)state;
    temporal_scene s = temporal_open(rough, true, NULL);
    double ground = temporal_ground(&s, lat_deg, lon_deg), before = INFINITY, worst = 0, step = 0;
    for (double above = 2e5; above > 1; above *= 0.99) {
        geo_camera c = {.position = {lat_deg * RAD, lon_deg * RAD, ground + above},
                        .pitch = -1,
                        .fov_y = 60 * RAD};
        double distance = gaze_find(s.pyramid, &c, 4 / 3.0).distance;
        worst = fmax(worst, fabs(distance / above - 1));
        if (isfinite(before)) step = fmax(step, fabs(distance / before - 1));
        before = distance;
    }
    print_message("distance to the ground off by %.3f of it, %.3f from step to step\n", worst,
                  step);
    assert_true(worst <= 0.4);
    assert_true(step <= 0.03);
    temporal_close(&s);
}

static int share_at(const window_shape *shape, int level, double lat)
{
    return window_at(shape, level, lat, 0, 6378137.0 / 6356752.314245179).share;
}

// The latitudes (rad) next above `from` between which the share of a level's window changes.
static bool find_share(const window_shape *shape, int level, double from, double *low, double *high)
{
    const double step = 0.01 * RAD;
    int share = share_at(shape, level, from);
    for (*low = from; *low < 89.5 * RAD; *low += step)
        if (share_at(shape, level, *low + step) != share) break;
    *high = *low + step;
    if (*low >= 89.5 * RAD) return false;
    while (*high - *low > 1e-11) {
        double middle = 0.5 * (*low + *high);
        if (share_at(shape, level, middle) == share) *low = middle;
        else *high = middle;
    }
    return true;
}

// Northwards over the latitudes where a window's columns become twice as wide.
static void test_shares(void **state)
{
    (void)state;
    static temporal_picture a, b;
    temporal_scene s = temporal_open(rough, true, NULL);
    const window_shape shape = window_height_shape(256);
    const struct {
        int level;
        double from_deg;
    } shares[] = {{6, 50}, {8, 50}, {10, 50}, {12, 50}, {10, 70}, {9, 80}, {11, 87}};
    for (size_t i = 0; i < sizeof shares / sizeof *shares; i++) {
        double low, high;
        char name[64];
        assert_true(find_share(&shape, shares[i].level, shares[i].from_deg * RAD, &low, &high));
        perigee_camera c = {.lat_deg = low / RAD,
                            .lon_deg = 12,
                            .heading_deg = 40,
                            .pitch_deg = -25,
                            .fov_deg = 60};
        c.alt_m = temporal_ground(&s, c.lat_deg, c.lon_deg) + 3000;
        temporal_see(&s, &c, &a);
        c.lat_deg = high / RAD;
        temporal_see(&s, &c, &b);
        temporal_change change = temporal_compare(&s, &c, &a, &b, NULL, NULL);
        snprintf(name, sizeof name, "share of level %d at %.3f N", shares[i].level, c.lat_deg);
        show(name, &change);
        assert_true(change.p999_px <= 0.03);
        assert_true(change.rms <= 0.45);
        assert_true(change.p999 <= 2.6);
    }
    temporal_close(&s);
}

// The same for imagery, seen from 300 and 100 km.
static void test_imagery_shares(void **state)
{
    (void)state;
    static temporal_picture a, b;
    if (access(imagery, R_OK)) {
        print_message("%s: not there, nothing tested\n", imagery);
        skip();
    }
    temporal_scene s = temporal_open(imagery, true, NULL);
    const window_shape shape = WINDOW_COLOR;
    const struct {
        int level;
        double from_deg, alt_m;
    } shares[] = {{2, 40, 3e5}, {3, 40, 3e5}, {3, 60, 3e5}, {4, 40, 3e5},
                  {4, 65, 3e5}, {5, 40, 1e5}, {5, 65, 1e5}};
    for (size_t i = 0; i < sizeof shares / sizeof *shares; i++) {
        double low, high;
        char name[64];
        assert_true(find_share(&shape, shares[i].level, shares[i].from_deg * RAD, &low, &high));
        perigee_camera c = {.lat_deg = low / RAD,
                            .lon_deg = 10,
                            .alt_m = shares[i].alt_m,
                            .heading_deg = 40,
                            .pitch_deg = -60,
                            .fov_deg = 60};
        temporal_see(&s, &c, &a);
        c.lat_deg = high / RAD;
        temporal_see(&s, &c, &b);
        temporal_change change = temporal_compare(&s, &c, &a, &b, NULL, NULL);
        snprintf(name, sizeof name, "imagery of level %d at %.3f N", shares[i].level, c.lat_deg);
        show(name, &change);
        assert_true(change.rms <= 0.7);
        assert_true(change.p999 <= 2);
    }
    temporal_close(&s);
}

// Flights over planets whose ground is known in closed form. Steps move the picture by a pixel or
// two; on the ground by up to thirty.
enum { FRAMES = 4 };

typedef void (*flight)(int i, perigee_camera *c);

static void over_the_pole(int i, perigee_camera *c)
{
    temporal_cross_pole(c, 1, 25, 0.2 * (i - 2.5));
    c->alt_m = 30000;
}

static void over_the_south_pole(int i, perigee_camera *c)
{
    temporal_cross_pole(c, -1, 115, 0.2 * (i - 3));
    c->alt_m = 30000;
}

static void over_the_antimeridian(int i, perigee_camera *c)
{
    *c = (perigee_camera){.lat_deg = 35, .lon_deg = 180 + 0.2 * (i - 2.5), .alt_m = 30000};
    c->heading_deg = 80;
}

static void down(int i, perigee_camera *c)
{
    *c = (perigee_camera){.lat_deg = -20, .lon_deg = 70, .heading_deg = 120};
    c->alt_m = analytic_height(-20 * RAD, 70 * RAD) + 20000 * pow(0.98, i);
}

static void along_the_ground(int i, perigee_camera *c)
{
    double metre = 1 / (6.37e6 * RAD);
    *c = (perigee_camera){.lat_deg = 10 + 0.1 * i * metre, .lon_deg = 33, .heading_deg = 0};
    c->alt_m = analytic_height(c->lat_deg * RAD, c->lon_deg * RAD) + 2;
}

static const struct {
    const char *name;
    flight at;
    double pitch;
    const char *(*planet)(void);
    int zoom;           // of the reference: its facets are too small to see
    double rms, p999;   // by which the colour may change more than the reference's, 1/255
    double own, own999; // change of the pixels' difference from the reference's
} flights[] = {
    {"over the north pole", over_the_pole, -35, temporal_pebble, -1, 0.1, 0.5, 0.7, 3},
    {"over the south pole", over_the_south_pole, -35, temporal_pebble, -1, 0.1, 0.5, 0.7, 3},
    {"over the antimeridian", over_the_antimeridian, -35, temporal_pebble, -1, 0.1, 0.5, 0.7, 3},
    {"down", down, -60, temporal_pebble, -1, 0.1, 1, 0.4, 5},
    {"0.1 m steps on the ground", along_the_ground, -20, temporal_analytic, 9, 0.2, 1, 0.2, 1},
};
enum { FLIGHTS = sizeof flights / sizeof *flights };

static void test_flights_change_as_the_reference(void **state)
{
    (void)state;
    static temporal_picture seen[2], truth[2];
    for (int f = 0; f < FLIGHTS; f++) {
        temporal_scene s = temporal_open(flights[f].planet(), false, NULL);
        for (int i = 0; i < FRAMES; i++) {
            perigee_camera c = {0}; // the pole flights leave the roll as it is
            flights[f].at(i, &c);
            c.pitch_deg = flights[f].pitch;
            c.fov_deg = 60;
            temporal_see(&s, &c, &seen[i % 2]);
            temporal_see_reference(&s, &c, flights[f].zoom, &truth[i % 2]);
            if (i == 0) continue;
            const temporal_picture *a = &seen[(i + 1) % 2], *b = &seen[i % 2],
                                   *ra = &truth[(i + 1) % 2], *rb = &truth[i % 2];
            temporal_change seen_change = temporal_compare(&s, &c, a, b, NULL, NULL),
                            own = temporal_compare(&s, &c, ra, rb, NULL, NULL),
                            excess = temporal_compare(&s, &c, a, b, ra, rb);
            show(flights[f].name, &seen_change);
            show("  the reference", &own);
            show("  beyond it", &excess);
            assert_true(seen_change.rms <= own.rms + flights[f].rms);
            assert_true(seen_change.p999 <= own.p999 + flights[f].p999);
            assert_true(excess.rms <= flights[f].own);
            assert_true(excess.p999 <= flights[f].own999);
            assert_true(excess.worst_px <= 0.1);
        }
        temporal_close(&s);
    }
}

// Points of the ground spread over what a camera sees, at distances from half to twenty times its
// height above ground.
enum { POINTS = 40, STEPS = 12 };

struct track {
    double lat, lon, height, last;
};

static void lay_points(const temporal_scene *s, const perigee_camera *c, struct track *t,
                       bool exact)
{
    double above = c->alt_m - temporal_ground(s, c->lat_deg, c->lon_deg), a = s->ellipsoid.a;
    for (int k = 0; k < POINTS; k++) {
        double far = above * 0.5 * pow(40, (k + 0.5) / POINTS) / a,
               turn = c->heading_deg * RAD + 0.5 * sin(2.4 * k);
        double lat = c->lat_deg * RAD, lon = c->lon_deg * RAD;
        // Great circle, so that a pole is no special place.
        double sine = sin(lat) * cos(far) + cos(lat) * sin(far) * cos(turn);
        t[k].lat = asin(fmin(fmax(sine, -1), 1));
        t[k].lon = lon + atan2(sin(turn) * sin(far) * cos(lat), cos(far) - sin(lat) * sine);
        t[k].height = exact ? analytic_height(t[k].lat, t[k].lon)
                            : temporal_ground(s, t[k].lat / RAD, t[k].lon / RAD);
        t[k].last = NAN;
    }
}

struct swim {
    double sum, worst, jump_sum, jump; // px: deviation, and its change from frame to frame
    double beyond, own;                // px, at most: less what frames of the reference have; that
    int count, jumps;
};

static void follow(const temporal_scene *s, const perigee_camera *c, struct track *t,
                   struct swim *w)
{
    static temporal_picture picture;
    temporal_see(s, c, &picture);
    for (int k = 0; k < POINTS; k++) {
        double e = temporal_deviation(s, c, &picture, t[k].lat, t[k].lon, t[k].height);
        double jump = fabs(e - t[k].last);
        t[k].last = e;
        if (isnan(e)) continue;
        w->count++;
        w->sum += e * e;
        w->worst = fmax(w->worst, fabs(e));
        if (isnan(jump)) continue;
        w->jumps++;
        w->jump_sum += jump * jump;
        w->jump = fmax(w->jump, jump);
    }
}

// How far off the points are beyond what the measure has of itself, which takes the ground between
// four pixels for a plane: by a frame of the reference.
static void follow_reference(const temporal_scene *s, const perigee_camera *c,
                             const struct track *t, struct swim *w)
{
    static temporal_picture truth;
    temporal_see_reference(s, c, SIGHT_AUTO, &truth);
    for (int k = 0; k < POINTS; k++) {
        double own = temporal_deviation(s, c, &truth, t[k].lat, t[k].lon, t[k].height);
        if (isnan(own) || isnan(t[k].last)) continue;
        w->own = fmax(w->own, fabs(own));
        w->beyond = fmax(w->beyond, fabs(t[k].last - own));
    }
}

static void show_swim(const char *name, const struct swim *w)
{
    print_message("%-28s: off by %.4f rms, %.4f px at most (%d); moves by %.4f rms, %.4f px at "
                  "most (%d)\n",
                  name, sqrt(w->sum / w->count), w->worst, w->count, sqrt(w->jump_sum / w->jumps),
                  w->jump, w->jumps);
}

static void test_points_stay(void **state)
{
    (void)state;
    for (int f = 0; f < FLIGHTS; f++) {
        temporal_scene s = temporal_open(flights[f].planet(), false, NULL);
        struct track t[POINTS];
        struct swim w = {0};
        for (int i = 0; i < STEPS; i++) {
            perigee_camera c = {0}; // the pole flights leave the roll as it is
            flights[f].at(i, &c);
            c.pitch_deg = flights[f].pitch;
            c.fov_deg = 60;
            if (i == 0) lay_points(&s, &c, t, true);
            follow(&s, &c, t, &w);
        }
        show_swim(flights[f].name, &w);
        assert_true(w.count > POINTS * STEPS / 4);
        assert_true(w.worst <= 0.1);
        assert_true(w.jump <= 0.045);
        temporal_close(&s);
    }
}

// Rough ground, synthesised down to centimetres: what the sliding rings make of detail as fine as
// they are.
static void test_rough_ground(void **state)
{
    (void)state;
    temporal_scene s = temporal_open(rough, true, NULL);
    const struct {
        double above, step, beyond; // of relief
    } walks[] = {
        {300000, 500, 0.04}, {10000, 20, 0.75}, {300, 0.5, 0.3}, {20, 0.1, 0.25}, {2, 0.1, 0.15}};
    for (size_t f = 0; f < sizeof walks / sizeof *walks; f++) {
        struct track t[POINTS];
        struct swim w = {0};
        char name[64];
        perigee_camera c = {.lon_deg = lon_deg, .heading_deg = 0, .pitch_deg = -25, .fov_deg = 60};
        double ground = temporal_ground(&s, lat_deg, lon_deg);
        bool judged = on_walk > 1 || walks[f].above == 2; // which takes its time
        for (int i = 0; i < STEPS; i++) {
            c.lat_deg = lat_deg + walks[f].step * i / 6.37e6 / RAD;
            c.alt_m = ground + walks[f].above;
            if (i == 0) lay_points(&s, &c, t, false);
            follow(&s, &c, t, &w);
            if (i == 0 && judged) follow_reference(&s, &c, t, &w);
        }
        snprintf(name, sizeof name, "%g m above, %g m a frame", walks[f].above, walks[f].step);
        show_swim(name, &w);
        if (judged)
            print_message("  beyond the reference %.4f px at most, which has %.4f\n", w.beyond,
                          w.own);
        assert_true(w.count > POINTS * STEPS / 4);
        assert_true(w.beyond <= (on_walk > 1 ? walks[f].beyond : 0.1));
        // From 2 m above the rough planet the measure itself has 0.53.
        assert_true(w.worst <= fmax(0.3 * on_walk, walks[f].above == 2 ? 0.6 : 0));
        assert_true(w.jump <= (on_walk > 1 ? 0.15 : 0.06));
    }
    temporal_close(&s);
}

// A picture of the whole map, which does not say so, as a raster that does.
static void reference_picture(const char *path, const char *output)
{
    GDALAllRegister();
    GDALDatasetH picture = GDALOpen(path, GA_ReadOnly);
    assert_non_null(picture);
    double step = 360.0 / GDALGetRasterXSize(picture), place[] = {-180, step, 0, 90, 0, -step};
    GDALDatasetH map =
        GDALCreateCopy(GDALGetDriverByName("VRT"), output, picture, false, NULL, NULL, NULL);
    assert_non_null(map);
    assert_int_equal(GDALSetProjection(map, SRS_WKT_WGS84_LAT_LONG), CE_None);
    assert_int_equal(GDALSetGeoTransform(map, place), CE_None);
    GDALClose(map);
    GDALClose(picture);
}

// Imports a raster of heights, and imagery where there is some, unless it was; false when a file is
// not there.
static bool make_planet(const char *output, const char *heights, const char *picture)
{
    import_source sources[] = {{.layer = LAYER_HEIGHT, .path = heights},
                               {.layer = LAYER_COLOR, .path = "imagery.vrt"}};
    import_params params = {
        .sources = sources, .source_count = picture ? 2 : 1, .output = output, .name = "Relief"};
    if (access(heights, R_OK) || (picture && access(picture, R_OK))) {
        print_message("%s, %s: not there, skipped\n", heights, picture ? picture : "no imagery");
        return false;
    }
    if (!access(output, R_OK)) return true;
    if (picture) reference_picture(picture, "imagery.vrt");
    return !import_run(&params);
}

// Without an argument everything, on planets made here; with a raster of real heights what needs
// rough ground, in the Alps; with imagery too what needs that.
int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_level_switches),
        cmocka_unit_test(test_nothing_pops),
        cmocka_unit_test(test_ground_is_where_it_is),
        cmocka_unit_test(test_shares),
        cmocka_unit_test(test_rough_ground),
        cmocka_unit_test(test_imagery_shares),
        cmocka_unit_test(test_flights_change_as_the_reference),
        cmocka_unit_test(test_points_stay),
    };
    const char *made = argc > 2 ? "imagery.planet" : "relief.planet";
    if (argc > 1 && !make_planet(made, argv[1], argc > 2 ? argv[2] : NULL)) return 77;
    int rc = scene_open();
    if (rc) return rc;
    if (argc > 2) {
        imagery = made;
        return scene_close(_cmocka_run_group_tests("imagery", tests + 5, 1, NULL, NULL));
    }
    if (argc == 1) {
        rough = temporal_rough();
        return scene_close(cmocka_run_group_tests(tests, NULL, NULL));
    }
    rough = made;
    lat_deg = 46.5;
    lon_deg = 10.5;
    on_walk = 2.5;
    return scene_close(_cmocka_run_group_tests("relief", tests, 5, NULL, NULL));
}
