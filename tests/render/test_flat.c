// The map as a plane, in every mode: that of longitude and latitude, and that of a projected raster
// as it is. No hole, no crack and nothing off the map over flights across it and along its edges,
// with data that is late too, and in fields of view from the least to the most; every point on its
// pixel's ray and at the height of the terrain; rasters of a few samples; cameras in places where
// there is no map. In short 3 flights, every
// other view and one of the two forms whose pictures are the same; an argument, the number of times
// 6 flights, leaves nothing out.
//
// Fails when broken: what lies beyond the map not discarded (watertight, accuracy); two metres more
// than that discarded (raster_watertight, small_rasters); latitudes of the heights stretched by 2 %
// about the focus (accuracy); the raster laid half a sample aside (raster_accuracy, small_rasters,
// lies_at_its_place); the map cut to reach as far to both sides (raster_watertight). Not seen: by
// 0.02 %, which is below the bounds; cells nearer than they are to the horizon's test, which are
// then drawn for nothing.
#include "render/gaps.h"

#include "utm_raster.h"

#define RASTER "utm.tif"

static const double RAD = M_PI / 180;

static int times; // 0: in short
static struct gaps_frame seen;

enum { MODES = 4 };

// The planar mode in both its forms.
static const struct {
    const char *name;
    perigee_view_params params;
} modes[MODES] = {
    {"spherical", {.mode = PERIGEE_MODE_SPHERICAL}},
    {"planar", {.mode = PERIGEE_MODE_PLANAR}},
    {"planar, 2004", {.mode = PERIGEE_MODE_PLANAR, .planar_form = PERIGEE_PLANAR_2004}},
    {"grid", {.mode = PERIGEE_MODE_GRID}},
};

// 2005's squares have the pictures of 2004's (render_planar).
static bool left_out(int mode)
{
    return !times && modes[mode].params.planar_form == PERIGEE_PLANAR_2004;
}

static perigee_view *view_of(perigee_planet *planet, int mode)
{
    perigee_view_params params = modes[mode].params;
    params.identify = true;
    return scene_view(planet, &params);
}

// The raster's map: metres over the radius that its planet says.
static scene_map raster_map;

static double raster_height(double lat, double lon)
{
    return utm_raster_height(raster_map.radius * lon, raster_map.radius * lat);
}

static perigee_planet *open_raster(const char *path)
{
    perigee_planet *planet;
    perigee_planet_info info;
    perigee_planet_params params = {.no_synthesis = true, .flat = true};
    assert_int_equal(perigee_planet_open(path, &params, &planet), 0);
    perigee_planet_get_info(planet, &info);
    assert_true(info.map_projected);
    raster_map =
        (scene_map){info.equatorial_radius_m, RAD * info.map_south_deg, RAD * info.map_north_deg,
                    RAD * info.map_west_deg,  RAD * info.map_east_deg,  raster_height,
                    UTM_RASTER_LOW,           UTM_RASTER_HIGH};
    scene_set_flat(&raster_map);
    return planet;
}

static perigee_planet *open_longitudes(void)
{
    scene_set_flat(&scene_analytic_map);
    return scene_planet();
}

static perigee_planet *open_utm(void)
{
    assert_int_equal(utm_raster_write(RASTER, 301, 203), 0);
    return open_raster(RASTER);
}

static double ground(const perigee_camera *c)
{
    return scene_flat()->height(c->lat_deg * RAD, c->lon_deg * RAD);
}

// By metres east and north of the map's middle and above the ground there.
static perigee_camera camera_at(double east, double north, double above, double heading_deg,
                                double pitch_deg, double fov_deg)
{
    const scene_map *m = scene_flat();
    perigee_camera c = {.lat_deg = north / m->radius / RAD,
                        .lon_deg = east / m->radius / RAD,
                        .heading_deg = heading_deg,
                        .pitch_deg = pitch_deg,
                        .fov_deg = fov_deg};
    c.alt_m = ground(&c) + above;
    return c;
}

static int check_gaps(const char *what, int frame, const perigee_camera *c, double edge_px)
{
    struct gaps_counts n = gaps_find(c, &seen, edge_px);
    if (n.background + n.cracks + n.beyond + n.unidentified)
        fail_msg("%s %d: lat %.9g lon %.9g alt %.9g heading %g pitch %g: %d background pixels, %d "
                 "cracks, %d off the map, %d without an identifier",
                 what, frame, c->lat_deg, c->lon_deg, c->alt_m, c->heading_deg, c->pitch_deg,
                 n.background, n.cracks, n.beyond, n.unidentified);
    return n.inside;
}

// With what happens to be there of a new place. Near the ground late data may lie above the camera.
// Ground of which nothing is known yet lies at height 0.
static bool check_late(perigee_view *view, const char *what, int frame, const perigee_camera *c,
                       double above)
{
    const scene_map *map = scene_flat();
    scene_map unknown = *map;
    unknown.height_min = fmin(map->height_min, 0);
    scene_bind(GAPS_WIDTH, GAPS_HEIGHT);
    assert_int_equal(perigee_view_set_camera(view, c), 0);
    assert_int_equal(perigee_view_render(view, GAPS_WIDTH, GAPS_HEIGHT), 0);
    gaps_read(view, &seen);
    scene_set_flat(&unknown);
    if (above > 500) check_gaps(what, frame, c, 0);
    scene_set_flat(map);
    return seen.late;
}

// Every other flight begins at an edge of the map or, now and then, at a corner.
static perigee_camera random_camera(struct check_random *r, int i, double *above)
{
    const scene_map *m = scene_flat();
    double south = m->south / RAD, north = m->north / RAD, west = m->west / RAD,
           east = m->east / RAD;
    perigee_camera c = {.lat_deg = check_random_range(r, 0.99 * south, 0.99 * north),
                        .lon_deg = check_random_range(r, 0.99 * west, 0.99 * east),
                        .heading_deg = check_random_range(r, 0, 360),
                        .pitch_deg = check_random_range(r, -90, 0),
                        .fov_deg = check_random_range(r, 46, 100)};
    if (i % 2) c.lon_deg = 0.9999 * (i % 4 == 1 ? east : west);
    if (i % 6 == 1) c.lat_deg = 0.999 * north;
    if (i % 6 == 4) c.lat_deg = 0.9999 * south;
    *above = pow(10, check_random_range(r, 0.7, log10(0.5 * m->radius * m->east)));
    c.alt_m = ground(&c) + *above;
    return c;
}

static bool fly_on(perigee_camera *c, double *above)
{
    const scene_map *m = scene_flat();
    double step = 0.1 * *above / m->radius / RAD, turn = c->heading_deg * RAD;
    c->lat_deg += step * cos(turn);
    c->lon_deg += step * sin(turn);
    c->heading_deg += 11;
    *above *= 0.9;
    double lat = c->lat_deg * RAD, lon = c->lon_deg * RAD;
    if (!(lat > m->south && lat < m->north && lon > m->west && lon < m->east)) return false;
    c->alt_m = ground(c) + *above;
    return true;
}

static void fly(perigee_planet *planet, const char *map, int mode)
{
    enum { FRAMES = 4 };
    perigee_view *view = view_of(planet, mode);
    struct check_random r = {17};
    int flights = times ? 6 * times : 3, frames = 0, edges = 0, inside = 0, met = 0, late = 0;
    for (int i = 0; i < flights; i++) {
        double above;
        perigee_camera c = random_camera(&r, i, &above);
        late += check_late(view, modes[mode].name, FRAMES * i, &c, above);
        for (int k = 0; k < FRAMES; k++) {
            scene_render(view, &c, GAPS_WIDTH, GAPS_HEIGHT);
            gaps_read(view, &seen);
            int here = check_gaps(modes[mode].name, FRAMES * i + k, &c, 0);
            inside += here;
            edges += here > 100 && here < GAPS_PIXELS - 100;
            met += gaps_met(&seen, GAPS_LEVEL) > 0;
            frames++;
            if (!fly_on(&c, &above)) break;
        }
    }
    print_message("%s, %s: %d frames, %d begun late, no hole, %d with an edge of the map or its "
                  "horizon, %d with a level border in the middle\n",
                  map, modes[mode].name, frames, late, edges, met);
    assert_true(edges >= flights && inside > (times ? 6 : 2) * GAPS_PIXELS);
    assert_true(met > flights / 3 || mode == MODES - 1);
    assert_true(late > 0);
    perigee_view_destroy(&view);
}

static void test_watertight(void **state)
{
    (void)state;
    perigee_planet *planet = open_longitudes();
    for (int mode = 0; mode < MODES; mode++) fly(planet, "longitudes", mode);
    perigee_planet_close(&planet);
}

static void test_raster_watertight(void **state)
{
    (void)state;
    perigee_planet *planet = open_utm();
    for (int mode = 0; mode < MODES; mode++) fly(planet, "utm", mode);
    perigee_planet_close(&planet);
}

// From a hundredth of a degree to 179, where the map is a few pixels large and its edges are right
// to half of one.
static void test_fields_of_view(void **state)
{
    (void)state;
    static const double fovs[] = {0.01, 5, 130, 179};
    for (int map = 0; map < 2; map++) {
        perigee_planet *planet = map ? open_utm() : open_longitudes();
        double size = scene_flat()->radius * scene_flat()->north;
        for (int mode = 0; mode < MODES; mode++) {
            if (left_out(mode)) continue;
            perigee_view *view = view_of(planet, mode);
            int inside = 0;
            for (int i = 0; i < 8; i++) {
                if (!times && (i + i / 4) % 2) continue;
                perigee_camera c = camera_at(0.3 * size, -0.4 * size, i < 4 ? 50 : 0.3 * size, 20,
                                             i < 4 ? -20 : -60, fovs[i % 4]);
                scene_render(view, &c, GAPS_WIDTH, GAPS_HEIGHT);
                gaps_read(view, &seen);
                inside += check_gaps(modes[mode].name, i, &c, fovs[i % 4] > 170 ? 0.5 : 0);
            }
            assert_true(inside > (times ? 5 : 2) * GAPS_PIXELS);
            perigee_view_destroy(&view);
        }
        perigee_planet_close(&planet);
    }
}

static const perigee_camera views[] = {
    {.lat_deg = 20, .lon_deg = 10, .alt_m = 2e7, .pitch_deg = -90, .fov_deg = 60},
    {.lat_deg = 45,
     .lon_deg = 10,
     .alt_m = 2e5,
     .heading_deg = 200,
     .pitch_deg = -20,
     .fov_deg = 60},
    {.lat_deg = -33,
     .lon_deg = 151,
     .alt_m = 2e4,
     .heading_deg = 80,
     .pitch_deg = -8,
     .fov_deg = 70},
    {.lat_deg = 80,
     .lon_deg = -60,
     .alt_m = 6e3,
     .heading_deg = 300,
     .pitch_deg = 0,
     .fov_deg = 60},
    {.lat_deg = 70,
     .lon_deg = 179.9,
     .alt_m = 3e4,
     .heading_deg = -60,
     .pitch_deg = -30,
     .fov_deg = 60},
    {.lat_deg = 10, .lon_deg = 30, .alt_m = 1e5, .heading_deg = 33, .pitch_deg = -12, .fov_deg = 4},
};

enum { VIEWS = sizeof views / sizeof *views };

struct errors {
    double off_ray_px, height_px; // greatest; of 99.9 %
    int ground;
};

static int ascending(const void *a, const void *b)
{
    double p = *(const double *)a, q = *(const double *)b;
    return (p > q) - (p < q);
}

static struct errors errors_of(const perigee_camera *c, const perigee_planes *planes, int width,
                               int height)
{
    struct errors e = {0};
    double *heights = malloc((size_t)(width * height) * sizeof *heights);
    double pixel = 2 * tan(c->fov_deg * RAD / 2) / height;
    assert_non_null(heights);
    for (int k = 0; k < width * height; k++) {
        double o[3], d[3], z = planes->z_m[k];
        if (isnan(z)) continue;
        scene_ray(c, width, height, k % width + 0.5, k / width + 0.5, o, d);
        double lat = planes->lat_deg[k] * RAD, lon = planes->lon_deg[k] * RAD;
        double at[3] = {planes->height_m[k], scene_flat()->radius * lon,
                        scene_flat()->radius * lat};
        double off = 0;
        for (int i = 0; i < 3; i++) off += pow(at[i] - o[i] - z * d[i], 2);
        e.off_ray_px = fmax(e.off_ray_px, sqrt(off) / (pixel * z));
        heights[e.ground++] = fabs(at[0] - scene_flat()->height(lat, lon)) / (pixel * z);
    }
    if (e.ground) {
        qsort(heights, (size_t)e.ground, sizeof *heights, ascending);
        e.height_px = heights[(int)(0.999 * (e.ground - 1))];
    }
    free(heights);
    return e;
}

static struct errors measure(perigee_view *view, const char *map, int mode,
                             const perigee_camera *cameras, int count)
{
    enum { W = SCENE_WIDTH, H = SCENE_HEIGHT };
    static float z[W * H], h[W * H];
    static double lat[W * H], lon[W * H];
    perigee_planes planes = {.z_m = z, .height_m = h, .lat_deg = lat, .lon_deg = lon};
    struct errors worst = {0};
    for (int i = 0; i < count; i += times || count < VIEWS ? 1 : 2) {
        scene_render(view, &cameras[i], W, H);
        assert_int_equal(perigee_view_read_planes(view, &planes), 0);
        struct errors e = errors_of(&cameras[i], &planes, W, H);
        assert_true(e.ground > W * H / 20);
        print_message("%s, %s %d: %d ground, %.2g px off the ray, height %.3g px (99.9 %%)\n", map,
                      modes[mode].name, i, e.ground, e.off_ray_px, e.height_px);
        worst.height_px = fmax(worst.height_px, e.height_px);
        worst.off_ray_px = fmax(worst.off_ray_px, e.off_ray_px);
    }
    return worst;
}

static void test_accuracy(void **state)
{
    (void)state;
    perigee_planet *planet = open_longitudes();
    for (int mode = 0; mode < MODES; mode++) {
        if (left_out(mode)) continue;
        perigee_view *view = view_of(planet, mode);
        struct errors worst = measure(view, "longitudes", mode, views, VIEWS);
        assert_true(worst.off_ray_px <= 1e-2);
        assert_true(worst.height_px <= 0.01);
        perigee_view_destroy(&view);
    }
    perigee_planet_close(&planet);
}

static void test_raster_accuracy(void **state)
{
    (void)state;
    perigee_planet *planet = open_utm();
    const perigee_camera cameras[] = {
        camera_at(0, 0, 8000, 0, -90, 60),        camera_at(-1500, -2000, 1500, 30, -25, 60),
        camera_at(4000, 100, 300, -80, -8, 70),   camera_at(500, 2900, 60, 190, -5, 60),
        camera_at(-4400, -2900, 10, 45, -10, 60), camera_at(2000, -2500, 800, -30, -12, 4),
    };
    const double bars[MODES] = {1, 1.6, 1.6, 2.5};
    for (int mode = 0; mode < MODES; mode++) {
        if (left_out(mode)) continue;
        perigee_view *view = view_of(planet, mode);
        struct errors worst = measure(view, "utm", mode, cameras, sizeof cameras / sizeof *cameras);
        assert_true(worst.off_ray_px <= 1e-2);
        assert_true(worst.height_px <= bars[mode]);
        perigee_view_destroy(&view);
    }
    perigee_planet_close(&planet);
}

// On the map and under its ground, as over a globe.
static void test_camera_under_the_plane(void **state)
{
    (void)state;
    perigee_planet *planet = open_longitudes();
    perigee_view *view = view_of(planet, 0);
    perigee_camera c = {.lat_deg = 10, .alt_m = -4e6, .pitch_deg = 20, .fov_deg = 60};
    assert_int_not_equal(perigee_view_set_camera(view, &c), 0);
    assert_non_null(strstr(perigee_last_error(), "impossible camera: altitude in metres -4e+06"));
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
}

static perigee_planet *small;

// Below the samples the store's heights are smooth, so not bilinear.
static double small_height(double lat, double lon)
{
    double h;
    assert_int_equal(perigee_planet_height(small, lat / RAD, lon / RAD, &h), 0);
    return h;
}

// The map's heights are the samples' to a tenth of the steepest step from one to the next.
static void take_small_map(int width, int height)
{
    double low = INFINITY, high = -INFINITY;
    for (int row = height / 2 - height; row < height / 2; row++)
        for (int col = -(width / 2); col < width - width / 2; col++) {
            double east = UTM_RASTER_STEP * (col + 0.5), north = UTM_RASTER_STEP * (row + 0.5),
                   want = utm_raster_height(east, north);
            check_near(small_height(north / raster_map.radius, east / raster_map.radius), want,
                       0.8);
            low = fmin(low, want);
            high = fmax(high, want);
        }
    raster_map.height = small_height;
    raster_map.height_min = low - 1;
    raster_map.height_max = high + 1;
}

// Rasters smaller than any level, from above and from beside them.
static void test_small_rasters(void **state)
{
    (void)state;
    static const int sizes[][2] = {{2, 3}, {17, 5}};
    for (int i = 0; i < 2; i++) {
        assert_int_equal(utm_raster_write(RASTER, sizes[i][0], sizes[i][1]), 0);
        perigee_planet *planet = small = open_raster(RASTER);
        take_small_map(sizes[i][0], sizes[i][1]);
        double east = raster_map.radius * raster_map.east,
               south = raster_map.radius * raster_map.south;
        check_near(east, UTM_RASTER_STEP * (sizes[i][0] - sizes[i][0] / 2 - 0.5), 1e-6);
        check_near(south, UTM_RASTER_STEP * (sizes[i][1] / 2 - sizes[i][1] + 0.5), 1e-6);
        const perigee_camera cameras[] = {camera_at(0, 0, 2 * east, 0, -90, 60),
                                          camera_at(-1.3 * east, 0, east, 90, -50, 60)};
        for (int mode = 0; mode < MODES; mode++) {
            if (left_out(mode)) continue;
            perigee_view *view = view_of(planet, mode);
            struct errors worst = measure(view, "small", mode, cameras, 2);
            assert_true(worst.off_ray_px <= 1e-2 && worst.height_px <= 0.2);
            for (int k = 0; k < 2; k++) {
                scene_render(view, &cameras[k], GAPS_WIDTH, GAPS_HEIGHT);
                gaps_read(view, &seen);
                assert_true(check_gaps(modes[mode].name, k, &cameras[k], 0) > GAPS_PIXELS / 20);
            }
            perigee_view_destroy(&view);
        }
        perigee_planet_close(&planet);
    }
    assert_int_equal(utm_raster_write(RASTER, 1, 1), 0);
    perigee_planet *none;
    perigee_planet_params flat = {.flat = true};
    assert_int_not_equal(perigee_planet_open(RASTER, &flat, &none), 0);
    assert_non_null(strstr(perigee_last_error(), RASTER ": not a map: it has less than 2 x 2"));
}

// Where the system has it: 45 N 9 E at its corner of four samples, and back.
static void test_raster_lies_at_its_place(void **state)
{
    (void)state;
    enum { W = 41, H = 31, MIDDLE = H / 2 * W + W / 2 };
    static float z[W * H], h[W * H];
    static double lat[W * H], lon[W * H];
    perigee_planes planes = {.z_m = z, .height_m = h, .lat_deg = lat, .lon_deg = lon};
    perigee_planet *planet = open_utm();
    perigee_view *view = view_of(planet, 0);
    perigee_camera c = {.lat_deg = 45, .lon_deg = 9, .alt_m = 2000, .pitch_deg = -90};
    assert_int_equal(perigee_planet_map_place(planet, &c.lat_deg, &c.lon_deg), 0);
    scene_render(view, &c, W, H);
    assert_int_equal(perigee_view_read_planes(view, &planes), 0);
    perigee_planet_geographic(planet, W * H, lat, lon);
    check_near(lat[MIDDLE], 45, 1e-8);
    check_near(lon[MIDDLE], 9, 1e-8);
    c = (perigee_camera){.lat_deg = c.lat_deg, .lon_deg = c.lon_deg};
    perigee_planet_map_coordinates(planet, 1, &c.lat_deg, &c.lon_deg);
    check_near(c.lon_deg, 500000, 2e-3);
    check_near(c.lat_deg, 4982950.4, 2e-3);
    check_near(h[MIDDLE], utm_raster_height(0, 0), 0.05);
    check_near(z[MIDDLE], 2000 - utm_raster_height(0, 0), 0.05);
    assert_true(lat[MIDDLE - W] > 45 && lon[MIDDLE + 1] > 9);
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
}

int main(int argc, char **argv)
{
    if (argc > 1) times = atoi(argv[1]);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_watertight),
        cmocka_unit_test(test_accuracy),
        cmocka_unit_test(test_camera_under_the_plane),
        cmocka_unit_test(test_raster_watertight),
        cmocka_unit_test(test_raster_accuracy),
        cmocka_unit_test(test_fields_of_view),
        cmocka_unit_test(test_small_rasters),
        cmocka_unit_test(test_raster_lies_at_its_place),
    };
    int rc = scene_open();
    return rc ? rc : scene_close(cmocka_run_group_tests(tests, NULL, NULL));
}
