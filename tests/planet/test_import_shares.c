// Tiles of a zoom divided among ranks that ask in any order: each goes out once; who made a tile
// mostly makes its parent; none waits for a slow rank. And the order of a walk: few children are
// needed again later.
//
// Fails when broken: a walk that skips less than a split says, or counts one tile too few (once);
// runs that are not turned from zoom to zoom, or of the same size whoever is slow, or not a rank's
// own first (kin); nothing taken from other ranks (slow), or not their last tile (absent); a walk
// by rows alone (again: 2.01 times).
#include "check.h"

#include "planet/import_shares.h"

enum { ZOOM = 7, MOST = 64, MAX_RANKS = 7 };

static const plan_bounds everywhere = {-M_PI, -M_PI / 2, M_PI, M_PI / 2};

// The globe at one zoom and a finer patch.
static const raster_grid grids[] = {
    {.west = -M_PI, .east = M_PI, .south = -M_PI / 2, .north = M_PI / 2, .zoom = ZOOM},
    {.west = 0.1, .east = 0.9, .south = 0.2, .north = 1.1, .zoom = ZOOM + 2},
};

static int grid_count = 2;

static struct plan_walk *walk_zoom(int zoom)
{
    return plan_walk_begin(LAYER_HEIGHT, zoom, grids, grid_count, &everywhere, 0);
}

// Who made a tile, for each zoom, row and column: rank + 1.
static unsigned char makers[ZOOM + 3][512][1024];

static void note(tile_id id, int rank)
{
    assert_int_equal(makers[id.zoom][id.row][id.col], 0);
    makers[id.zoom][id.row][id.col] = (unsigned char)(rank + 1);
}

static uint64_t count_walk(int zoom)
{
    struct plan_walk *walk = walk_zoom(zoom);
    uint64_t left = plan_walk_left(walk), n = 0;
    tile_id id;
    for (; plan_walk_next(walk, &id); n++) assert_int_equal(plan_walk_left(walk), left - n - 1);
    assert_int_equal(n, left);
    plan_walk_end(&walk);
    return n;
}

// Hands out a zoom to ranks that make `speed` tiles in a unit of time. The most tiles that one of
// them still had to make when there was nothing left for another, in units of time.
static double share_zoom(struct shares *s, int zoom, int ranks, const double *speed)
{
    double busy[MAX_RANKS] = {0}, first = INFINITY, last = 0;
    bool done[MAX_RANKS] = {0};
    uint64_t given = 0;
    shares_divide(s, walk_zoom(zoom));
    for (int left = ranks; left > 0;) {
        int rank = -1;
        for (int i = 0; i < ranks; i++)
            if (!done[i] && (rank < 0 || busy[i] < busy[rank])) rank = i;
        tile_id id;
        int batch = shares_batch(s, rank, MOST), count = 0;
        assert_in_range(batch, 1, MOST);
        for (; count < batch && shares_next(s, rank, &id); count++) note(id, rank);
        given += (uint64_t)count;
        busy[rank] += count / speed[rank];
        done[rank] = count == 0;
        left -= done[rank];
        if (done[rank]) {
            first = fmin(first, busy[rank]);
            last = fmax(last, busy[rank]);
        }
    }
    assert_int_equal(given, count_walk(zoom));
    return last - first;
}

static int start(int ranks, struct shares **s)
{
    *s = shares_create(ranks);
    memset(makers, 0, sizeof makers);
    return grid_count > 1 ? ZOOM + 2 : ZOOM;
}

static void each_goes_out_once(void **state)
{
    (void)state;
    struct check_random random = {7};
    for (int ranks = 1; ranks <= MAX_RANKS; ranks += 2) {
        struct shares *s;
        for (int zoom = start(ranks, &s); zoom >= 0; zoom--) {
            double speed[MAX_RANKS];
            for (int i = 0; i < ranks; i++) speed[i] = exp(check_random_range(&random, -3, 3));
            if (zoom == 3) shares_forget(s);
            share_zoom(s, zoom, ranks, speed);
        }
        shares_destroy(&s);
    }
}

// Tiles whose maker is not that of its parent, among those of a zoom.
static double strangers(int zoom)
{
    int strange = 0, all = 0;
    for (int row = 0; row < grid_rows(zoom); row++)
        for (int col = 0; col < grid_cols(zoom, row); col++) {
            if (!makers[zoom][row][col]) continue;
            tile_id up = tile_parent((tile_id){LAYER_HEIGHT, zoom, row, col});
            all++;
            strange += makers[up.zoom][up.row][up.col] != makers[zoom][row][col];
        }
    return (double)strange / all;
}

static void kin_stays_together(void **state)
{
    (void)state;
    static const double speeds[3][4] = {{1, 1, 1, 1}, {1, 0.2, 1, 1}, {0.25, 1, 0.5, 1}};
    grid_count = 1;
    for (int ranks = 2; ranks <= 4; ranks += 2)
        for (int i = 0; i < 3; i++) {
            struct shares *s;
            for (int zoom = start(ranks, &s); zoom >= 0; zoom--)
                share_zoom(s, zoom, ranks, speeds[i]);
            shares_destroy(&s);
            double share = strangers(ZOOM);
            print_message("%d ranks, speeds %d: %.3f\n", ranks, i, share);
            // Strangers lie along the borders of shares, in rows of 256 tiles of 128 rows.
            assert_true(share < (ranks == 2 ? 0.03 : 0.08));
        }
    grid_count = 2;
}

enum { KEPT = 160 };

// The tiles used last, the latest last.
struct kept {
    tile_id ids[KEPT];
    int count;
};

// True when it was not there.
static bool use(struct kept *kept, tile_id id)
{
    int at = kept->count - 1;
    while (at >= 0 && !tile_id_equal(kept->ids[at], id)) at--;
    bool missing = at < 0;
    if (missing) at = 0;
    if (missing && kept->count < KEPT) at = kept->count++;
    memmove(kept->ids + at, kept->ids + at + 1, (size_t)(kept->count - 1 - at) * sizeof *kept->ids);
    kept->ids[kept->count - 1] = id;
    return missing;
}

// Children that are no longer among the last KEPT tiles made or read when they are needed again.
static void few_children_are_needed_again(void **state)
{
    (void)state;
    static struct kept kept;
    int zoom = ZOOM, loads = 0, children = 0;
    raster_grid wide = grids[1];
    wide.west = -2;
    wide.east = 2;
    wide.south = -0.6;
    wide.north = 0.6;
    struct plan_walk *walk = plan_walk_begin(LAYER_HEIGHT, zoom, &wide, 1, &everywhere, 0);
    for (tile_id id; plan_walk_next(walk, &id);) {
        children += 4;
        for (int row = 2 * id.row - 1; row <= 2 * id.row + 2; row++)
            for (int col = 2 * id.col - 1; col <= 2 * id.col + 2; col++)
                loads += use(&kept, (tile_id){LAYER_HEIGHT, zoom + 1, row, col});
        use(&kept, id);
    }
    plan_walk_end(&walk);
    print_message("%d children, read %.2f times\n", children, (double)loads / children);
    assert_true(loads < 1.3 * children);
}

static void none_waits_for_a_slow_rank(void **state)
{
    (void)state;
    static const double speed[3] = {1, 0.1, 1};
    struct shares *s;
    for (int zoom = start(3, &s); zoom >= ZOOM - 2; zoom--) {
        double waits = share_zoom(s, zoom, 3, speed);
        print_message("zoom %d: %.0f of %.0f\n", zoom, waits, (double)count_walk(zoom) / 2.1);
        assert_true(waits <= MOST / speed[1]); // its last batch
    }
    shares_destroy(&s);
}

static void one_does_what_absent_ranks_would(void **state)
{
    (void)state;
    struct shares *s;
    for (int zoom = start(5, &s); zoom >= 0; zoom--) {
        uint64_t count = 0;
        shares_divide(s, walk_zoom(zoom));
        for (tile_id id; shares_next(s, 2, &id); count++) note(id, 2);
        assert_int_equal(count, count_walk(zoom));
    }
    shares_destroy(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_goes_out_once),
        cmocka_unit_test(kin_stays_together),
        cmocka_unit_test(none_waits_for_a_slow_rank),
        cmocka_unit_test(one_does_what_absent_ranks_would),
        cmocka_unit_test(few_children_are_needed_again),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
