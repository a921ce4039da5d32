// A disk that does not answer: frames go on from what is in memory, no tile is read on their
// thread, and what is waited for is the same as if the disk had been quick.
#include "scene.h"

#include <epoxy/gl.h>
#include <pthread.h>
#include <string.h>

#include "base/clock.h"
#include "render/planet_handle.h"
#include "render/scout.h"

#define DEG (M_PI / 180)

// A planet file behind a gate. While it is shut nobody is answered.
struct gate {
    struct source source, *inner;
    pthread_t main_thread;
    pthread_mutex_t lock;
    pthread_cond_t opened;
    bool shut, failing;
    int reads, main_reads, held_up, fails; // fails: so many reads more
};

static bool gate_has(const struct source *source, tile_id id)
{
    return source_has(((const struct gate *)source)->inner, id);
}

static status gate_read(struct source *source, tile_id id, struct want *want, void *samples,
                        double *until_s)
{
    struct gate *g = (struct gate *)source;
    pthread_mutex_lock(&g->lock);
    g->reads++;
    g->main_reads += pthread_equal(pthread_self(), g->main_thread) != 0;
    g->held_up += g->shut;
    while (g->shut && !pthread_equal(pthread_self(), g->main_thread))
        pthread_cond_wait(&g->opened, &g->lock);
    bool finest = id.layer == LAYER_HEIGHT && id.zoom == g->inner->meta.max_zoom[LAYER_HEIGHT];
    bool failing = finest && (g->failing || g->fails > 0);
    g->fails -= finest && g->fails > 0;
    pthread_mutex_unlock(&g->lock);
    status s = source_read(g->inner, id, want, samples, until_s);
    if (s || !failing) return s;
    for (int i = 0; i < TILE_SIZE * TILE_SIZE; i++) ((float *)samples)[i] += 500;
    *until_s = clock_now_s(); // its time is over at once
    return OK;
}

static void gate_close(struct source *source)
{
    (void)source;
}

static const struct source_ops gate_ops = {gate_has, gate_read, NULL, gate_close};

static struct planet_file *file;
static struct gate gate;

static void gate_fail(bool failing)
{
    pthread_mutex_lock(&gate.lock);
    gate.failing = failing;
    pthread_mutex_unlock(&gate.lock);
}

static void gate_set(bool shut)
{
    pthread_mutex_lock(&gate.lock);
    gate.shut = shut;
    gate.reads = gate.main_reads = gate.held_up = 0;
    pthread_cond_broadcast(&gate.opened);
    pthread_mutex_unlock(&gate.lock);
}

static int gate_count(const int *counter)
{
    pthread_mutex_lock(&gate.lock);
    int n = *counter;
    pthread_mutex_unlock(&gate.lock);
    return n;
}

// A planet of its own each time, so that nothing is in memory.
static perigee_planet planet_open(void)
{
    perigee_planet p = {0};
    pyramid_layer layer = {&gate.source, 1};
    pyramid_params tiles = {.cache_bytes = 64 << 20};
    assert_int_equal(pyramid_create_stack(&layer, 1, &tiles, &p.pyramid), OK);
    return p;
}

// Over the ground with a narrow and a wide view, and from high up with a telephoto.
static const perigee_camera CAMERAS[] = {
    {.lat_deg = 40.1, .lon_deg = 177.6, .alt_m = 9000, .pitch_deg = -8, .fov_deg = 60},
    {.lat_deg = -35,
     .lon_deg = 20,
     .alt_m = 12000,
     .heading_deg = 70,
     .pitch_deg = -6,
     .fov_deg = 12},
    {.lat_deg = 10,
     .lon_deg = -60,
     .alt_m = 6e5,
     .heading_deg = 200,
     .pitch_deg = -35,
     .fov_deg = 3},
};
enum { CAMERA_COUNT = sizeof CAMERAS / sizeof *CAMERAS, FRAMES = 12 };

static void picture_of(perigee_view *view, const perigee_camera *camera, unsigned char *out)
{
    scene_render(view, camera, SCENE_WIDTH, SCENE_HEIGHT);
    glReadPixels(0, 0, SCENE_WIDTH, SCENE_HEIGHT, GL_RGB, GL_UNSIGNED_BYTE, out);
}

static void frames_do_not_wait_for_the_disk(void **state)
{
    (void)state;
    static unsigned char got[SCENE_WIDTH * SCENE_HEIGHT * 3], want[SCENE_WIDTH * SCENE_HEIGHT * 3];
    const perigee_view_params params = {.threads = 2};
    for (int i = 0; i < CAMERA_COUNT; i++) {
        gate_set(false);
        perigee_planet planet = planet_open();
        perigee_view *view = scene_view(&planet, &params);
        gate_set(true);
        assert_int_equal(perigee_view_set_camera(view, &CAMERAS[i]), 0);
        perigee_stats stats = {0};
        scene_bind(SCENE_WIDTH, SCENE_HEIGHT);
        for (int k = 0; k < FRAMES; k++) {
            assert_int_equal(perigee_view_render(view, SCENE_WIDTH, SCENE_HEIGHT), 0);
            if (k == 0) clock_sleep_s(0.05); // lets the workers run into the gate
        }
        perigee_view_get_stats(view, &stats);
        assert_int_equal(stats.frames, FRAMES);
        assert_true(stats.needs_redraw);
        assert_true(gate_count(&gate.held_up) > 0);
        assert_int_equal(gate_count(&gate.main_reads), 0);
        gate_set(false);
        picture_of(view, &CAMERAS[i], got);
        perigee_view_get_stats(view, &stats);
        assert_int_equal(gate_count(&gate.main_reads), 0);
        perigee_view_destroy(&view);
        pyramid_destroy(&planet.pyramid);

        planet = planet_open();
        view = scene_view(&planet, &params);
        picture_of(view, &CAMERAS[i], want);
        assert_memory_equal(got, want, sizeof got);
        perigee_view_destroy(&view);
        pyramid_destroy(&planet.pyramid);
    }
}

// A source that fails answers with stand-ins, here ground that lies 500 m too high. When it
// recovers they go although nothing moves, and what is seen then is what is seen without a failure.
static void check_recovery(const perigee_camera *camera)
{
    enum { MAX_FRAMES = 20000 };
    static unsigned char got[SCENE_WIDTH * SCENE_HEIGHT * 3], want[sizeof got], failed[sizeof got];
    const perigee_view_params params = {.threads = 2};
    gate_set(false);
    gate_fail(true);
    perigee_planet planet = planet_open();
    perigee_view *view = scene_view(&planet, &params);
    picture_of(view, camera, failed);
    perigee_stats stats;
    perigee_view_get_stats(view, &stats);
    assert_true(stats.needs_redraw);
    gate_fail(false);
    for (int i = 0; stats.needs_redraw && i < MAX_FRAMES; i++) {
        assert_int_equal(perigee_view_render(view, SCENE_WIDTH, SCENE_HEIGHT), 0);
        perigee_view_get_stats(view, &stats);
    }
    assert_false(stats.needs_redraw);
    glReadPixels(0, 0, SCENE_WIDTH, SCENE_HEIGHT, GL_RGB, GL_UNSIGNED_BYTE, got);
    perigee_view_destroy(&view);
    pyramid_destroy(&planet.pyramid);

    planet = planet_open();
    view = scene_view(&planet, &params);
    picture_of(view, camera, want);
    uint32_t last = stats.last_level;
    perigee_view_get_stats(view, &stats);
    assert_int_equal(stats.last_level, last); // what was looked at has been looked at again
    assert_memory_not_equal(failed, want, sizeof want);
    assert_memory_equal(got, want, sizeof want);
    perigee_view_destroy(&view);
    pyramid_destroy(&planet.pyramid);
}

// From so high that the levels are the same, and from so low that they are not.
static void stand_ins_go_when_the_source_recovers(void **state)
{
    (void)state;
    perigee_camera c = {.lat_deg = 40, .lon_deg = 20, .alt_m = 60000, .pitch_deg = -30};
    check_recovery(&c);
    c.alt_m = analytic_height(c.lat_deg * DEG, c.lon_deg * DEG) + 600;
    check_recovery(&c);
}

// A source that fails for a while: a picture that is waited for has no stand-in.
static void a_picture_waits_for_a_recovery(void **state)
{
    (void)state;
    enum { FAILS = 200 }; // several times the tiles of the view
    static unsigned char got[SCENE_WIDTH * SCENE_HEIGHT * 3], want[sizeof got];
    const perigee_camera camera = {.lat_deg = 40, .lon_deg = 20, .alt_m = 60000, .pitch_deg = -30};
    const perigee_view_params params = {.threads = 2};
    for (int fails = 0; fails <= FAILS; fails += FAILS) {
        gate_set(false);
        gate.fails = fails;
        perigee_planet planet = planet_open();
        perigee_view *view = scene_view(&planet, &params);
        picture_of(view, &camera, fails ? got : want);
        assert_int_equal(gate.fails, 0);
        perigee_view_destroy(&view);
        pyramid_destroy(&planet.pyramid);
    }
    assert_memory_equal(got, want, sizeof want);
}

static geo_camera in_radians(const perigee_camera *c)
{
    return (geo_camera){.position = {c->lat_deg * DEG, c->lon_deg * DEG, c->alt_m},
                        .heading = c->heading_deg * DEG,
                        .pitch = c->pitch_deg * DEG,
                        .fov_y = c->fov_deg * DEG};
}

// What a scout has found it keeps, although the cache has let the tiles go since.
static void what_is_found_is_kept(void **state)
{
    (void)state;
    gate_set(false);
    perigee_planet planet = planet_open();
    struct pool *pool = pool_create(1, 4);
    struct scout *scout = scout_create(planet.pyramid, pool);
    geo_camera camera = in_radians(&CAMERAS[1]);
    gate_set(true);
    for (int i = 0; i < 5; i++) assert_false(scout_look(scout, &camera, 1.25).exact);
    assert_int_equal(gate_count(&gate.main_reads), 0);
    gate_set(false);
    gaze found = {0};
    for (int i = 0; i < 1000 && !found.exact; i++) {
        scout_wait(scout, 1);
        found = scout_look(scout, &camera, 1.25);
    }
    assert_true(found.exact);
    const pyramid_tile *tile;
    for (int col = 0; col < 400; col++) { // more than fit in
        tile_id id = {LAYER_HEIGHT, 9, 200, col};
        assert_int_equal(pyramid_acquire(planet.pyramid, id, &tile), OK);
        pyramid_release(planet.pyramid, &tile);
    }
    assert_false(gaze_guess(planet.pyramid, &camera, 1.25).exact);
    gaze again = scout_look(scout, &camera, 1.25);
    assert_true(again.exact && again.lat == found.lat && again.distance == found.distance);
    scout_destroy(&scout);
    pool_destroy(&pool);
    pyramid_destroy(&planet.pyramid);
}

// A guess says whether it is one, and is none once the tiles are in memory.
static void guesses_are_told_from_knowledge(void **state)
{
    (void)state;
    perigee_planet planet;
    gate_set(false);
    for (int i = 0; i < CAMERA_COUNT; i++) {
        const perigee_camera *c = &CAMERAS[i];
        geo_camera camera = in_radians(c);
        planet = planet_open();
        gaze none = gaze_guess(planet.pyramid, &camera, 1.25);
        assert_int_equal(gate_count(&gate.main_reads), 0);
        if (c->alt_m < 1e5) assert_false(none.exact);
        gaze exact = gaze_find(planet.pyramid, &camera, 1.25);
        assert_true(exact.exact);
        gaze after = gaze_guess(planet.pyramid, &camera, 1.25); // all is in memory now
        assert_true(after.exact);
        check_near(after.lat, exact.lat, 0);
        check_near(after.lon, exact.lon, 0);
        check_near(after.distance, exact.distance, 0);
        check_near(after.nearest, exact.nearest, 0);
        gate_set(false);
        pyramid_destroy(&planet.pyramid);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_do_not_wait_for_the_disk),
        cmocka_unit_test(stand_ins_go_when_the_source_recovers),
        cmocka_unit_test(a_picture_waits_for_a_recovery),
        cmocka_unit_test(what_is_found_is_kept),
        cmocka_unit_test(guesses_are_told_from_knowledge),
    };
    int rc = scene_open();
    if (rc) return rc;
    perigee_planet *made = scene_planet();
    perigee_planet_close(&made);
    pthread_mutex_init(&gate.lock, NULL);
    pthread_cond_init(&gate.opened, NULL);
    gate.main_thread = pthread_self();
    if (planet_file_open("analytic.planet", &file) || source_file_open(file, &gate.inner))
        return scene_close(1);
    gate.source =
        (struct source){.ops = &gate_ops, .meta = gate.inner->meta, .path = gate.inner->path};
    rc = cmocka_run_group_tests(tests, NULL, NULL);
    source_close(&gate.inner);
    planet_file_close(&file);
    return scene_close(rc);
}
