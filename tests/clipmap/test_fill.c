// clipmap_fill against the oracle: every ratio of window to tile step, tile borders, the
// antimeridian, both poles.
#include "check.h"

#include <math.h>

#include "clipmap/clipmap.h"
#include "fake_pyramid.h"
#include "oracle.h"

static int
    ratios[3]; // rows seen with columns finer than, equal to, coarser than the tile's samples

static void count_ratio(int cols, const window *w, int64_t row)
{
    int64_t rows = (int64_t)256 << w->zoom;
    int64_t r = row < 0 ? -1 - row : row >= rows ? 2 * rows - 1 - row : row;
    int64_t tile = 2 * rows / oracle_coalesce(w->zoom, r / 256), circle = (int64_t)cols << w->share;
    ratios[tile < circle ? 0 : tile == circle ? 1 : 2]++;
}

static void check_heights(struct pyramid *p, const window_shape *shape, const window *w,
                          window_rect r)
{
    size_t rows = (size_t)(r.row1 - r.row0), cols = (size_t)(r.col1 - r.col0);
    float *got = malloc(rows * cols * sizeof *got), *want = malloc(cols * sizeof *want);
    assert_int_equal(clipmap_fill(p, LAYER_HEIGHT, shape, w, r, got), OK);
    for (size_t i = 0; i < rows; i++) {
        int64_t row = r.row0 + (int64_t)i;
        count_ratio(shape->cols, w, row);
        oracle_heights(shape->cols, w->zoom, w->share, row, r.col0, r.col1, want);
        for (size_t j = 0; j < cols; j++) {
            if (got[i * cols + j] == want[j]) continue;
            print_error("zoom %d share %d row %d column %d: got %g, want %g\n", w->zoom, w->share,
                        (int)row, (int)r.col0 + (int)j, (double)got[i * cols + j], (double)want[j]);
            fail();
        }
    }
    free(got);
    free(want);
}

// Codes may differ by rounding: the tables hold 14 bits of linear light, at least five steps a
// code.
static void check_colors(struct pyramid *p, const window_shape *shape, const window *w,
                         window_rect r)
{
    size_t rows = (size_t)(r.row1 - r.row0), cols = (size_t)(r.col1 - r.col0);
    uint8_t *got = malloc(rows * cols * 4);
    double(*want)[4] = malloc(cols * sizeof *want);
    assert_int_equal(clipmap_fill(p, LAYER_COLOR, shape, w, r, got), OK);
    for (size_t i = 0; i < rows; i++) {
        count_ratio(shape->cols, w, r.row0 + (int64_t)i);
        oracle_colors(shape->cols, w->zoom, w->share, r.row0 + (int64_t)i, r.col0, r.col1, want);
        for (size_t j = 0; j < 4 * cols; j++)
            check_near(got[i * cols * 4 + j], want[j / 4][j % 4], 0.65);
    }
    free(got);
    free(want);
}

// A part of a window, anywhere in it, moved by whole turns now and then.
static window_rect random_part(struct check_random *r, const window_shape *shape, window_rect w,
                               int most)
{
    int64_t rows = 1 + (int64_t)(check_random_u64(r) % (uint64_t)most);
    int64_t cols = 1 + (int64_t)(check_random_u64(r) % (uint64_t)shape->cols);
    int64_t row = w.row0 + (int64_t)(check_random_u64(r) % (uint64_t)(shape->rows - rows + 1));
    int64_t col = w.col0 + (int64_t)(check_random_u64(r) % (uint64_t)(shape->cols - cols + 1));
    return (window_rect){row, row + rows, col, col + cols};
}

static double random_latitude(struct check_random *r)
{
    double pole = 1.5707963267948966;
    switch (check_random_u64(r) % 3) {
    case 0:
        return check_random_u64(r) & 1 ? pole : -pole;
    case 1:
        return (check_random_u64(r) & 1 ? 1 : -1) * (pole - pow(10, check_random_range(r, -7, 0)));
    default:
        return check_random_range(r, -pole, pole);
    }
}

typedef void checker(struct pyramid *p, const window_shape *shape, const window *w, window_rect r);

static void sweep(window_shape shape, int count, int most, checker *check)
{
    struct pyramid *p = fake_pyramid_create();
    struct check_random r = {2024};
    memset(ratios, 0, sizeof ratios);
    for (int n = 0; n < count; n++) {
        double lon = n % 3 ? check_random_range(&r, -3.2, 3.2) : 3.14159;
        window w = window_at(&shape, n % 22, random_latitude(&r), lon, 1.00336);
        check(p, &shape, &w, random_part(&r, &shape, w.rect, most));
        assert_int_equal(fake_pyramid_held(p), 0);
    }
    print_message("rows with finer, equal, coarser columns: %d, %d, %d\n", ratios[0], ratios[1],
                  ratios[2]);
    fake_pyramid_destroy(&p);
}

static void heights(void **state)
{
    (void)state;
    sweep(window_height_shape(256), 1000, 40, check_heights);
    assert_true(ratios[1] > 500 && ratios[2] > 500);
    sweep((window_shape){288, 64, 256}, 500, 40, check_heights);
    sweep((window_shape){288, 4096, 256}, 100, 8, check_heights);
    assert_true(ratios[0] > 100);
}

static void colors(void **state)
{
    (void)state;
    sweep(WINDOW_COLOR, 60, 6, check_colors);
    assert_true(ratios[2] > 50);
    sweep((window_shape){288, 2048, 256}, 60, 6, check_colors);
    assert_true(ratios[0] > 50);
}

// Windows wider than the ring needs: columns finer than the samples by up to 64.
static void wide_and_narrow_shares(void **state)
{
    (void)state;
    struct pyramid *p = fake_pyramid_create();
    window_shape shape = window_height_shape(256);
    memset(ratios, 0, sizeof ratios);
    for (int share = 0; share <= 6; share++)
        for (int64_t row = -16; row < 16384 + 16; row += 37) {
            int64_t col = (row * 7919) % (512 << share);
            window w = {.level = 7, .zoom = 6, .share = share};
            check_heights(p, &shape, &w, (window_rect){row, row + 3, col, col + 512});
        }
    assert_true(ratios[0] > 500 && ratios[1] > 500 && ratios[2] > 500);
    fake_pyramid_destroy(&p);
}

static void equal_steps_copy_colors(void **state)
{
    (void)state;
    struct pyramid *p = fake_pyramid_create();
    window_shape shape = {1056, 1024, 1024};
    window w = {.level = 2, .zoom = 1, .share = 0};
    uint8_t got[1024 * 4], want[4];
    assert_int_equal(
        clipmap_fill(p, LAYER_COLOR, &shape, &w, (window_rect){200, 201, 0, 1024}, got), OK);
    for (int j = 0; j < 1024; j++) {
        fake_color(1, 200, j, want);
        assert_memory_equal(got + 4 * j, want, 4);
    }
    fake_pyramid_destroy(&p);
}

static void refused_memory_is_passed_up(void **state)
{
    (void)state;
    struct pyramid *p = fake_pyramid_create();
    window_shape shape = window_height_shape(256);
    float *got = malloc((size_t)shape.rows * (size_t)shape.cols * sizeof *got);
    const double latitudes[] = {0.3, 1.03, 1.5707963267948966};
    for (int i = 0; i < 3; i++) {
        window w = window_at(&shape, 9, latitudes[i], 1, 1.00336);
        fake_pyramid_refuse(p, 0);
        int asked = fake_pyramid_asked(p);
        assert_int_equal(clipmap_fill(p, LAYER_HEIGHT, &shape, &w, w.rect, got), OK);
        asked = fake_pyramid_asked(p) - asked;
        assert_true(asked > 1);
        fake_pyramid_refuse(p, 1);
        assert_int_equal(clipmap_fill(p, LAYER_HEIGHT, &shape, &w, w.rect, got), ERR_MEMORY);
        assert_int_equal(fake_pyramid_held(p), 0);
    }
    free(got);
    fake_pyramid_destroy(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(heights),
        cmocka_unit_test(colors),
        cmocka_unit_test(wide_and_narrow_shares),
        cmocka_unit_test(equal_steps_copy_colors),
        cmocka_unit_test(refused_memory_is_passed_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
