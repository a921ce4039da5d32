// Bounds of a toroidal texture against a plain copy of it: they cover what it holds, and forget
// what it held.
#include "check.h"

#include "clipmap/bounds.h"

enum { ROWS = 24, COLS = 96 };

static float texture[ROWS][COLS];

static void write_strip(struct clip_bounds *b, int row, int rows, int col, int cols, float low,
                        float high, struct check_random *r)
{
    float samples[ROWS * COLS];
    clip_range ranges[ROWS * (COLS / CLIP_CELL)];
    for (int i = 0; i < rows * cols; i++) {
        samples[i] = (float)check_random_range(r, low, high);
        if (check_random_u64(r) % 16 == 0) samples[i] = NAN;
        texture[row + i / cols][col + i % cols] = samples[i];
    }
    clip_bounds_reduce(samples, rows, col, cols, ranges);
    clip_bounds_write(b, row, rows, col, cols, ranges);
}

static void check_covers(const struct clip_bounds *b, int64_t row0, int64_t row1)
{
    clip_range got = clip_bounds_of(b, row0, row1);
    for (int64_t row = row0; row < row1; row++)
        for (int col = 0; col < COLS; col++) {
            float v = texture[window_texel(row, ROWS)][col];
            if (!isnan(v)) assert_true(got.min <= v && v <= got.max);
        }
}

static void covers_what_is_held(void **state)
{
    (void)state;
    struct check_random r = {11};
    struct clip_bounds *b = clip_bounds_create(ROWS, COLS);
    write_strip(b, 0, ROWS, 0, COLS, -1, 1, &r);
    for (int n = 0; n < 3000; n++) {
        int row = (int)(check_random_u64(&r) % ROWS), col = (int)(check_random_u64(&r) % COLS);
        int rows = 1 + (int)(check_random_u64(&r) % (uint64_t)(ROWS - row));
        int cols = 1 + (int)(check_random_u64(&r) % (uint64_t)(COLS - col));
        float low = (float)check_random_range(&r, -9000, 9000);
        write_strip(b, row, rows, col, cols, low, low + 10, &r);
        int64_t row0 = (int64_t)(check_random_u64(&r) % 1000) - 500;
        check_covers(b, row0, row0 + (int64_t)(check_random_u64(&r) % (ROWS + 1)));
    }
    clip_bounds_destroy(&b);
}

static void forgets_what_was_overwritten(void **state)
{
    (void)state;
    struct check_random r = {12};
    struct clip_bounds *b = clip_bounds_create(ROWS, COLS);
    write_strip(b, 0, ROWS, 0, COLS, 8000, 8800, &r);
    // Column by column, as a viewer flying east does; a cell may keep one more turn of 32 columns.
    for (int turn = 0; turn < 2; turn++)
        for (int col = 0; col < COLS; col++) write_strip(b, 0, ROWS, col, 1, -10, 10, &r);
    clip_range got = clip_bounds_of(b, 0, ROWS);
    assert_true(got.min >= -10 && got.max <= 10);
    clip_bounds_destroy(&b);
}

static void nothing_is_empty(void **state)
{
    (void)state;
    struct clip_bounds *b = clip_bounds_create(ROWS, COLS);
    clip_range none = clip_bounds_of(b, 3, 3);
    clip_range untouched = clip_bounds_of(b, 0, ROWS);
    assert_true(isinf(none.min) && none.min > 0 && isinf(none.max) && none.max < 0);
    assert_true(isinf(untouched.min) && untouched.min > 0 && untouched.max < 0);
    clip_bounds_destroy(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(covers_what_is_held),
        cmocka_unit_test(forgets_what_was_overwritten),
        cmocka_unit_test(nothing_is_empty),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
