// The regions of 2004's form: the four nesting constraints for whatever data there are, render
// regions that tile, transitions that fit.
#include "check.h"

#include "render/planar_regions.h"

enum { LEVELS = 8, FIRST = 4 };

// What a level has: all of it, or less from some sides, or nothing.
static planar_region random_clip(struct check_random *r, int n)
{
    planar_region c = {-1, n, -1, n};
    int *ends[4] = {&c.row0, &c.row1, &c.column0, &c.column1};
    for (int i = 0; i < 4; i++)
        if (check_random_u64(r) % 3 == 0)
            *ends[i] += (i % 2 ? -1 : 1) * (int)check_random_range(r, 0, n * 0.6);
    if (check_random_u64(r) % 12 == 0) c.row1 = c.row0;
    return c;
}

// a lies in b less `by` all around.
static bool inside(planar_region a, planar_region b, int by)
{
    return a.row0 >= b.row0 + by && a.row1 <= b.row1 - by && a.column0 >= b.column0 + by &&
           a.column1 <= b.column1 - by;
}

static bool even_border(planar_region a)
{
    return !(a.row0 & 1 || a.row1 & 1 || a.column0 & 1 || a.column1 & 1);
}

static int count_in(planar_region a, int row, int column)
{
    return row >= a.row0 && row < a.row1 && column >= a.column0 && column < a.column1;
}

// Every quad of the active region is in one rectangle or in the finer region.
static void check_frame(planar_region active, planar_region finer)
{
    planar_region parts[4];
    int count = planar_region_frame(active, finer, parts);
    for (int row = active.row0; row < active.row1; row++) {
        for (int column = active.column0; column < active.column1; column++) {
            int hits = !planar_region_empty(finer) && count_in(finer, row, column);
            for (int i = 0; i < count; i++) hits += count_in(parts[i], row, column);
            assert_int_equal(hits, 1);
        }
    }
    for (int i = 0; i < count; i++) assert_true(inside(parts[i], active, 0));
}

static void test_constraints(void **state)
{
    (void)state;
    struct check_random r = {12};
    int levels = 0, cropped = 0;
    for (int i = 0; i < 4000; i++) {
        int n = i % 2 ? 63 : 127;
        double lat = check_random_range(&r, -1.4, 1.4), lon = check_random_range(&r, -3.1, 3.1);
        double share = i % 5 ? 1 : check_random_range(&r, 0.1, 1);
        nest_square squares[FIRST + LEVELS];
        planar_region clip[FIRST + LEVELS], active[FIRST + LEVELS], given[FIRST + LEVELS];
        for (int k = FIRST; k < FIRST + LEVELS; k++) {
            squares[k] = nest_square_at(n, k, lat, lon);
            given[k] = clip[k] = random_clip(&r, n);
        }
        int last = planar_regions_crop(squares, FIRST, FIRST + LEVELS - 1, share, clip, active);
        levels += last - FIRST;
        for (int k = FIRST + 1; k <= last; k++) {
            planar_region up = planar_region_in_coarser(&squares[k], &squares[k - 1], active[k]),
                          clip_up = {0};
            planar_region rounded = clip[k]; // outwards, to the coarser vertices
            rounded.row0 -= rounded.row0 & 1;
            rounded.column0 -= rounded.column0 & 1;
            rounded.row1 += rounded.row1 & 1;
            rounded.column1 += rounded.column1 & 1;
            clip_up = planar_region_in_coarser(&squares[k], &squares[k - 1], rounded);
            assert_true(inside(clip_up, clip[k - 1], 1)); // (1)
            assert_true(inside(clip[k], given[k], 0));
            assert_true(inside(active[k], clip[k], 0)); // (2)
            assert_true(even_border(active[k]));        // (3)
            assert_true(inside(up, active[k - 1], 2));  // (4)
            assert_true(inside(active[k], (planar_region){0, n - 1, 0, n - 1}, 0));
            cropped += active[k].row1 - active[k].row0 < n - 1;
            check_frame(active[k - 1], up);
            double width = planar_region_transition(n, active[k - 1], up);
            assert_true(width >= 2 && width <= n / 10.0 && width <= up.row0 - active[k - 1].row0 &&
                        width <= active[k - 1].column1 - up.column1);
            // No corner of the finer region lies where the transition has begun.
            double begin = planar_region_begin(&squares[k - 1], active[k - 1], up);
            assert_true(fabs(up.row0 - squares[k - 1].view_row) <= begin);
            assert_true(fabs(up.row1 - squares[k - 1].view_row) <= begin);
            assert_true(fabs(up.column0 - squares[k - 1].view_column) <= begin);
            assert_true(fabs(up.column1 - squares[k - 1].view_column) <= begin);
        }
        check_frame(active[last], (planar_region){0});
    }
    print_message("%d levels besides the coarsest, %d of them cropped\n", levels, cropped);
    assert_true(levels > 6000 && cropped > 3000);
}

// With all data and no bound the regions are the squares.
static void test_whole(void **state)
{
    (void)state;
    nest_square squares[6];
    planar_region clip[6], active[6];
    for (int k = 0; k < 6; k++) {
        squares[k] = nest_square_at(255, k + 3, 0.5, 1);
        clip[k] = (planar_region){-1, 257, -1, 257};
    }
    assert_int_equal(planar_regions_crop(squares, 0, 5, 1, clip, active), 5);
    for (int k = 0; k < 6; k++) assert_true(inside((planar_region){0, 254, 0, 254}, active[k], 0));
    for (int k = 0; k < 5; k++) {
        planar_region up = planar_region_in_coarser(&squares[k + 1], &squares[k], active[k + 1]);
        check_near(planar_region_begin(&squares[k], active[k], up), 127 - 25.5 - 1, 1e-9);
    }
    // A share of the side, about the middle.
    planar_region half = planar_region_wanted(&squares[0], 0.5);
    assert_int_equal(half.row0 + half.row1, 254);
    assert_true(half.row1 - half.row0 >= 124 && half.row1 - half.row0 <= 128);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_constraints),
                                       cmocka_unit_test(test_whole)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
