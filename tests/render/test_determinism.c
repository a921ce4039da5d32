// The same camera gives the same bits in every plane, whatever the thread count, the path that led
// there, the share of a frame's upload and what was late or borrowed on the way. With an argument:
// every combination.
#include "render/scene.h"

#include <unistd.h>

enum { PIXELS = SCENE_WIDTH * SCENE_HEIGHT, STOPS = 5 };

static const perigee_camera stops[STOPS] = {
    {.lat_deg = 45.5, .lon_deg = 10.7, .alt_m = 2e7, .pitch_deg = -90, .fov_deg = 60},
    {.lat_deg = 45.5,
     .lon_deg = 10.7,
     .alt_m = 30000,
     .pitch_deg = -20,
     .heading_deg = 300,
     .fov_deg = 60},
    {.lat_deg = 89.999,
     .lon_deg = -60,
     .alt_m = 12000,
     .pitch_deg = -10,
     .heading_deg = 5,
     .fov_deg = 60},
    {.lat_deg = 12,
     .lon_deg = 179.9999,
     .alt_m = 9000,
     .pitch_deg = -5,
     .heading_deg = 90,
     .fov_deg = 25}, // the rings' focus lies ahead
    {.lat_deg = -45, .lon_deg = 80, .alt_m = 4500, .pitch_deg = -40, .fov_deg = 60},
};

enum path { FORWARD, REVERSED, TELEPORTING, LOOPING, SLIDING, PATHS };
static const char *const path_names[PATHS] = {"forward", "reversed", "teleporting", "looping",
                                              "sliding"};

struct way {
    int threads;
    enum path path;
    size_t upload_bytes, cache_bytes;
    enum perigee_transform transform;
    bool gpu; // levels below the data are made there
};

struct sight {
    float r[PIXELS], g[PIXELS], b[PIXELS], z[PIXELS], height[PIXELS], level[PIXELS];
    double lat[PIXELS], lon[PIXELS];
    uint8_t rgb[3 * PIXELS];
};

static char planet_path[64];
static uint64_t tiles_made; // by synthesis, on the way of last

static perigee_planet *open_planet(size_t cache_bytes)
{
    perigee_planet *planet;
    perigee_planet_params params = {.cache_bytes = cache_bytes}; // with synthesis
    assert_int_equal(perigee_planet_open(planet_path, &params, &planet), 0);
    return planet;
}

// One frame of what is there now; counts those that are late.
static void pass_by(perigee_view *view, const perigee_camera *c, int *late)
{
    perigee_stats stats;
    assert_int_equal(perigee_view_set_camera(view, c), 0);
    assert_int_equal(perigee_view_render(view, SCENE_WIDTH, SCENE_HEIGHT), 0);
    perigee_view_get_stats(view, &stats);
    *late += stats.needs_redraw;
}

// Frames on the way to a stop, none of which waits for its data; but where they slide all do, so
// that each window is filled strip by strip beside what it held.
static void travel(perigee_view *view, enum path path, const perigee_camera *to,
                   struct check_random *r, int *late)
{
    for (int k = 0; k < 8 && path != FORWARD; k++) {
        perigee_camera c = *to;
        double turn = 2 * M_PI * k / 8;
        if (path == REVERSED) { // comes in over the ground, from higher up
            c.lat_deg -= 0.05 * (8 - k);
            c.alt_m *= 1 + 0.2 * (8 - k);
        } else if (path == TELEPORTING) {
            c.lat_deg = check_random_range(r, -90, 90);
            c.lon_deg = check_random_range(r, -180, 180);
            c.alt_m = pow(10, check_random_range(r, 3.7, 7));
        } else if (path == SLIDING) {
            c.lat_deg -= 0.02 * (8 - k);
            c.lon_deg += 0.05 * (8 - k);
            assert_int_equal(perigee_view_set_camera(view, &c), 0);
            assert_int_equal(perigee_view_wait(view, SCENE_WIDTH, SCENE_HEIGHT, 60), 0);
        } else { // around the stop and back to where it began
            c.lat_deg = fmin(90, to->lat_deg + 0.3 * sin(turn));
            c.lon_deg += 0.5 * (1 - cos(turn));
        }
        if (path != SLIDING) pass_by(view, &c, late);
    }
}

static void stop_at(perigee_view *view, const perigee_camera *c, struct sight *s)
{
    scene_render(view, c, SCENE_WIDTH, SCENE_HEIGHT);
    perigee_planes planes = {.r = s->r,
                             .g = s->g,
                             .b = s->b,
                             .z_m = s->z,
                             .height_m = s->height,
                             .lat_deg = s->lat,
                             .lon_deg = s->lon,
                             .level = s->level};
    assert_int_equal(perigee_view_read_planes(view, &planes), 0);
    assert_int_equal(perigee_view_render_image(view, SCENE_WIDTH, SCENE_HEIGHT, 1, s->rgb), 0);
}

// All stops in the order of the path.
static int go(const struct way *way, struct sight sights[STOPS])
{
    perigee_planet *planet = open_planet(way->cache_bytes);
    perigee_view_params params = {.threads = way->threads,
                                  .upload_bytes_frame = way->upload_bytes,
                                  .transform = way->transform,
                                  .gpu_synthesis = way->gpu};
    perigee_view *view = scene_view(planet, &params);
    struct check_random r = {5};
    int late = 0;
    scene_bind(SCENE_WIDTH, SCENE_HEIGHT);
    for (int i = 0; i < STOPS; i++) {
        int stop =
            way->path == REVERSED ? STOPS - 1 - i : (way->path == LOOPING ? 2 * i % STOPS : i);
        travel(view, way->path, &stops[stop], &r, &late);
        stop_at(view, &stops[stop], &sights[stop]);
    }
    perigee_stats stats;
    perigee_view_get_stats(view, &stats);
    tiles_made = stats.tiles_synthesised;
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
    return late;
}

static int differing(const void *a, const void *b, size_t size)
{
    const uint8_t *x = a, *y = b;
    int count = 0;
    for (size_t i = 0; i < size; i++) count += x[i] != y[i];
    return count;
}

// Differing bytes, plane by plane.
static int compare(const struct sight *a, const struct sight *b)
{
    const struct {
        const char *name;
        const void *a, *b;
        size_t size;
    } planes[] = {
        {"r", a->r, b->r, sizeof a->r},
        {"g", a->g, b->g, sizeof a->g},
        {"b", a->b, b->b, sizeof a->b},
        {"z", a->z, b->z, sizeof a->z},
        {"height", a->height, b->height, sizeof a->height},
        {"lat", a->lat, b->lat, sizeof a->lat},
        {"lon", a->lon, b->lon, sizeof a->lon},
        {"level", a->level, b->level, sizeof a->level},
        {"picture", a->rgb, b->rgb, sizeof a->rgb},
    };
    int all = 0;
    for (size_t i = 0; i < sizeof planes / sizeof *planes; i++) {
        int n = differing(planes[i].a, planes[i].b, planes[i].size);
        if (n) print_message("  %s: %d of %zu bytes differ\n", planes[i].name, n, planes[i].size);
        all += n;
    }
    return all;
}

static void check_way(const struct way *way, const struct sight first[STOPS])
{
    static struct sight again[STOPS];
    int late = go(way, again), all = 0;
    for (int i = 0; i < STOPS; i++) {
        int n = compare(&first[i], &again[i]);
        if (n) print_message("  at stop %d\n", i);
        all += n;
    }
    print_message("transform %d, %d threads, %-11s, %4zu KiB a frame, cache %3zu MiB: %2d late "
                  "frames on the way, %d bytes differ\n",
                  (int)way->transform, way->threads, path_names[way->path], way->upload_bytes >> 10,
                  way->cache_bytes >> 20, late, all);
    assert_int_equal(all, 0);
    if (way->path != FORWARD && way->path != SLIDING) assert_true(late > 0);
}

static const size_t PLENTY = (size_t)4 << 20, SCARCE = (size_t)256 << 10, CACHE = (size_t)256 << 20,
                    SMALL_CACHE = (size_t)16 << 20;

// A first sight that shows something: ground lit in many colours at every stop.
static void first_sights(enum perigee_transform transform, bool gpu, struct sight sights[STOPS])
{
    const struct way first = {1, FORWARD, PLENTY, CACHE, transform, gpu};
    go(&first, sights);
    for (int i = 0; i < STOPS; i++) {
        int lit = 0;
        for (int k = 0; k < 3 * PIXELS; k++) lit += sights[i].rgb[k] > 40;
        assert_true(lit > PIXELS / 7);
    }
}

static void test_few_ways(void **state)
{
    (void)state;
    static struct sight first[STOPS];
    for (int transform = 0; transform <= PERIGEE_TRANSFORM_EXACT; transform++) {
        const enum perigee_transform t = (enum perigee_transform)transform;
        first_sights(t, false, first);
        check_way(&(struct way){2, REVERSED, PLENTY, CACHE, t, false}, first);
        check_way(&(struct way){5, TELEPORTING, SCARCE, SMALL_CACHE, t, false}, first);
        check_way(&(struct way){1, LOOPING, SCARCE, CACHE, t, false}, first);
        if (transform) check_way(&(struct way){5, FORWARD, SCARCE, SMALL_CACHE, t, false}, first);
        else check_way(&(struct way){5, SLIDING, SCARCE, CACHE, t, false}, first);
    }
}

// Levels made on the GPU from levels made there, whatever was asked before.
static void test_levels_of_the_gpu(void **state)
{
    (void)state;
    static struct sight first[STOPS];
    const enum perigee_transform t = PERIGEE_TRANSFORM_STABLE;
    first_sights(t, false, first);
    uint64_t by_cpu = tiles_made;
    first_sights(t, true, first);
    print_message("tiles synthesised: %d, with the GPU %d\n", (int)by_cpu, (int)tiles_made);
    assert_true(4 * tiles_made < 3 * by_cpu); // measured 192 of 333: at the pole tiles serve
    check_way(&(struct way){2, REVERSED, PLENTY, CACHE, t, true}, first);
    check_way(&(struct way){5, TELEPORTING, SCARCE, SMALL_CACHE, t, true}, first);
    check_way(&(struct way){1, LOOPING, SCARCE, CACHE, t, true}, first);
}

static void test_every_way(void **state)
{
    (void)state;
    static struct sight first[STOPS];
    static const int threads[] = {1, 2, 5};
    for (int transform = 0; transform <= PERIGEE_TRANSFORM_EXACT; transform++) {
        first_sights((enum perigee_transform)transform, false, first);
        for (int i = 0; i < 3 * PATHS * 2; i++) {
            bool scarce = i % 2;
            struct way way = {threads[i / (2 * PATHS)],          (enum path)(i / 2 % PATHS),
                              scarce ? SCARCE : PLENTY,          scarce ? SMALL_CACHE : CACHE,
                              (enum perigee_transform)transform, false};
            check_way(&way, first);
        }
    }
}

int main(int argc, char **argv)
{
    (void)argv;
    const struct CMUnitTest few[] = {cmocka_unit_test(test_levels_of_the_gpu),
                                     cmocka_unit_test(test_few_ways)},
                            every[] = {cmocka_unit_test(test_every_way)};
    int rc = scene_open();
    if (rc) return rc;
    snprintf(planet_path, sizeof planet_path, "determinism-%d.planet", (int)getpid());
    const analytic_params make = {
        .zoom = 3, .color_zoom = 3, .ellipsoid = GEO_WGS84, .direct = true, .synthesis_gain = 0.3};
    int failed = analytic_planet_make_with(planet_path, &make) != 0;
    if (!failed)
        failed = argc > 1 ? cmocka_run_group_tests(every, NULL, NULL)
                          : cmocka_run_group_tests(few, NULL, NULL);
    remove(planet_path);
    return scene_close(failed);
}
