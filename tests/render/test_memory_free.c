// Levels below all data that are not kept but made anew in each frame (Asirvatham & Hoppe 2005,
// 2.6.3) against the same levels kept: the same depths, bit for bit, with less memory; no hole
// while they come and go, nor where they cannot be made.
//
// Mutations: two layers of heights exchanged, or one; normals of the level before (colour); four
// layers of convexity (colour); the sweep not begun anew for the shading (colour), or not for the
// geometry (depths); no ramp between a level and the one before, or no fade one after the other
// (never_more_than_two); culling below all data (same_picture).
#include "render/gaps.h"

#include <unistd.h>

#include "render/fleeting.h"

enum { PIXELS = SCENE_WIDTH * SCENE_HEIGHT, ZOOM = 3, KEPT = 5, LEVELS = 24 };

static const double RAD = M_PI / 180;
static char planet_path[64];

static perigee_planet *open_planet(bool flat)
{
    perigee_planet *planet;
    perigee_planet_params params = {.flat = flat};
    assert_int_equal(perigee_planet_open(planet_path, &params, &planet), 0);
    return planet;
}

static perigee_view *view_of(perigee_planet *planet, perigee_view_params p, bool memory_free)
{
    p.mode = PERIGEE_MODE_PLANAR;
    p.identify = true;
    p.gpu_synthesis = true;
    p.planar_memory_free = memory_free;
    return scene_view(planet, &p);
}

struct sight {
    float z[PIXELS], r[PIXELS], g[PIXELS], b[PIXELS];
    perigee_stats stats;
};

static void look(perigee_view *view, const perigee_camera *c, struct sight *s)
{
    perigee_planes planes = {.r = s->r, .g = s->g, .b = s->b, .z_m = s->z};
    scene_render(view, c, SCENE_WIDTH, SCENE_HEIGHT);
    assert_int_equal(perigee_view_read_planes(view, &planes), 0);
    perigee_view_get_stats(view, &s->stats);
}

static double colour_difference(const struct sight *a, const struct sight *b)
{
    double most = 0;
    for (int i = 0; i < PIXELS; i++)
        most = fmax(most, fmax(fabs((double)a->r[i] - (double)b->r[i]),
                               fmax(fabs((double)a->g[i] - (double)b->g[i]),
                                    fabs((double)a->b[i] - (double)b->b[i]))));
    return most;
}

static int differing(const float *a, const float *b)
{
    int count = 0;
    for (int i = 0; i < PIXELS; i++) count += memcmp(a + i, b + i, sizeof *a) != 0;
    return count;
}

// Places whose windows are of the tiles' width; from there on down to the ground.
static const perigee_camera places[] = {
    {.lat_deg = 20,
     .lon_deg = 30,
     .alt_m = 60000,
     .heading_deg = 40,
     .pitch_deg = -30,
     .fov_deg = 60},
    {.lat_deg = -35,
     .lon_deg = 179.99,
     .alt_m = 9000,
     .heading_deg = 90,
     .pitch_deg = -8,
     .fov_deg = 60},
    {.lat_deg = 45.5,
     .lon_deg = 10.7,
     .alt_m = 900,
     .heading_deg = 200,
     .pitch_deg = -12,
     .fov_deg = 75},
    {.lat_deg = 5,
     .lon_deg = -100,
     .alt_m = 300,
     .heading_deg = 300,
     .pitch_deg = -60,
     .fov_deg = 60},
    {.lat_deg = 31, .lon_deg = 77, .alt_m = 40, .heading_deg = 10, .pitch_deg = 2, .fov_deg = 60},
    {.lat_deg = 31, .lon_deg = 77, .alt_m = 4000, .heading_deg = 10, .pitch_deg = -9, .fov_deg = 9},
};

static perigee_camera above_ground(perigee_camera c)
{
    c.alt_m += analytic_height(c.lat_deg * RAD, c.lon_deg * RAD);
    return c;
}

static void same_pictures(bool flat, perigee_view_params params, int step, const char *what)
{
    static struct sight kept, fleeting;
    perigee_planet *planet = open_planet(flat);
    perigee_view *a = view_of(planet, params, false), *b = view_of(planet, params, true);
    double colour = 0;
    uint64_t drawn[2] = {0, 0};
    int deepest = 0;
    for (size_t i = 0; i < sizeof places / sizeof *places; i += (size_t)step) {
        perigee_camera c = above_ground(places[i]);
        look(a, &c, &kept);
        look(b, &c, &fleeting);
        int depths = differing(kept.z, fleeting.z);
        if (depths) fail_msg("%s, place %zu: %d depths differ", what, i, depths);
        colour = fmax(colour, colour_difference(&kept, &fleeting));
        assert_int_equal(kept.stats.triangles_total, fleeting.stats.triangles_total);
        drawn[0] += kept.stats.triangles_drawn;
        drawn[1] += fleeting.stats.triangles_drawn;
        if ((int)fleeting.stats.last_level > deepest) deepest = (int)fleeting.stats.last_level;
    }
    print_message("%s: down to level %d, depths and colours the same; GPU bytes %zu, %zu; "
                  "triangles drawn %llu, %llu\n",
                  what, deepest, kept.stats.gpu_bytes, fleeting.stats.gpu_bytes,
                  (unsigned long long)drawn[0], (unsigned long long)drawn[1]);
    assert_true(deepest > KEPT + 5);
    assert_true(colour == 0);
    perigee_view_destroy(&a);
    perigee_view_destroy(&b);
    perigee_planet_close(&planet);
}

static void same_picture(void **state)
{
    (void)state;
    same_pictures(false, (perigee_view_params){0}, 1, "n = 255");
    same_pictures(false, (perigee_view_params){.texels = 128}, 2, "n = 127 of 128");
    same_pictures(true, (perigee_view_params){.planar_n = 127}, 3, "flat map");
    same_pictures(false, (perigee_view_params){.planar_n = 63, .planar_packed = true}, 3,
                  "n = 63, packed");
    setenv("PERIGEE_COMPUTE", "1", 1); // as on a graphics card
    same_pictures(false, (perigee_view_params){.texels = 128}, 3, "shaded by compute");
    unsetenv("PERIGEE_COMPUTE");
}

// What is saved: heights, normals and convexity of all levels below the data but two (five), and
// their elevation maps.
static void memory(void **state)
{
    (void)state;
    perigee_planet *planet = open_planet(false);
    size_t samples = 336 * 512, map = 256 * 256 * 8, bytes[2];
    for (int i = 0; i < 2; i++) {
        perigee_view *view = view_of(planet, (perigee_view_params){0}, i == 1);
        perigee_stats stats;
        perigee_view_get_stats(view, &stats);
        bytes[i] = stats.gpu_bytes;
        perigee_view_destroy(&view);
    }
    size_t below = LEVELS - KEPT;
    assert_int_equal(bytes[0] - bytes[1],
                     (below - 2) * (samples * 8 + map) + (below - 5) * samples);
    perigee_planet_close(&planet);
}

static struct gaps_frame seen;

static void check_gaps(const char *what, int frame, const perigee_camera *c)
{
    struct gaps_counts n = gaps_find(c, &seen, 0);
    if (n.background + n.cracks + n.unidentified)
        fail_msg("%s %d: lat %.9g lon %.9g alt %.9g heading %g pitch %g: %d background pixels, %d "
                 "cracks, %d without an identifier",
                 what, frame, c->lat_deg, c->lon_deg, c->alt_m, c->heading_deg, c->pitch_deg,
                 n.background, n.cracks, n.unidentified);
}

static int finest_seen(void)
{
    int finest = 0;
    for (int i = 0; i < GAPS_PIXELS; i++) finest = seen.level[i] > finest ? seen.level[i] : finest;
    return finest;
}

static perigee_camera random_camera(struct check_random *r, double lat_deg)
{
    perigee_camera c = {.lat_deg = lat_deg,
                        .lon_deg = check_random_range(r, -180, 180),
                        .alt_m = pow(10, check_random_range(r, 1.5, 5)),
                        .heading_deg = check_random_range(r, 0, 360),
                        .pitch_deg = check_random_range(r, -90, 0),
                        .fov_deg = check_random_range(r, 46, 100)};
    return above_ground(c);
}

// A jump to a new place, then steps away from it, with what data happens to be there; then the
// picture is that of the levels kept, whatever the way.
static void coming_and_going(void **state)
{
    (void)state;
    enum { JUMPS = 7, STEPS = 4 };
    static struct sight kept, fleeting;
    perigee_planet *planet = open_planet(false);
    perigee_view_params small = {.planar_n = 63};
    perigee_view *a = view_of(planet, small, false), *b = view_of(planet, small, true);
    struct check_random r = {31};
    int late = 0, below = 0;
    for (int i = 0; i < JUMPS; i++) {
        perigee_camera c = random_camera(&r, check_random_range(&r, -50, 50));
        double above = c.alt_m - analytic_height(c.lat_deg * RAD, c.lon_deg * RAD);
        for (int k = 0; k < STEPS; k++) {
            c.lon_deg += 0.3 * above / 6.4e6 / RAD;
            scene_bind(GAPS_WIDTH, GAPS_HEIGHT);
            assert_int_equal(perigee_view_set_camera(b, &c), 0);
            if (k == 1) assert_int_equal(perigee_view_wait(b, GAPS_WIDTH, GAPS_HEIGHT, 60), 0);
            assert_int_equal(perigee_view_render(b, GAPS_WIDTH, GAPS_HEIGHT), 0);
            gaps_read(b, &seen);
            late += seen.late;
            below += finest_seen() >= KEPT;
            if (above > 300)
                check_gaps("on the way", STEPS * i + k, &c); // else late data may hide it
        }
        c.alt_m = analytic_height(c.lat_deg * RAD, c.lon_deg * RAD) + above;
        look(a, &c, &kept);
        look(b, &c, &fleeting);
        assert_int_equal(differing(kept.z, fleeting.z), 0);
        assert_true(colour_difference(&kept, &fleeting) == 0);
    }
    print_message("%d frames late, %d with fleeting levels\n", late, below);
    assert_true(late > 0);
    assert_true(below >= JUMPS / 2);
    perigee_view_destroy(&a);
    perigee_view_destroy(&b);
    perigee_planet_close(&planet);
}

// Near a pole and where tiles change their width the levels are left out, and the ground is whole.
static void where_it_cannot_be(void **state)
{
    (void)state;
    static const double latitudes[] = {60, -60, 75.5, -75.5, 82.8, 59.7};
    perigee_planet *planet = open_planet(false);
    perigee_view *view = view_of(planet, (perigee_view_params){.planar_n = 63}, true);
    struct check_random r = {8};
    int without = 0;
    for (int i = 0; i < 12; i++) {
        perigee_camera c = random_camera(&r, latitudes[i % 6]);
        scene_render(view, &c, GAPS_WIDTH, GAPS_HEIGHT);
        gaps_read(view, &seen);
        check_gaps("latitude", i, &c);
        without += finest_seen() < KEPT && seen.last_level > KEPT;
    }
    print_message("%d of 12 views without fleeting levels\n", without);
    assert_true(without > 4);
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
}

// A level is there only when the one before it has the whole weight all over it (lib/windows.glsl:
// from 5 samples inside its border on), for the one before that is gone by then.
static void never_more_than_two(void **state)
{
    (void)state;
    const window_shape shape = window_height_shape(256);
    const clipmap_level data = {.min = 1, .max = 2};
    struct check_random r = {77};
    int there = 0, absent = 0;
    for (int i = 0; i < 20000; i++) {
        double lat = check_random_range(&r, -0.9, 0.9), lon = check_random_range(&r, -9, 9);
        int level = 3 + i % 15, cut[4];
        window before = window_at(&shape, level - 1, lat, lon, 1.0034);
        struct fleeting f = {.kept = level, .levels = level + 1};
        window w = f.window[level] = window_at(&shape, level, lat, lon, 1.0034);
        if (w.share != before.share + 1 || before.share == 0) continue;
        for (int k = 0; k < 4; k++) cut[k] = (int)check_random_range(&r, 0, k < 2 ? 100 : 140);
        struct shown s = {.row0 = (double)before.rect.row0 + cut[0],
                          .row1 = (double)before.rect.row1 - cut[1],
                          .col0 = (double)before.rect.col0 + cut[2],
                          .col1 = (double)before.rect.col1 - cut[3],
                          .zoom = before.zoom,
                          .share = before.share,
                          .fade = i % 5 ? 1 : 0.99f};
        clipmap_level state_of = fleeting_state(&f, &shape, level, &s, &data);
        if (window_rect_empty(state_of.valid)) {
            absent++;
            continue;
        }
        double middle = 0.25 * (double)(w.rect.col0 + w.rect.col1),
               circle = ldexp(shape.cols, before.share);
        double turn = circle * floor((0.5 * (s.col0 + s.col1) - middle) / circle + 0.5);
        assert_true(s.fade == 1);
        assert_true(0.5 * (double)w.rect.row0 - s.row0 >= 5);
        assert_true(s.row1 - 0.5 * (double)w.rect.row1 >= 5);
        assert_true(0.5 * (double)w.rect.col0 + turn - s.col0 >= 5);
        assert_true(s.col1 - 0.5 * (double)w.rect.col1 - turn >= 5);
        there++;
    }
    print_message("%d times there, %d not\n", there, absent);
    assert_true(there > 500 && absent > 500);
}

static void refused(void **state)
{
    (void)state;
    perigee_planet *planet = open_planet(false);
    perigee_view *view;
    perigee_view_params p = {.mode = PERIGEE_MODE_PLANAR,
                             .planar_form = PERIGEE_PLANAR_2004,
                             .planar_memory_free = true};
    assert_int_equal(perigee_view_create(planet, &p, &view), 1);
    assert_null(view);
    perigee_planet_close(&planet);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(same_picture),        cmocka_unit_test(memory),
        cmocka_unit_test(coming_and_going),    cmocka_unit_test(where_it_cannot_be),
        cmocka_unit_test(never_more_than_two), cmocka_unit_test(refused),
    };
    int rc = scene_open();
    if (rc) return rc;
    snprintf(planet_path, sizeof planet_path, "memory-free-%d.planet", (int)getpid());
    analytic_params with = {.zoom = ZOOM,
                            .color_zoom = 3,
                            .ellipsoid = GEO_WGS84,
                            .direct = true,
                            .synthesis_gain = 0.45};
    if (analytic_planet_make_with(planet_path, &with)) return 1;
    rc = cmocka_run_group_tests(tests, NULL, NULL);
    unlink(planet_path);
    return scene_close(rc);
}
