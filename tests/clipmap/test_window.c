// Windows against brute force: points of the rings, carried from the sphere of reduced latitude to
// geodetic coordinates in long double, and the words of window.h.
#include "check.h"

#include "clipmap/window.h"

static const long double PI = 3.14159265358979323846264338327950288L;
static const double WGS84_RATIO = 6378137.0 / 6356752.314245179;

struct place {
    long double lat, lon;
};

// The point at angle t and azimuth az (from north to east) from the focus, all on the sphere of
// reduced latitude, as geodetic latitude and longitude offset.
static struct place ring_point(double lat, long double ratio, long double t, long double az)
{
    long double c = ratio * cosl(lat), s = sinl(lat), d = hypotl(c, s);
    long double cb = c / d, sb = s / d; // tan b = tan(lat) / ratio
    long double north = sinl(t) * cosl(az), east = sinl(t) * sinl(az), up = cosl(t);
    long double x = cb * up - sb * north, z = sb * up + cb * north;
    return (struct place){atan2l(ratio * z, hypotl(x, east)), atan2l(east, x)};
}

// Is the bilinear footprint of sample coordinates inside the window? Columns on any turn.
static bool footprint_inside(const window_shape *shape, const window *w, long double row,
                             long double col)
{
    if (floorl(row - 0.5L) < w->rect.row0 || floorl(row - 0.5L) + 1 >= w->rect.row1) return false;
    if (w->share == 0) return true;
    long double circle = ldexpl(shape->cols, w->share);
    long double off = fmodl(col - 0.5L - w->rect.col0, circle);
    if (off < 0) off += circle;
    return floorl(off) + 1 < shape->cols;
}

static void check_point(const window_shape *shape, const window *w, double lon, struct place p)
{
    long double rows = ldexpl(256, w->zoom), circle = ldexpl(shape->cols, w->share);
    long double row = (PI / 2 - p.lat) / PI * rows;
    long double col = (lon + p.lon + PI) / (2 * PI) * circle;
    if (!footprint_inside(shape, w, row, col)) {
        print_error("level %d share %d: place %.12Lg, %.12Lg has row %.6Lf, column %.6Lf\n",
                    w->level, w->share, p.lat, p.lon, row, col);
        fail();
    }
    double got_row, got_col;
    window_coordinates(shape, w, (double)p.lat, (double)(lon + p.lon), &got_row, &got_col);
    // The arguments are doubles: half an ulp of pi is 2.2e-16 of the circle.
    double tol = 8e-16 * (double)(rows + circle) + 1e-12;
    check_near(got_row, (double)row, tol);
    double turns = (got_col - (double)col) / (double)circle;
    check_near(turns - round(turns), 0, tol / (double)circle);
    assert_true(fabs(got_col - 0.5 * (double)(w->rect.col0 + w->rect.col1)) <=
                0.5 * (double)circle * (1 + 1e-12));
}

// Greatest longitude offset of the ring, by search over the azimuth, finer around the best so far.
static long double ring_half_span(double lat, double ratio, long double t)
{
    long double best = 0, best_az = PI / 2, step = PI / 128;
    for (int pass = 0; pass < 4; pass++, step /= 16) {
        long double middle = best_az;
        for (int i = -64; i <= 64; i++) {
            long double lon = ring_point(lat, ratio, t, middle + step * i).lon;
            if (lon > best) best = lon, best_az = middle + step * i;
        }
    }
    return best;
}

static bool ring_holds_pole(double lat, double ratio, long double t)
{
    return t >= atan2l((long double)ratio * cosl(lat), fabsl(sinl(lat)));
}

static void check_narrowest(const window_shape *shape, const window *w, double lat, double ratio)
{
    long double t = ldexpl(PI, -w->level);
    int margin = (shape->rows - shape->diameter_rows) / 2;
    if (margin > shape->diameter_rows / 16) margin = shape->diameter_rows / 16;
    if (w->level == 0 || ring_holds_pole(lat, ratio, t)) {
        assert_int_equal(w->share, 0);
        return;
    }
    long double half = ring_half_span(lat, ratio, t);
    for (int k = w->share; k <= w->share + 1 && k <= w->zoom; k++) {
        long double columns = half / (2 * PI) * ldexpl(shape->cols, k) + margin;
        // 1e-3 columns for the search over the azimuth.
        bool holds = columns <= shape->cols / 2 + (k == w->share ? 1e-3L : -1e-3L);
        if (k > 0 && holds != (k == w->share)) {
            print_error("level %d at %.9g: share %d, but of share %d %.6Lf columns are needed\n",
                        w->level, lat, w->share, k, columns);
            fail();
        }
    }
}

static void check_rect(const window_shape *shape, const window *w, double lat)
{
    int margin = (shape->rows - shape->diameter_rows) / 2;
    int64_t rows = (int64_t)256 << w->zoom;
    assert_int_equal(w->rect.row1 - w->rect.row0, shape->rows);
    assert_int_equal(w->rect.col1 - w->rect.col0, shape->cols);
    assert_true(w->rect.row0 >= -margin && w->rect.row1 <= rows + margin);
    if (w->share == 0) assert_int_equal(w->rect.col0, 0);
    // Where no pole is near the focus is within half a sample of the middle.
    double row = (1.5707963267948966 - lat) / window_step_lat(w);
    if (w->rect.row0 > -margin && w->rect.row1 < rows + margin)
        assert_true(fabs(row - (double)(w->rect.row0 + shape->rows / 2)) <= 0.5 + 1e-6);
}

static double random_latitude(struct check_random *r)
{
    double sign = check_random_u64(r) & 1 ? 1 : -1, pole = 1.5707963267948966;
    switch (check_random_u64(r) % 6) {
    case 0:
        return sign * pole;
    case 1:
        return sign * (pole - 1e-9);
    case 2:
        return sign * (pole - pow(10, check_random_range(r, -9, 0)));
    case 3:
        return sign * pow(10, check_random_range(r, -9, 0));
    default:
        return check_random_range(r, -pole, pole);
    }
}

static double random_longitude(struct check_random *r)
{
    double sign = check_random_u64(r) & 1 ? 1 : -1, half = 3.1415926535897931;
    switch (check_random_u64(r) % 4) {
    case 0:
        return sign * half;
    case 1:
        return sign * (half - pow(10, check_random_range(r, -12, 0)));
    default:
        return check_random_range(r, -half, half);
    }
}

static void sweep(window_shape shape, int levels, int foci, double ratio)
{
    struct check_random r = {0x9E3779B97F4A7C15u};
    for (int n = 0; n < foci; n++) {
        double lat = random_latitude(&r), lon = random_longitude(&r);
        for (int level = 0; level < levels; level++) {
            window w = window_at(&shape, level, lat, lon, ratio);
            assert_int_equal(w.level, level);
            assert_true(w.share >= 0 && w.share <= w.zoom);
            check_rect(&shape, &w, lat);
            if (n % 8 == 0) check_narrowest(&shape, &w, lat, ratio);
            long double t = ldexpl(PI, -level);
            for (int i = 0; i < 16; i++) {
                long double az = i < 4 ? i * PI / 2 : check_random_range(&r, 0, 6.2831853);
                long double radius = i < 12 ? t : t * check_random_range(&r, 0, 1);
                check_point(&shape, &w, lon, ring_point(lat, ratio, radius, az));
            }
        }
    }
}

static void rings_lie_inside_their_windows(void **state)
{
    (void)state;
    sweep(window_height_shape(256), 22, 2500, WGS84_RATIO);
    sweep(WINDOW_COLOR, 22, 500, WGS84_RATIO);
    sweep(window_height_shape(256), 22, 100, 1);
    sweep(window_height_shape(256), 22, 100, 1.1); // Saturn's
    sweep((window_shape){288, 64, 256}, 22, 100, WGS84_RATIO);
}

static void zooms_and_steps(void **state)
{
    (void)state;
    window_shape h = window_height_shape(256), c = WINDOW_COLOR;
    for (int level = 0; level < 22; level++) {
        window a = window_at(&h, level, 0, 0, 1), b = window_at(&c, level, 0, 0, 1);
        assert_int_equal(a.zoom, level ? level - 1 : 0);
        assert_int_equal(b.zoom, a.zoom + 2);
        check_near(window_step_lat(&a) * 256 * ldexp(1, a.zoom), (double)PI, 1e-15);
        check_near(window_step_lon(&h, &a) * h.cols * ldexp(1, a.share), 2 * (double)PI, 1e-15);
    }
    // At the equator a level's samples are as wide as high.
    window w = window_at(&h, 12, 0, 0, 1);
    check_near(window_step_lon(&h, &w) / window_step_lat(&w), 1, 1e-15);
}

// Northwards: on the way to each doubling the columns widen steadily, and are there when it comes;
// a window that is late with it stays so.
static void columns_widen_before_they_double(void **state)
{
    (void)state;
    const window_shape shape = WINDOW_COLOR;
    const double step = 1e-3, rad = (double)PI / 180;
    for (int level = 2; level < 16; level++) {
        int doublings = 0;
        for (double lat = 30; lat < 80; lat += step) {
            window w = window_at(&shape, level, lat * rad, 0, WGS84_RATIO),
                   next = window_at(&shape, level, (lat + step) * rad, 0, WGS84_RATIO);
            double here = window_widening(&shape, &w, lat * rad, WGS84_RATIO),
                   later = window_widening(&shape, &w, (lat + step) * rad, WGS84_RATIO);
            assert_true(here >= 0 && here <= later && later <= 1 && later - here < 0.05);
            if (w.share == 0) assert_true(later == 0);
            if (w.share == next.share) continue;
            doublings++;
            assert_true(later == 1);
            assert_true(window_widening(&shape, &next, (lat + step) * rad, WGS84_RATIO) == 0);
        }
        assert_true(doublings > 0);
    }
}

static bool same_window(const window *a, const window *b)
{
    return a->level == b->level && a->zoom == b->zoom && a->share == b->share &&
           memcmp(&a->rect, &b->rect, sizeof a->rect) == 0;
}

static void windows_are_functions_of_the_place(void **state)
{
    (void)state;
    struct check_random r = {77};
    window_shape shape = window_height_shape(256);
    for (int n = 0; n < 20000; n++) {
        double lat = random_latitude(&r), lon = random_longitude(&r);
        int level = (int)(check_random_u64(&r) % 22);
        window a = window_at(&shape, level, lat, lon, WGS84_RATIO);
        window b = window_at(&shape, level, lat, lon, WGS84_RATIO);
        assert_true(same_window(&a, &b));
    }
    for (int level = 0; level < 22; level++) {
        window a = window_at(&shape, level, 0.5, 3.1415926535897931, WGS84_RATIO);
        window b = window_at(&shape, level, 0.5, -3.1415926535897931, WGS84_RATIO);
        assert_true(same_window(&a, &b));
    }
}

static bool contains(window_rect r, int row, int col)
{
    return row >= r.row0 && row < r.row1 && col >= r.col0 && col < r.col1;
}

static void missing_is_the_difference(void **state)
{
    (void)state;
    struct check_random r = {5};
    for (int n = 0; n < 5000; n++) {
        window_rect t = {0, 1 + (int)(check_random_u64(&r) % 9), 0,
                         1 + (int)(check_random_u64(&r) % 9)};
        window_rect h = {(int)(check_random_u64(&r) % 9), (int)(check_random_u64(&r) % 9),
                         (int)(check_random_u64(&r) % 9), (int)(check_random_u64(&r) % 9)};
        h = window_rect_intersect(h, t);
        window_rect out[4];
        int count = window_rect_missing(t, h, out);
        assert_true(count >= 0 && count <= 4);
        for (int row = -1; row < 11; row++)
            for (int col = -1; col < 11; col++) {
                int times = 0;
                for (int i = 0; i < count; i++) times += contains(out[i], row, col);
                assert_int_equal(times, contains(t, row, col) && !contains(h, row, col));
            }
        bool rows_begun = false; // columns beside what is held come first
        for (int i = 0; i < count; i++) {
            assert_false(window_rect_empty(out[i]));
            bool beside = !window_rect_empty(h) && out[i].row0 == h.row0 && out[i].row1 == h.row1;
            assert_false(beside && rows_begun);
            rows_begun |= !beside;
        }
    }
}

static void turning_and_texels(void **state)
{
    (void)state;
    window_shape shape = {288, 64, 256};
    for (int share = 0; share < 4; share++)
        for (int off = -1000; off < 1000; off += 7) {
            int circle = 64 << share;
            window_rect near = {0, 9, off, off + 64}, rect = {3, 5, 11, 50};
            window_rect got = window_rect_turned(&shape, share, rect, near);
            assert_int_equal(got.row0, 3);
            assert_int_equal(got.row1, 5);
            assert_int_equal(got.col1 - got.col0, 39);
            assert_int_equal(window_texel(got.col0 - 11, circle), 0);
            assert_true(llabs(got.col0 + got.col1 - near.col0 - near.col1) <= circle + 2);
        }
    assert_int_equal(window_texel(-1, 288), 287);
    assert_int_equal(window_texel(-288, 288), 0);
    assert_int_equal(window_texel((int64_t)1 << 40, 64), 0);
}

static bool holds(window_rect r, int64_t circle, int64_t first, int64_t last)
{
    int64_t turn = (first - r.col0) / circle - ((first - r.col0) % circle < 0);
    return last - turn * circle < r.col1 || r.col1 - r.col0 == circle;
}

// A column of a window of another share is in the rectangle exactly when all that it is made of is.
static void recast_rectangles(void **state)
{
    (void)state;
    window_shape shape = {288, 64, 256};
    struct check_random r = {6};
    for (int n = 0; n < 3000; n++) {
        double lat = check_random_range(&r, -1.5, 1.5), lon = check_random_range(&r, -3.14, 3.14);
        window to = window_at(&shape, 6, lat, lon, 1.00336);
        int from = to.share + (check_random_u64(&r) % 2 ? 1 : -1);
        if (from < 0 || to.share == 0) continue;
        int64_t circle = (int64_t)64 << from, middle = (to.rect.col0 + to.rect.col1) / 2,
                at = (from > to.share ? 2 * middle : middle / 2) - 32 +
                     (int64_t)(check_random_u64(&r) % 40),
                width = from == 0 ? 64 : 20 + (int64_t)(check_random_u64(&r) % 45);
        window_rect old = {to.rect.row0 + 3, to.rect.row1 + 5, from == 0 ? 0 : at, 0};
        old.col1 = old.col0 + width;
        window_rect got = window_rect_recast(&shape, from, old, &to);
        assert_int_equal(got.row0, to.rect.row0 + 3);
        assert_int_equal(got.row1, to.rect.row1);
        for (int64_t col = to.rect.col0; col < to.rect.col1; col++) {
            int64_t half = col / 2 - (col % 2 < 0), first = half - 2 + (col & 1);
            bool made = from > to.share ? holds(old, circle, 2 * col, 2 * col + 1)
                                        : holds(old, circle, first, first + 3);
            assert_int_equal(contains(got, got.row0, col), made);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rings_lie_inside_their_windows),
        cmocka_unit_test(zooms_and_steps),
        cmocka_unit_test(columns_widen_before_they_double),
        cmocka_unit_test(windows_are_functions_of_the_place),
        cmocka_unit_test(missing_is_the_difference),
        cmocka_unit_test(turning_and_texels),
        cmocka_unit_test(recast_rectangles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
