// Sources behind one interface: late answers, stand-ins that end, and layers over one another.
#include "planet_fixture.h"
#include "check.h"

#include <pthread.h>
#include <stdatomic.h>

#include "base/clock.h"

enum { SAMPLES = TILE_SIZE * TILE_SIZE };

// A source of constants: heights `level` and a colour east of longitude 0, nothing west of it.
struct plain {
    struct source source;
    float height;
    uint8_t rgba[4];
    int max_zoom;
    bool half, late, failing;
    struct want *waiting[64];
    int waiting_count;
    atomic_int reads;
};

static bool plain_has(const struct source *source, tile_id id)
{
    const struct plain *p = (const struct plain *)source;
    return id.layer != LAYER_NIGHT && id.zoom <= p->max_zoom &&
           (!p->half || 2 * id.col >= grid_cols(id.zoom, id.row));
}

static status plain_read(struct source *source, tile_id id, struct want *want, void *samples,
                         double *until_s)
{
    struct plain *p = (struct plain *)source;
    p->reads++;
    if (p->late) {
        p->waiting[p->waiting_count++] = want_take(want);
        return ERR_PENDING;
    }
    if (p->failing) {
        *until_s = clock_now_s() + 0.05;
        return ERR_IO;
    }
    for (int i = 0; i < SAMPLES; i++) {
        if (id.layer == LAYER_HEIGHT) ((float *)samples)[i] = p->height;
        else memcpy((uint8_t *)samples + 4 * i, p->rgba, 4);
    }
    return OK;
}

static void plain_close(struct source *source)
{
    (void)source;
}

static const struct source_ops plain_ops = {plain_has, plain_read, NULL, plain_close};

static struct plain plain_make(float height, uint8_t grey, int max_zoom)
{
    struct plain p = {.height = height, .rgba = {grey, grey, grey, 255}, .max_zoom = max_zoom};
    p.source =
        (struct source){.ops = &plain_ops, .meta = {.ellipsoid = GEO_WGS84}, .path = "plain"};
    p.source.meta.max_zoom[LAYER_HEIGHT] = p.source.meta.max_zoom[LAYER_COLOR] = max_zoom;
    p.source.meta.max_zoom[LAYER_NIGHT] = -1;
    return p;
}

static struct pyramid *stack(pyramid_layer *layers, int count)
{
    struct pyramid *p;
    pyramid_params params = {.synthesis = false};
    assert_int_equal(pyramid_create_stack(layers, count, &params, &p), OK);
    return p;
}

static float height_of(struct pyramid *p, tile_id id, int at)
{
    const pyramid_tile *tile;
    assert_int_equal(pyramid_acquire(p, id, &tile), OK);
    float h = tile->heights[at];
    pyramid_release(p, &tile);
    return h;
}

static int grey_of(struct pyramid *p, tile_id id, int at)
{
    const pyramid_tile *tile;
    id.layer = LAYER_COLOR;
    assert_int_equal(pyramid_acquire(p, id, &tile), OK);
    int grey = tile->rgba[4 * at];
    pyramid_release(p, &tile);
    return grey;
}

static const int MIDDLE = SAMPLES / 2 + TILE_SIZE / 2;

// The weight of a layer is its opacity at every zoom: at its own, below it, and below all.
static void opacity_is_the_same_at_every_zoom(void **state)
{
    (void)state;
    struct plain ground = plain_make(100, 40, 3), over = plain_make(500, 240, 5);
    over.half = true;
    pyramid_layer layers[] = {{&ground.source, 1}, {&over.source, 0.25f}};
    struct pyramid *p = stack(layers, 2);
    for (int zoom = 1; zoom <= 9; zoom++) {
        tile_id east = fixture_tile_at(zoom, 0.3, 1.5), west = fixture_tile_at(zoom, 0.3, -1.5);
        check_near(height_of(p, east, MIDDLE), 200, 1e-3);
        check_near(height_of(p, west, MIDDLE), 100, 1e-3);
        check_near(grey_of(p, east, MIDDLE), 90, 1);
        check_near(grey_of(p, west, MIDDLE), 40, 0);
    }
    assert_int_equal(pyramid_meta(p)->max_zoom[LAYER_HEIGHT], 5);
    pyramid_destroy(&p);
}

static void the_last_layer_lies_on_top(void **state)
{
    (void)state;
    struct plain ground = plain_make(100, 40, 3), a = plain_make(500, 240, 5),
                 b = plain_make(-20, 10, 2);
    pyramid_layer layers[] = {{&ground.source, 1}, {&a.source, 1}, {&b.source, 1}};
    struct pyramid *p = stack(layers, 3);
    tile_id id = fixture_tile_at(6, 0.3, 1.5);
    check_near(height_of(p, id, MIDDLE), -20, 1e-3);
    check_near(grey_of(p, id, MIDDLE), 10, 0);
    pyramid_destroy(&p);
    layers[2].opacity = 0;
    p = stack(layers, 3);
    check_near(height_of(p, id, MIDDLE), 500, 1e-3);
    pyramid_destroy(&p);
}

// Half-covered pixels show half of what is below.
static void coverage_is_kept(void **state)
{
    (void)state;
    struct plain ground = plain_make(0, 200, 3), over = plain_make(0, 0, 3);
    memcpy(over.rgba, (uint8_t[4]){50, 50, 50, 128}, 4); // 100 by half, multiplied
    over.source.meta.max_zoom[LAYER_HEIGHT] = -1;
    over.source.gaps_final = true;
    pyramid_layer layers[] = {{&ground.source, 1}, {&over.source, 1}};
    struct pyramid *p = stack(layers, 2);
    for (int zoom = 2; zoom < 6; zoom++)
        check_near(grey_of(p, fixture_tile_at(zoom, 0.3, 1.5), MIDDLE), 150, 1);
    pyramid_destroy(&p);
}

static void another_body_is_refused(void **state)
{
    (void)state;
    struct plain ground = plain_make(0, 0, 1), over = plain_make(0, 0, 1);
    over.source.meta.ellipsoid = (geo_ellipsoid){.a = 1737400, .b = 1737400};
    pyramid_layer layers[] = {{&ground.source, 1}, {&over.source, 1}};
    struct pyramid *p;
    pyramid_params params = {0};
    assert_int_equal(pyramid_create_stack(layers, 2, &params, &p), ERR_ARGUMENT);
    assert_null(p);
}

// A tile on its way is not waited for; all that is needed is asked for at once; when it has come
// the same want is enough.
static void late_tiles_are_asked_for_together(void **state)
{
    (void)state;
    struct plain ground = plain_make(100, 40, 3), over = plain_make(500, 240, 3);
    ground.late = over.late = true;
    pyramid_layer layers[] = {{&ground.source, 1}, {&over.source, 1}};
    struct pyramid *p = stack(layers, 2);
    struct want *want = want_create(1);
    tile_id id = fixture_tile_at(3, 0.3, 1.5);
    const pyramid_tile *tile;
    assert_int_equal(pyramid_try(p, id, want, &tile), ERR_PENDING);
    assert_null(tile);
    assert_false(want_ready(want));
    assert_int_equal(ground.waiting_count, 1);
    assert_int_equal(over.waiting_count, 1);
    ground.late = over.late = false;
    want_give_back(&ground.waiting[0]);
    assert_false(want_ready(want));
    want_give_back(&over.waiting[0]);
    assert_true(want_ready(want));
    assert_int_equal(pyramid_try(p, id, want, &tile), OK);
    check_near(tile->heights[MIDDLE], 500, 0);
    pyramid_release(p, &tile);
    want_release(&want);
    pyramid_destroy(&p);
}

// Heights are known where any layer has a sample that is no gap, and nowhere else.
static void heights_are_known_where_they_are(void **state)
{
    (void)state;
    struct plain gaps = plain_make(NAN, 40, 3), half = plain_make(500, 240, 5);
    half.half = true;
    pyramid_layer layers[] = {{&gaps.source, 1}, {&half.source, 0.5f}};
    const double lat[] = {NAN, 20, -90, 90, 10}, lon[] = {3, 100, 200, 179.9, -100};
    static const bool want[2][5] = {{false, false, false, false, false},
                                    {false, true, false, true, false}};
    bool known;
    for (int count = 1; count <= 2; count++) {
        struct pyramid *p = stack(layers, count);
        for (int i = 0; i < 5; i++) {
            assert_int_equal(pyramid_knows_any(p, &lat[i], &lon[i], 1, &known), OK);
            assert_int_equal(known, want[count - 1][i]);
        }
        assert_int_equal(pyramid_knows_any(p, lat, lon, 5, &known), OK);
        assert_int_equal(known, count == 2);
        assert_int_equal(pyramid_knows_any(p, lat, lon, 0, &known), OK);
        assert_false(known);
        pyramid_destroy(&p);
    }
    half.failing = true; // what cannot be had is not known
    struct pyramid *p = stack(layers + 1, 1);
    assert_int_equal(pyramid_knows_any(p, lat, lon, 5, &known), OK);
    assert_false(known);
    pyramid_destroy(&p);
}

static void *wait_for_tile(void *arg)
{
    struct pyramid *p = arg;
    const pyramid_tile *tile;
    return (void *)(long)pyramid_acquire(p, fixture_tile_at(3, 0.3, 1.5), &tile);
}

// Who waits for a tile that never comes can be told to leave.
static void waiting_ends_when_it_is_given_up(void **state)
{
    (void)state;
    struct plain ground = plain_make(100, 40, 3);
    ground.late = true;
    pyramid_layer layer = {&ground.source, 1};
    struct pyramid *p = stack(&layer, 1);
    pthread_t thread;
    void *result;
    assert_int_equal(pthread_create(&thread, NULL, wait_for_tile, p), 0);
    while (ground.reads == 0) clock_sleep_s(0.01);
    pyramid_give_up(p);
    pthread_join(thread, &result);
    assert_int_equal((long)result, ERR_CANCELLED);
    for (int i = 0; i < ground.waiting_count; i++) want_give_back(&ground.waiting[i]);
    pyramid_destroy(&p);
}

// A tile below the data lies across tiles of the data: each of them is asked for in the first try.
static void neighbours_are_asked_for_together(void **state)
{
    (void)state;
    struct plain ground = plain_make(100, 40, 3);
    ground.late = true;
    pyramid_layer layers[] = {{&ground.source, 1}};
    struct pyramid *p = stack(layers, 1);
    struct want *want = want_create(1);
    const pyramid_tile *tile;
    tile_id id = {LAYER_HEIGHT, 6, 32, 64}; // touches a corner of zoom 3
    assert_int_equal(pyramid_try(p, id, want, &tile), ERR_PENDING);
    assert_int_equal(ground.reads, 4);
    want_release(&want);
    for (int i = 0; i < ground.waiting_count; i++) {
        assert_true(want_cancelled(ground.waiting[i]));
        want_give_back(&ground.waiting[i]);
    }
    pyramid_destroy(&p);
}

// What was given up for now has a stand-in, here and in the tiles made from it, which ends.
static void stand_ins_end(void **state)
{
    (void)state;
    struct plain ground = plain_make(100, 40, 3);
    ground.failing = true;
    pyramid_layer layers[] = {{&ground.source, 1}};
    struct pyramid *p = stack(layers, 1);
    tile_id id = fixture_tile_at(5, 0.3, 1.5);
    check_near(height_of(p, id, MIDDLE), 0, 0);
    ground.failing = false;
    check_near(height_of(p, id, MIDDLE), 0, 0); // still stands
    clock_sleep_s(0.06);
    check_near(height_of(p, id, MIDDLE), 100, 1e-3);
    int reads = ground.reads;
    clock_sleep_s(0.06);
    check_near(height_of(p, id, MIDDLE), 100, 1e-3);
    assert_int_equal(ground.reads, reads);
    pyramid_destroy(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(opacity_is_the_same_at_every_zoom),
        cmocka_unit_test(the_last_layer_lies_on_top),
        cmocka_unit_test(coverage_is_kept),
        cmocka_unit_test(another_body_is_refused),
        cmocka_unit_test(late_tiles_are_asked_for_together),
        cmocka_unit_test(heights_are_known_where_they_are),
        cmocka_unit_test(waiting_ends_when_it_is_given_up),
        cmocka_unit_test(neighbours_are_asked_for_together),
        cmocka_unit_test(stand_ins_end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
