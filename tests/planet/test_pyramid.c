// The pyramid: order, threads, cache, holes, broken tiles, flat water, points and colour.
#include "check.h"

#include <pthread.h>

#include "base/log.h"
#include "base/vec.h"
#include "planet_fixture.h"

enum { SAMPLES = TILE_SIZE * TILE_SIZE, DATA_ZOOM = 3, MIB = 1 << 20 };

// Whole to DATA_ZOOM; to zoom 1, with sea and holes.
static fixture smooth, rough;

// The tile at zoom 1 that holds the south pole at 90 W has no data east of its middle, and its
// neighbour is not there at all.
static const tile_id holed = {LAYER_HEIGHT, 1, 1, 0}, absent = {LAYER_HEIGHT, 1, 1, 1};

static float holed_height(tile_id id, int row, int col, double lat, double lon)
{
    return tile_id_equal(id, holed) && col >= 128 ? NAN
                                                  : fixture_rough_height(id, row, col, lat, lon);
}

static bool not_absent(tile_id id)
{
    return !tile_id_equal(id, absent);
}

static void no_message(void *user, enum log_level level, const char *line)
{
    (void)user;
    (void)level;
    (void)line;
}

static int setup_group(void **state)
{
    (void)state;
    fixture_init(&smooth, "pyramid-smooth");
    fixture_init(&rough, "pyramid-rough");
    fixture_write(&smooth, DATA_ZOOM, 0.0, fixture_smooth_height, NULL);
    fixture_write(&rough, 1, 0.25, holed_height, not_absent);
    return 0;
}

static int teardown_group(void **state)
{
    (void)state;
    fixture_deinit(&smooth);
    fixture_deinit(&rough);
    return 0;
}

static uint64_t hash_of(const pyramid_tile *tile)
{
    uint64_t hash = 0xcbf29ce484222325u;
    const unsigned char *bytes = (const unsigned char *)tile->heights;
    for (int i = 0; i < SAMPLES * 4; i++) hash = (hash ^ bytes[i]) * 0x100000001b3u;
    return hash;
}

enum { ORDER_ZOOMS = 5, ORDER_TILES = FIXTURE_PLACES * ORDER_ZOOMS };

static void hash_tiles(const opened *o, const int *order, uint64_t *hashes)
{
    for (int i = 0; i < ORDER_TILES; i++) {
        int k = order[i];
        const pyramid_tile *tile =
            fixture_get(o, fixture_place_tile(k / ORDER_ZOOMS, 2 + 2 * (k % ORDER_ZOOMS)));
        hashes[k] = hash_of(tile);
        fixture_put_back(o, tile);
    }
}

static void shuffle(int *order, uint64_t seed)
{
    struct check_random random = {seed};
    for (int i = 0; i < ORDER_TILES; i++) order[i] = i;
    for (int i = ORDER_TILES - 1; i > 0; i--) {
        int j = (int)(check_random_u64(&random) % (uint64_t)(i + 1)), t = order[i];
        order[i] = order[j];
        order[j] = t;
    }
}

struct walker {
    opened *o;
    int order[ORDER_TILES];
    uint64_t hashes[ORDER_TILES];
};

static void *walk(void *arg)
{
    struct walker *w = arg;
    hash_tiles(w->o, w->order, w->hashes);
    return NULL;
}

// Fine to coarse, shuffled, with the smallest cache, and four threads at once.
static void order_and_threads_do_not_matter(void **state)
{
    (void)state;
    static struct walker first, walkers[4];
    for (int small = 0; small < 4; small++) {
        enum synthesis kind = small < 2 ? SYNTHESIS_ERODED : SYNTHESIS_PLAIN;
        opened o = fixture_open(&rough, 0, kind);
        first.o = &o;
        for (int i = 0; i < ORDER_TILES; i++) first.order[i] = i;
        walk(&first);
        fixture_close(&o);
        pthread_t threads[4];
        o = fixture_open(&rough, small % 2 ? 1 : 0, kind);
        for (int i = 0; i < 4; i++) {
            walkers[i].o = &o;
            shuffle(walkers[i].order, (uint64_t)(99 + i + 10 * small));
            pthread_create(&threads[i], NULL, walk, &walkers[i]);
        }
        for (int i = 0; i < 4; i++) {
            pthread_join(threads[i], NULL);
            assert_memory_equal(walkers[i].hashes, first.hashes, sizeof first.hashes);
        }
        struct pyramid_counters c;
        pyramid_counters(o.pyramid, &c);
        assert_true(c.cache_hits > 0);
        fixture_close(&o);
    }
}

// A tile far below the data makes no other tile: only what is stored is read besides.
static void a_deep_tile_makes_no_other(void **state)
{
    (void)state;
    opened o = fixture_open(&rough, 0, SYNTHESIS_ERODED);
    struct pyramid_counters c;
    for (int place = 0; place < FIXTURE_PLACES; place++)
        fixture_put_back(&o, fixture_get(&o, fixture_place_tile(place, GRID_MAX_ZOOM)));
    pyramid_counters(o.pyramid, &c);
    // All of zoom 1 may be asked for; its tile that is not stored is made, and the one with holes.
    // Beside these, what is stored is read once more, for where it ends.
    assert_true(c.synthesised <= FIXTURE_PLACES + 2);
    assert_true(c.decoded <= 18);
    fixture_close(&o);
}

static void the_cache_keeps_its_bound(void **state)
{
    (void)state;
    enum { HELD = 100 };
    opened o = fixture_open(&smooth, 1, SYNTHESIS_NONE); // raised to 16 MiB: 63 tiles
    const pyramid_tile *held[HELD];
    struct pyramid_counters c;
    int n = 0;
    for (int row = 0; row < 8; row++)
        for (int col = 0; col < grid_cols(3, row); col++) {
            fixture_put_back(&o, fixture_get(&o, (tile_id){LAYER_HEIGHT, 3, row, col}));
            pyramid_counters(o.pyramid, &c);
            assert_true(c.cache_bytes <= 16 * MIB);
        }
    assert_true(c.cache_bytes > 15 * MIB);
    for (int row = 0; row < 8 && n < HELD; row++)
        for (int col = 0; col < grid_cols(3, row) && n < HELD; col++)
            held[n++] = fixture_get(&o, (tile_id){LAYER_HEIGHT, 3, row, col});
    assert_int_equal(n, HELD);
    pyramid_counters(o.pyramid, &c);
    assert_true(c.cache_bytes >= (uint64_t)HELD * SAMPLES * 4);
    uint64_t hash = hash_of(held[0]);
    for (int i = n - 1; i > 0; i--) fixture_put_back(&o, held[i]);
    pyramid_counters(o.pyramid, &c);
    assert_true(c.cache_bytes <= 16 * MIB);
    for (int col = 0; col < 8; col++)
        fixture_put_back(&o, fixture_get(&o, (tile_id){LAYER_HEIGHT, 3, 3, col}));
    assert_true(hash_of(held[0]) == hash); // what is held is not evicted
    fixture_put_back(&o, held[0]);
    pyramid_counters(o.pyramid, &c);
    assert_true(c.cache_bytes <= 16 * MIB);
    fixture_close(&o);
}

// A held tile asked again is the same tile, and nothing is made.
static void tiles_are_made_once(void **state)
{
    (void)state;
    opened o = fixture_open(&smooth, 0, SYNTHESIS_NONE);
    struct pyramid_counters before, after;
    const pyramid_tile *a = fixture_get(&o, fixture_place_tile(3, 3));
    pyramid_counters(o.pyramid, &before);
    const pyramid_tile *b = fixture_get(&o, fixture_place_tile(3, 3));
    pyramid_counters(o.pyramid, &after);
    assert_ptr_equal(a, b);
    assert_int_equal(after.decoded, before.decoded);
    assert_int_equal(after.cache_hits, before.cache_hits + 1);
    fixture_put_back(&o, a);
    fixture_put_back(&o, b);
    fixture_close(&o);
}

// Farther than synthesis takes to come in from the tile's stored half and from the tiles around it.
static bool is_far(int i)
{
    int row = i / TILE_SIZE, col = i % TILE_SIZE;
    return row >= 8 && row < TILE_SIZE - 8 && col >= 128 + 16 && col < TILE_SIZE - 16;
}

// Samples a stored tile lacks are what they would be if it were not stored at all; with synthesis
// away from what is stored.
static void holes_are_filled_as_if_nothing_were_stored(void **state)
{
    (void)state;
    fixture without;
    fixture_init(&without, "pyramid-without");
    fixture_write(&without, 0, 0.25, fixture_rough_height, NULL);
    // One tile elsewhere, so that the finest zoom is the same.
    struct planet_writer *w;
    struct planet_meta meta = {.name = "", .ellipsoid = GEO_WGS84, .synthesis_gain = 0.25};
    assert_int_equal(planet_writer_open(without.path, "fixture", true, &w), OK);
    codec_blob body;
    static float flat[SAMPLES];
    assert_int_equal(codec_height_encode(flat, &body), OK);
    assert_int_equal(planet_writer_put(w, (tile_id){LAYER_HEIGHT, 1, 0, 3}, &body, 0, 0), OK);
    codec_blob_deinit(&body);
    assert_int_equal(planet_writer_finish(w, &meta), OK);
    planet_writer_close(&w);
    for (enum synthesis synthesis = 0; synthesis <= SYNTHESIS_PLAIN; synthesis++) {
        opened a = fixture_open(&rough, 0, synthesis), b = fixture_open(&without, 0, synthesis);
        const pyramid_tile *with = fixture_get(&a, holed), *made = fixture_get(&b, holed);
        for (int i = 0; i < SAMPLES; i++) {
            double lat, lon;
            fixture_place(holed, i / TILE_SIZE, i % TILE_SIZE, &lat, &lon);
            bool stored = i % TILE_SIZE < 128;
            float want = stored ? fixture_rough_height(holed, 0, 0, lat, lon) : made->heights[i];
            if (!synthesis || stored || is_far(i)) assert_true(with->heights[i] == want);
        }
        fixture_put_back(&a, with);
        fixture_put_back(&b, made);
        with = fixture_get(&a, absent), made = fixture_get(&b, absent);
        for (int i = 0; i < SAMPLES; i++)
            if (!synthesis || is_far(i)) assert_true(with->heights[i] == made->heights[i]);
        fixture_put_back(&a, with);
        fixture_put_back(&b, made);
        fixture_close(&a);
        fixture_close(&b);
    }
    fixture_deinit(&without);
}

// A corrupt tile shows its parent's data, is counted once, and its neighbours are unharmed.
static void corrupt_tiles_show_their_parents(void **state)
{
    (void)state;
    fixture broken;
    const tile_id bad = {LAYER_HEIGHT, 1, 0, 2}, child = {LAYER_HEIGHT, 2, 1, 5};
    fixture_init(&broken, "pyramid-broken");
    struct planet_writer *w;
    struct planet_meta meta = {.name = "", .ellipsoid = GEO_WGS84};
    assert_int_equal(planet_writer_open(broken.path, "fixture", false, &w), OK);
    fixture_put_heights(w, 1, fixture_smooth_height, NULL);
    codec_blob junk = {(unsigned char *)"junk", 4};
    assert_int_equal(planet_writer_put(w, bad, &junk, 0, 0), OK);
    assert_int_equal(planet_writer_finish(w, &meta), OK);
    planet_writer_close(&w);
    log_set_sink(no_message, NULL);
    opened o = fixture_open(&broken, 1, SYNTHESIS_NONE);
    struct pyramid_counters c;
    for (int round = 0; round < 3; round++) {
        const pyramid_tile *tile = fixture_get(&o, bad);
        for (int i = 0; i < SAMPLES; i += 97) {
            double lat, lon;
            fixture_place(bad, i / TILE_SIZE, i % TILE_SIZE, &lat, &lon);
            check_near(tile->heights[i], fixture_smooth(lat, lon), 0.01); // measured 2.4e-3
        }
        fixture_put_back(&o, tile);
        fixture_put_back(&o, fixture_get(&o, child));
        for (int row = 0; row < 8; row++) // drives it out of the cache
            for (int col = 0; col < 8; col++)
                fixture_put_back(&o, fixture_get(&o, (tile_id){LAYER_HEIGHT, 4, row, col}));
        pyramid_counters(o.pyramid, &c);
        assert_int_equal(c.corrupt, 1);
    }
    fixture_close(&o);
    log_set_sink(NULL, NULL);
    fixture_deinit(&broken);
}

// Flat water is exactly flat at every zoom, up to the shore, and the land is not.
static void a_flat_sea_stays_flat(void **state)
{
    (void)state;
    opened o = fixture_open(&rough, 0, SYNTHESIS_ERODED);
    for (int zoom = 2; zoom <= 12; zoom++) {
        const pyramid_tile *sea = fixture_get(&o, fixture_tile_at(zoom, 0.2, M_PI - 0.05));
        assert_true(sea->min == 0.0f && sea->max == 0.0f);
        fixture_put_back(&o, sea);
        const pyramid_tile *hills = fixture_get(&o, fixture_tile_at(zoom, 0.2, 0.1));
        assert_true(hills->max > hills->min);
        fixture_put_back(&o, hills);
    }
    fixture_close(&o);
}

static void data_zoom_is_the_nearest_stored(void **state)
{
    (void)state;
    opened o = fixture_open(&rough, 0, SYNTHESIS_ERODED);
    for (int zoom = 0; zoom <= GRID_MAX_ZOOM; zoom += 3)
        for (int place = 0; place < FIXTURE_PLACES; place++) {
            tile_id id = fixture_place_tile(place, zoom), up = id;
            while (up.zoom > 1) up = tile_parent(up);
            int want = up.zoom == 1 && !tile_id_equal(up, absent) ? 1 : 0;
            assert_int_equal(pyramid_data_zoom(o.pyramid, id), want);
            id.layer = LAYER_COLOR;
            assert_int_equal(pyramid_data_zoom(o.pyramid, id), -1);
        }
    assert_int_equal(pyramid_data_zoom(o.pyramid, absent), 0);
    fixture_close(&o);
}

// Bilinear: measured 7.7e-3 m at zoom 3 against the field (its curvature), and continuous across
// the antimeridian and the poles.
static void heights_at_points(void **state)
{
    (void)state;
    opened o = fixture_open(&smooth, 0, SYNTHESIS_NONE);
    struct check_random random = {21};
    double h, other;
    for (int k = 0; k < 2000; k++) {
        double lat = asin(check_random_range(&random, -1, 1)),
               lon = check_random_range(&random, -9, 9);
        assert_int_equal(pyramid_height_at(o.pyramid, DATA_ZOOM, lat, lon, &h), OK);
        check_near(h, fixture_smooth(lat, lon), 0.02);
    }
    for (int k = -8; k <= 8; k++) {
        double lat = k * M_PI / 16.0001;
        assert_int_equal(pyramid_height_at(o.pyramid, 3, lat, M_PI - 1e-12, &h), OK);
        assert_int_equal(pyramid_height_at(o.pyramid, 3, lat, -M_PI + 1e-12, &other), OK);
        check_near(h, other, 1e-6);
        assert_int_equal(pyramid_height_at(o.pyramid, 3, M_PI / 2, k * 0.4, &h), OK);
        check_near(h, fixture_smooth(M_PI / 2, 0.0), 0.05);
        assert_int_equal(pyramid_height_at(o.pyramid, 3, -M_PI / 2, k * 0.4, &h), OK);
        check_near(h, fixture_smooth(-M_PI / 2, 0.0), 0.05);
    }
    assert_int_equal(pyramid_height_at(o.pyramid, 99, 2.0, 1e6, &h), OK);
    fixture_close(&o);
}

// Colour comes with light in its alpha; each from its own layer, and what is missing from parents.
static void color_and_light_are_joined(void **state)
{
    (void)state;
    fixture f;
    fixture_init(&f, "pyramid-color");
    static unsigned char pixels[SAMPLES * 3];
    struct planet_writer *w;
    struct planet_meta meta = {.name = "", .ellipsoid = GEO_WGS84};
    codec_blob body;
    assert_int_equal(planet_writer_open(f.path, "fixture", false, &w), OK);
    for (int i = 0; i < SAMPLES * 3; i++) pixels[i] = (unsigned char)(60 * (i % 3 + 1));
    assert_int_equal(codec_pixels_encode(pixels, 3, 95, &body), OK);
    for (int col = 0; col < 2; col++)
        assert_int_equal(planet_writer_put(w, (tile_id){LAYER_COLOR, 0, 0, col}, &body, 0, 0), OK);
    codec_blob_deinit(&body);
    memset(pixels, 200, SAMPLES);
    assert_int_equal(codec_pixels_encode(pixels, 1, 95, &body), OK);
    assert_int_equal(planet_writer_put(w, (tile_id){LAYER_NIGHT, 1, 0, 0}, &body, 0, 0), OK);
    codec_blob_deinit(&body);
    assert_int_equal(planet_writer_finish(w, &meta), OK);
    planet_writer_close(&w);
    opened o = fixture_open(&f, 0, SYNTHESIS_ERODED);
    static const int nights[] = {0, 200, 200}, other[] = {0, 0, 0};
    for (int zoom = 0; zoom < 3; zoom++)
        for (int side = 0; side < 2; side++) {
            // In the middle of the tile with light, and far from it.
            tile_id id = fixture_tile_at(zoom, 0.9, side ? 1.0 : -2.2);
            id.layer = LAYER_COLOR;
            const pyramid_tile *tile = fixture_get(&o, id);
            const uint8_t *p = tile->rgba + 4 * (TILE_SIZE * 128 + 128);
            for (int c = 0; c < 3; c++) check_near(p[c], 60.0 * (c + 1), 2.0);
            check_near(p[3], side ? other[zoom] : nights[zoom], 2.0);
            assert_null(tile->heights);
            fixture_put_back(&o, tile);
        }
    // No heights at all: the ground is at 0.
    const pyramid_tile *ground = fixture_get(&o, fixture_tile_at(5, 0.3, 0.3));
    assert_true(ground->min == 0.0f && ground->max == 0.0f);
    fixture_put_back(&o, ground);
    fixture_close(&o);
    fixture_deinit(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(order_and_threads_do_not_matter),
        cmocka_unit_test(a_deep_tile_makes_no_other),
        cmocka_unit_test(the_cache_keeps_its_bound),
        cmocka_unit_test(tiles_are_made_once),
        cmocka_unit_test(holes_are_filled_as_if_nothing_were_stored),
        cmocka_unit_test(corrupt_tiles_show_their_parents),
        cmocka_unit_test(a_flat_sea_stays_flat),
        cmocka_unit_test(data_zoom_is_the_nearest_stored),
        cmocka_unit_test(heights_at_points),
        cmocka_unit_test(color_and_light_are_joined),
    };
    return cmocka_run_group_tests(tests, setup_group, teardown_group);
}
