// Bounds of a toroidal texture: those of the blocks that the window touches and of nothing else,
// whatever it held before, while the window walks over a field of the test's own.
#include "check.h"

#include "clipmap/bounds.h"
#include "clipmap/strips.h"

enum { SHARE = 3 };

static const window_shape SHAPE = {.rows = 24, .cols = 96, .diameter_rows = 256};

// Around the circle of columns; now and then nothing.
static float field(int64_t row, int64_t col, int share)
{
    int64_t circle = (int64_t)SHAPE.cols << share, around = (col % circle + circle) % circle;
    struct check_random r = {(uint64_t)(row + 1000) * 7919 + (uint64_t)around * 104729 + 1};
    check_random_u64(&r);
    double size = check_random_u64(&r) % 50 ? 10 : 9000; // single summits
    return check_random_u64(&r) % 16 ? (float)check_random_range(&r, -size, size) : NAN;
}

static int64_t floor_to_cell(int64_t col)
{
    return col - ((col % CLIP_CELL) + CLIP_CELL) % CLIP_CELL;
}

static clip_range range_of(int64_t row, int64_t col0, int64_t col1, int share)
{
    clip_range r = CLIP_RANGE_EMPTY;
    for (int64_t col = col0; col < col1; col++) {
        float h = field(row, col, share);
        if (h < r.min) r.min = h;
        if (h > r.max) r.max = h;
    }
    return r;
}

// As a worker has it, or, not whole, as the GPU tells it.
static void write_strip(struct clip_bounds *b, window_rect s, int share, bool whole)
{
    clip_range ranges[64 * 8], *next = ranges;
    for (int64_t row = s.row0; row < s.row1; row++)
        for (int64_t col = floor_to_cell(s.col0); col < s.col1; col += CLIP_CELL) {
            int64_t from = whole || col > s.col0 ? col : s.col0, end = col + CLIP_CELL;
            *next++ = range_of(row, from, whole || end < s.col1 ? end : s.col1, share);
        }
    clip_bounds_write(b, share, s, ranges, whole);
}

static window_rect window_around(int64_t row, int64_t col)
{
    return (window_rect){row, row + SHAPE.rows, col, col + SHAPE.cols};
}

static void walk(bool whole, uint64_t seed)
{
    struct check_random r = {seed};
    struct clip_bounds *b = clip_bounds_create(SHAPE.rows, SHAPE.cols);
    window_rect held = {0};
    int64_t row = 0, col = 0;
    int share = SHARE;
    for (int n = 0; n < 1500; n++) {
        int64_t reach = n % 10 ? 3 : 60;
        row += (int64_t)check_random_range(&r, -(double)reach, (double)reach + 1);
        col += (int64_t)check_random_range(&r, -(double)reach, (double)reach + 1);
        if (n % 97 == 0) share = n % 2 ? 1 : SHARE, held = (window_rect){0};
        window_rect target = window_around(row, col);
        held = window_rect_intersect(held, target);
        if (window_rect_empty(held)) held = (window_rect){0};
        clip_strips strips = clip_strips_missing(&SHAPE, target, held);
        for (window_rect s; clip_strips_take(&strips, 7, &s);) write_strip(b, s, share, whole);
        held = target;
        clip_range got = clip_bounds_of(b, share, held), want = CLIP_RANGE_EMPTY, least = want;
        for (int64_t i = held.row0; i < held.row1; i++) {
            clip_range blocks = range_of(i, floor_to_cell(held.col0),
                                         floor_to_cell(held.col1 - 1) + CLIP_CELL, share),
                       inside = range_of(i, held.col0, held.col1, share);
            want.min = fminf(want.min, blocks.min);
            want.max = fmaxf(want.max, blocks.max);
            least.min = fminf(least.min, inside.min);
            least.max = fmaxf(least.max, inside.max);
        }
        if (whole) assert_true(got.min == want.min && got.max == want.max);
        assert_true(got.min <= least.min && got.max >= least.max);
        assert_true(got.min >= want.min && got.max <= want.max);
    }
    clip_bounds_destroy(&b);
}

static void those_of_the_blocks(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed < 4; seed++) walk(true, seed);
}

static void parts_of_blocks(void **state)
{
    (void)state;
    walk(false, 5);
}

// A whole circle counts its columns from anywhere.
static void the_whole_circle(void **state)
{
    (void)state;
    struct clip_bounds *b = clip_bounds_create(SHAPE.rows, SHAPE.cols);
    window_rect w = window_around(0, 0), turned = window_around(0, -3 * SHAPE.cols);
    write_strip(b, w, 0, true);
    clip_range here = clip_bounds_of(b, 0, w), there = clip_bounds_of(b, 0, turned);
    assert_true(here.min < here.max && here.min == there.min && here.max == there.max);
    clip_bounds_destroy(&b);
}

static void nothing_is_empty(void **state)
{
    (void)state;
    struct clip_bounds *b = clip_bounds_create(SHAPE.rows, SHAPE.cols);
    window_rect none = {3, 3, 0, 9};
    clip_range of_none = clip_bounds_of(b, SHARE, none),
               untouched = clip_bounds_of(b, 0, window_around(0, 0));
    assert_true(isinf(of_none.min) && of_none.min > 0 && isinf(of_none.max) && of_none.max < 0);
    assert_true(isinf(untouched.min) && untouched.min > 0 && untouched.max < 0);
    clip_bounds_destroy(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(those_of_the_blocks),
        cmocka_unit_test(parts_of_blocks),
        cmocka_unit_test(the_whole_circle),
        cmocka_unit_test(nothing_is_empty),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
