// The footprints tile a level: every quad once, none twice, whatever trim; and culling never takes
// what can be seen.
#include "check.h"

#include "render/planar_cull.h"
#include "render/planar_pieces.h"

enum { MOST = 1023 };

static uint8_t covered[MOST + 2][MOST + 2][2]; // triangles of each quad

struct corner {
    int row, column;
};

static struct corner corner_of(const planar_pieces *p, const planar_footprint *f, uint32_t i,
                               const int offset[2])
{
    uint32_t v = f->first_vertex + p->indices[f->first_index + i];
    assert_true(p->indices[f->first_index + i] < f->vertices);
    return (struct corner){p->vertices[2 * v] + offset[0], p->vertices[2 * v + 1] + offset[1]};
}

// Half a quad each: counter-clockwise from above, rows southward, the last corner the quad's first.
static void cover(const planar_pieces *p, int piece, int row, int column)
{
    const planar_footprint *f = &p->piece[piece];
    const int offset[2] = {row, column};
    assert_true(f->vertices <= 65536 && f->indices % 3 == 0);
    for (uint32_t i = 0; i < f->indices; i += 3) {
        struct corner a = corner_of(p, f, i, offset), b = corner_of(p, f, i + 1, offset),
                      c = corner_of(p, f, i + 2, offset);
        int area =
            (b.column - a.column) * (a.row - c.row) - (c.column - a.column) * (a.row - b.row);
        assert_int_equal(area, 1); // twice the area
        assert_true(a.row - c.row >= 0 && a.row - c.row <= 1 && b.row - c.row >= 0 &&
                    b.row - c.row <= 1 && a.column - c.column >= 0 && a.column - c.column <= 1 &&
                    b.column - c.column >= 0 && b.column - c.column <= 1);
        int upper = a.row - c.row == 1 && b.row - c.row == 0;
        covered[c.row][c.column][upper]++;
    }
}

static void cover_ring(const planar_pieces *p, int n, int blocks)
{
    memset(covered, 0, sizeof covered);
    for (int k = 0; k < blocks; k++) {
        int at[2];
        planar_block_offset(n, k, at);
        cover(p, PLANAR_BLOCK, at[0], at[1]);
    }
    cover(p, PLANAR_FIXUP, 0, 0);
}

// Quads outside the hole exactly once, in it not at all.
static void check_cover(int n, int first_row, int first_column, int side)
{
    for (int r = 0; r < n; r++) {
        for (int c = 0; c < n; c++) {
            bool inside = r < n - 1 && c < n - 1;
            bool hole = r >= first_row && r < first_row + side && c >= first_column &&
                        c < first_column + side;
            assert_int_equal(covered[r][c][0], inside && !hole);
            assert_int_equal(covered[r][c][1], inside && !hole);
        }
    }
}

static void test_quads_are_covered_once(void **state)
{
    (void)state;
    for (int n = 31; n <= MOST; n = 2 * n + 1) {
        planar_pieces p = planar_pieces_make(n);
        int m = (n + 1) / 4;
        assert_int_equal(p.piece[PLANAR_BLOCK].vertices, m * m);
        for (int trim = 0; trim < 4; trim++) {
            cover_ring(&p, n, PLANAR_RING_BLOCKS);
            cover(&p, PLANAR_TRIM + trim, 0, 0);
            // The finer square: 2 m - 1 quads, from m - 1 where the last row or column is free.
            check_cover(n, trim >> 1 ? m - 1 : m, trim & 1 ? m - 1 : m, 2 * m - 1);
        }
        cover_ring(&p, n, PLANAR_BLOCKS);
        cover(&p, PLANAR_CROSS, 0, 0);
        check_cover(n, 0, 0, 0);
        planar_pieces_free(&p);
    }
}

// Every second vertex of the border is the middle of one triangle between its neighbours.
static void test_border_triangles(void **state)
{
    (void)state;
    enum { N = 63 };
    static int middle[N][N];
    memset(middle, 0, sizeof middle);
    planar_pieces p = planar_pieces_make(N);
    const planar_footprint *f = &p.piece[PLANAR_BORDER];
    const int none[2] = {0, 0};
    assert_int_equal(f->indices, 3 * 4 * (N - 1) / 2);
    for (uint32_t i = 0; i < f->indices; i += 3) {
        struct corner a = corner_of(&p, f, i, none), b = corner_of(&p, f, i + 1, none),
                      c = corner_of(&p, f, i + 2, none);
        assert_true(a.row % 2 == 0 && a.column % 2 == 0 && b.row % 2 == 0 && b.column % 2 == 0);
        assert_int_equal(a.row + b.row, 2 * c.row);
        assert_int_equal(a.column + b.column, 2 * c.column);
        middle[c.row][c.column]++;
    }
    for (int r = 0; r < N; r++)
        for (int c = 0; c < N; c++) {
            bool border = r == 0 || c == 0 || r == N - 1 || c == N - 1;
            assert_int_equal(middle[r][c], border && (r + c) % 2 == 1);
        }
    // The circle's last two columns.
    f = &p.piece[PLANAR_CLOSING];
    assert_int_equal(f->indices, 6 * 2 * (N - 1));
    planar_pieces_free(&p);
}

static map_rect random_rect(struct check_random *r)
{
    double size = pow(10, check_random_range(r, -4, 0));
    double south = check_random_range(r, -M_PI / 2, M_PI / 2),
           west = check_random_range(r, -M_PI, M_PI);
    return (map_rect){south, fmin(M_PI / 2, south + size), west, west + size};
}

static void test_angle_to_a_rectangle(void **state)
{
    (void)state;
    enum { STEPS = 60 };
    struct check_random r = {2};
    double worst = 0;
    for (int i = 0; i < 3000; i++) {
        map_rect rect = random_rect(&r);
        double b0 = check_random_range(&r, -1.5, 1.5), least = 4;
        for (int j = 0; j <= STEPS; j++) {
            for (int k = 0; k <= STEPS; k++) {
                double lat = rect.south + (rect.north - rect.south) * j / STEPS,
                       lon = rect.west + (rect.east - rect.west) * k / STEPS;
                double b = geo_reduced_from_geodetic(GEO_WGS84, lat);
                double c = sin(b0) * sin(b) + cos(b0) * cos(b) * cos(lon);
                least = fmin(least, acos(fmax(-1, fmin(1, c))));
            }
        }
        double got = map_rect_angle(GEO_WGS84, cos(b0), sin(b0), rect);
        double step = fmax(rect.north - rect.south, rect.east - rect.west) / STEPS;
        assert_true(got <= least + 1e-7);
        worst = fmax(worst, (least - got) / step);
    }
    print_message("below the least of a fine grid by at most %.2f of its steps\n", worst);
    assert_true(worst <= 1);
}

static dvec3 random_direction(struct check_random *r)
{
    return dvec3_normalize(dvec3_make(check_random_range(r, -1, 1), check_random_range(r, -1, 1),
                                      check_random_range(r, -1, 1)));
}

// Narrow frustums around points of the terrain in a rectangle: it is visible. Where the arcs
// between the points that stand for a rectangle bulge, nothing but the sagitta tells.
static void test_culling_keeps_what_is_seen(void **state)
{
    (void)state;
    struct check_random r = {6};
    int culled = 0;
    for (int i = 0; i < 60000; i++) {
        double lat = check_random_range(&r, -1.5, 1.5),
               height = pow(10, check_random_range(&r, 2, 7)), low = -500, high = 3000;
        double b = geo_reduced_from_geodetic(GEO_WGS84, lat);
        cell_view v = {.ellipsoid = GEO_WGS84, .cb = cos(b), .sb = sin(b), .horizon = M_PI};
        v.camera = geo_ecef_from_geodetic(GEO_WGS84, (geodetic){lat, 0, height});
        map_rect rect = random_rect(&r), other = random_rect(&r);
        dvec3 p = geo_ecef_from_geodetic(GEO_WGS84,
                                         (geodetic){check_random_range(&r, rect.south, rect.north),
                                                    check_random_range(&r, rect.west, rect.east),
                                                    check_random_range(&r, low, high)});
        dvec3 to = dvec3_normalize(dvec3_sub(p, v.camera));
        for (int k = 0; k < 5; k++) {
            dvec3 axis = random_direction(&r);
            axis = dvec3_normalize(dvec3_mad(axis, to, -dvec3_dot(axis, to)));
            v.plane[k] = dvec3_normalize(dvec3_mad(axis, to, 1e-5));
        }
        assert_true(map_rect_visible(&v, rect, low, high));
        culled += !map_rect_visible(&v, other, low, high);
    }
    print_message("60000 rectangles seen and kept, %d of as many others culled\n", culled);
    assert_true(culled > 30000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_quads_are_covered_once),
        cmocka_unit_test(test_border_triangles),
        cmocka_unit_test(test_angle_to_a_rectangle),
        cmocka_unit_test(test_culling_keeps_what_is_seen),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
