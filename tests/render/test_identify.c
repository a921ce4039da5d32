// The identifier buffer says the truth: levels and sectors against the geodetic point under each
// pixel, numbers against their own counts; and asking for it changes no pixel.
#include "render/scene.h"

enum { PIXELS = SCENE_WIDTH * SCENE_HEIGHT };

static const perigee_camera CAMERAS[] = {
    {.lat_deg = 45.5, .lon_deg = 10.7, .alt_m = 2e7, .pitch_deg = -90, .fov_deg = 60},
    {.lat_deg = -12, .lon_deg = 100, .alt_m = 30000, .pitch_deg = -20, .fov_deg = 60},
    {.lat_deg = 3, .lon_deg = -20, .alt_m = 8000, .pitch_deg = -88, .fov_deg = 90},
};

struct sight {
    uint32_t triangle[PIXELS];
    int level[PIXELS], sector[PIXELS];
    float z[PIXELS], continuous[PIXELS];
    double lat[PIXELS], lon[PIXELS];
    uint8_t rgb[3 * PIXELS];
    perigee_triangles counts;
};

static void look(perigee_view *view, const perigee_camera *c, bool identify, struct sight *s)
{
    scene_render(view, c, SCENE_WIDTH, SCENE_HEIGHT);
    perigee_planes planes = {
        .z_m = s->z, .level = s->continuous, .lat_deg = s->lat, .lon_deg = s->lon};
    assert_int_equal(perigee_view_read_planes(view, &planes), 0);
    s->counts =
        (perigee_triangles){.triangle = s->triangle, .level = s->level, .sector = s->sector};
    if (identify) assert_int_equal(perigee_view_read_triangles(view, &s->counts), 0);
    assert_int_equal(perigee_view_render_image(view, SCENE_WIDTH, SCENE_HEIGHT, 1, s->rgb), 0);
}

// Sectors clockwise from north of a point about the camera, on the sphere of reduced latitude.
static double sector_of(const perigee_camera *c, double lat_deg, double lon_deg)
{
    const double rad = M_PI / 180, flat = 6356752.314245179 / 6378137.0;
    double b = atan(flat * tan(lat_deg * rad)), b0 = atan(flat * tan(c->lat_deg * rad));
    double dl = (lon_deg - c->lon_deg) * rad;
    double east = cos(b) * sin(dl), north = sin(b) * cos(b0) - cos(b) * sin(b0) * cos(dl);
    double turn = atan2(east, north) / (2 * M_PI);
    return 32 * (turn < 0 ? turn + 1 : turn);
}

// A vertex's height moves it along the normal, which on an ellipsoid is not the radius: a border
// lies where it should to within 2 % of a level.
static void check_pixels(const perigee_camera *c, int last, const struct sight *s)
{
    uint64_t ground = 0;
    int wrong_level = 0, wrong_sector = 0;
    for (int k = 0; k < PIXELS; k++) {
        assert_int_equal(s->triangle[k] != 0, !isnan(s->z[k]));
        assert_int_equal(s->level[k] >= 0, !isnan(s->z[k]));
        if (isnan(s->z[k])) continue;
        ground++;
        double level = s->continuous[k], sector = sector_of(c, s->lat[k], s->lon[k]);
        bool border = fabs(level - round(level)) < 0.02;
        wrong_level += !border && s->level[k] != (level > last + 0.99 ? last + 1 : (int)level);
        border = fabs(sector - round(sector)) < 0.03 || s->continuous[k] > last + 0.99;
        wrong_sector += !border && s->sector[k] != (int)sector;
    }
    print_message("%d pixels: %d of a wrong level, %d of a wrong sector; %d triangles\n",
                  (int)ground, wrong_level, wrong_sector, (int)s->counts.visible);
    assert_int_equal(ground, s->counts.ground_pixels);
    assert_int_equal(wrong_level, 0);
    assert_int_equal(wrong_sector, 0);
}

// Counts by a table over all numbers, and sees that a number means one level and one sector.
static void check_numbers(const struct sight *s, uint64_t drawn)
{
    enum { MOST = 1 << 22 };
    int *owner = calloc(MOST, sizeof *owner); // level * 32 + sector + 1
    uint64_t visible = 0;
    for (int k = 0; k < PIXELS; k++) {
        uint32_t t = s->triangle[k];
        if (!t) continue;
        assert_true(t < MOST);
        int is = s->level[k] * 32 + s->sector[k] + 1;
        visible += owner[t] == 0;
        assert_true(owner[t] == 0 || owner[t] == is);
        owner[t] = is;
    }
    free(owner);
    assert_int_equal(visible, s->counts.visible);
    assert_true(visible <= drawn);
}

static void test_identifiers_are_true(void **state)
{
    (void)state;
    static struct sight plain, named;
    perigee_planet *planet = scene_planet();
    perigee_view_params params = {.identify = true};
    perigee_view *view = scene_view(planet, NULL), *identifier = scene_view(planet, &params);
    for (size_t i = 0; i < sizeof CAMERAS / sizeof *CAMERAS; i++) {
        perigee_stats stats;
        look(view, &CAMERAS[i], false, &plain);
        look(identifier, &CAMERAS[i], true, &named);
        perigee_view_get_stats(identifier, &stats);
        check_pixels(&CAMERAS[i], (int)stats.last_level, &named);
        check_numbers(&named, stats.triangles_drawn);
        assert_memory_equal(plain.rgb, named.rgb, sizeof plain.rgb);
        assert_memory_equal(plain.lat, named.lat, sizeof plain.lat);
    }
    perigee_view_destroy(&view);
    perigee_view_destroy(&identifier);
    perigee_planet_close(&planet);
}

// Along a line of pixels 1/z is straight inside a triangle and bends where two meet: how much at
// pixel k, times z.
static double bend(const float *z, int k)
{
    return fabs(1 / (double)z[k - 1] - 2 / (double)z[k] + 1 / (double)z[k + 1]) * (double)z[k];
}

// A coarse mesh from near by, so that its triangles are large and far from coplanar: pixels of one
// number lie in one plane, and where the number changes the plane does, but for the diagonals of
// quads (a third of the edges), whose four corners lie in one plane on a sphere.
static void test_a_number_is_a_plane(void **state)
{
    (void)state;
    static struct sight s;
    perigee_planet *planet = scene_planet();
    perigee_view_params params = {.identify = true, .azimuth_steps = 64, .rings_per_level = 4};
    perigee_view *view = scene_view(planet, &params);
    perigee_camera c = {
        .lat_deg = 20, .lon_deg = 30, .alt_m = 3e6, .pitch_deg = -60, .fov_deg = 50};
    look(view, &c, true, &s);
    int inside = 0, bent = 0, changes = 0, unseen = 0;
    for (int k = 1; k + 2 < PIXELS; k++) {
        if (k % SCENE_WIDTH == 0 || k % SCENE_WIDTH >= SCENE_WIDTH - 2) continue;
        const uint32_t *t = s.triangle + k;
        if (!t[-1] || !t[0] || !t[1] || !t[2]) continue;
        bool same = t[-1] == t[0] && t[0] == t[1];
        bool change = t[-1] == t[0] && t[0] != t[1] && t[1] == t[2];
        inside += same;
        bent += same && bend(s.z, k) > 1e-6;
        changes += change;
        unseen += change && bend(s.z, k) < 1e-6 && bend(s.z, k + 1) < 1e-6;
    }
    print_message("%d pixels inside a triangle, %d of them bent; %d changes, %d of them flat\n",
                  inside, bent, changes, unseen);
    assert_true(inside > PIXELS / 10 && changes > PIXELS / 100);
    assert_int_equal(bent, 0);
    assert_true(unseen < changes / 3);
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
}

// Together with the paper's map coordinates, whose plane comes first.
static void test_beside_vertex_coordinates(void **state)
{
    (void)state;
    static struct sight a, b;
    perigee_planet *planet = scene_planet();
    perigee_view_params params = {.identify = true},
                        both = {.identify = true, .texcoord_vertex = true};
    perigee_view *view = scene_view(planet, &params), *other = scene_view(planet, &both);
    look(view, &CAMERAS[1], true, &a);
    look(other, &CAMERAS[1], true, &b);
    assert_memory_equal(a.triangle, b.triangle, sizeof a.triangle);
    assert_memory_equal(a.level, b.level, sizeof a.level);
    perigee_view_destroy(&view);
    perigee_view_destroy(&other);
    perigee_planet_close(&planet);
}

static void test_only_when_asked(void **state)
{
    (void)state;
    perigee_planet *planet = scene_planet();
    perigee_view_params params = {.identify = true};
    perigee_view *view = scene_view(planet, NULL), *identifier = scene_view(planet, &params);
    perigee_triangles t = {0};
    assert_int_not_equal(perigee_view_read_triangles(identifier, &t), 0);
    assert_non_null(strstr(perigee_last_error(), "no frame"));
    scene_render(view, &CAMERAS[0], 64, 48);
    assert_int_not_equal(perigee_view_read_triangles(view, &t), 0);
    assert_non_null(strstr(perigee_last_error(), "not created to identify"));
    scene_render(identifier, &CAMERAS[0], 64, 48);
    perigee_stats with, without;
    perigee_view_get_stats(view, &without);
    perigee_view_get_stats(identifier, &with);
    assert_int_equal(with.gpu_bytes_targets - without.gpu_bytes_targets, 64 * 48 * 8);
    perigee_view_destroy(&view);
    perigee_view_destroy(&identifier);
    perigee_planet_close(&planet);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_identifiers_are_true), cmocka_unit_test(test_a_number_is_a_plane),
        cmocka_unit_test(test_beside_vertex_coordinates), cmocka_unit_test(test_only_when_asked)};
    int rc = scene_open();
    return rc ? rc : scene_close(cmocka_run_group_tests(tests, NULL, NULL));
}
