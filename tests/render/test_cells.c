// Culling is conservative: whatever terrain point is in the frustum and not behind the planet, its
// cell is visible.
#include "check.h"

#include "render/cells.h"
#include "render/projection.h"

static const ring_params RINGS = {.azimuth_steps = 1024, .rings_per_level = 40, .levels = 22};

// Does the segment from the camera to a point enter the ellipsoid lowered by 500 m? In scaled
// space, by sampling.
static bool hidden(dvec3 camera, dvec3 to_point, double a, double b)
{
    for (int i = 1; i < 200; i++) {
        dvec3 p = dvec3_mad(camera, to_point, i / 200.0);
        double x = p.x / (a - 500), y = p.y / (a - 500), z = p.z / (b - 500);
        if (x * x + y * y + z * z < 1) return true;
    }
    return false;
}

static dvec3 point_on_cell(const projection *p, double angle, double azimuth, double height)
{
    double n = sin(angle) * cos(azimuth), e = sin(angle) * sin(azimuth), c = cos(angle);
    double x = p->focus.cb * c - p->focus.sb * n, z = p->focus.sb * c + p->focus.cb * n;
    double a = p->ellipsoid.a, b = p->ellipsoid.b;
    double len = sqrt(x * x / a / a + e * e / a / a + z * z / b / b);
    dvec3 s = {a * x + height * x / a / len, a * e + height * e / a / len,
               b * z + height * z / b / len};
    return s;
}

static bool in_frustum(const projection *p, dvec3 d)
{
    dvec3 eye = dmat3_mul(p->eye_from_meridian, d);
    double t = tan(p->camera.fov_y / 2), aspect = (double)p->width / p->height;
    return eye.z < 0 && fabs(eye.x) <= -eye.z * t * aspect && fabs(eye.y) <= -eye.z * t;
}

static bool visible(const cell_view *v, int cell, int last, double low, double high)
{
    cell_band band = cell_band_of(&RINGS, v, cell, last, low, high);
    return cell_band_visible(v, &band, cell_sector(cell));
}

static void one_camera(struct check_random *r, int *seen)
{
    double high = check_random_range(r, 0, 1) < 0.5 ? check_random_range(r, 2, 9000)
                                                    : pow(10, check_random_range(r, 3, 8));
    geo_camera c = {.position = {check_random_range(r, -M_PI / 2, M_PI / 2),
                                 check_random_range(r, -M_PI, M_PI), high},
                    .heading = check_random_range(r, 0, 2 * M_PI),
                    .pitch = check_random_range(r, -M_PI / 2, 0.3),
                    .roll = check_random_range(r, -1, 1),
                    .fov_y = check_random_range(r, 0.05, 2)};
    projection p = projection_make(GEO_WGS84, &c, c.position.lat, c.position.lon, 1280, 960);
    cell_view v = projection_cell_view(&p, -430, 8849);
    int last = projection_last_level(&p, high, 256, RINGS.levels);
    for (int i = 0; i < 4000; i++) {
        double level = check_random_range(r, 0, last + 1.0);
        double angle = ring_angle(&RINGS, level * RINGS.rings_per_level),
               azimuth = check_random_range(r, 0, 2 * M_PI);
        bool fill = i % 8 == 0;
        if (fill)
            angle = ring_angle(&RINGS, (last + 1) * RINGS.rings_per_level) *
                    check_random_range(r, 0, 1);
        double height = check_random_range(r, -400, 8849);
        dvec3 d = dvec3_sub(point_on_cell(&p, angle, azimuth, height), v.camera);
        if (!in_frustum(&p, d) || hidden(v.camera, d, p.ellipsoid.a, p.ellipsoid.b)) continue;
        int sector = (int)(azimuth / (2 * M_PI) * CELL_SECTORS),
            band = (int)(fmod(level, 1) * CELL_BANDS);
        int cell = fill ? cell_fill_index(&RINGS, sector) : cell_index((int)level, band, sector);
        (*seen)++;
        if (!visible(&v, cell, last, -400, 8849))
            fail_msg("lat %g lon %g alt %g: level %g azimuth %g height %g is seen but culled",
                     c.position.lat, c.position.lon, high, level, azimuth, height);
    }
}

static void test_culling_is_conservative(void **state)
{
    (void)state;
    struct check_random r = {2024};
    int seen = 0;
    for (int i = 0; i < 400; i++) one_camera(&r, &seen);
    print_message("%d visible points\n", seen);
    assert_true(seen > 20000);
}

// A telephoto from over a place of a level planet that lies as far as can be from the points by
// which its cell is bounded: on the cell's outer arc between two of them, looking down; and with
// only the near ground in sight, looking level along an arc from the focus.
static projection telephoto_of(const projection *over, dvec3 place, double height, double heading,
                               double pitch, double fov_y)
{
    double a = over->ellipsoid.a, b = over->ellipsoid.b;
    geo_camera c = {.position = {atan2(a * a / (b * b) * place.z, hypot(place.x, place.y)),
                                 over->focus.lon + atan2(place.y, place.x), height},
                    .heading = heading,
                    .pitch = pitch,
                    .fov_y = fov_y};
    return projection_make(over->ellipsoid, &c, over->camera.position.lat,
                           over->camera.position.lon, 1280, 960);
}

static void look_at_arc(struct check_random *r, int level, bool down)
{
    const int sector = (int)check_random_range(r, 0, CELL_SECTORS),
              band = (int)check_random_range(r, 0, CELL_BANDS);
    const double rows = (double)RINGS.rings_per_level / CELL_BANDS;
    geo_camera c = {.position = {check_random_range(r, -M_PI / 2, M_PI / 2),
                                 check_random_range(r, -M_PI, M_PI), 1000},
                    .fov_y = 1};
    projection over = projection_make(GEO_WGS84, &c, c.position.lat, c.position.lon, 1280, 960);
    int ring = level * RINGS.rings_per_level;
    double outer = ring_angle(&RINGS, ring + band * rows),
           inner = ring_angle(&RINGS, ring + (band + 1) * rows);
    double angle = down ? outer - 1e-3 * (outer - inner) : outer - 0.25 * (outer - inner),
           azimuth = (sector + (down ? 0.25 : 0.5)) * 2 * M_PI / CELL_SECTORS;
    dvec3 place = point_on_cell(&over, angle, azimuth, 0);
    double far = GEO_WGS84.a * (outer - inner);
    projection p = down ? telephoto_of(&over, place, 1e-3 * far, check_random_range(r, 0, 2 * M_PI),
                                       -M_PI / 2, 0.2)
                        : telephoto_of(&over, place, 1e-5 * far, check_random_range(r, 0, 2 * M_PI),
                                       -0.01, 0.015);
    cell_view v = projection_cell_view(&p, 0, 0);
    if (!visible(&v, cell_index(level, band, sector), RINGS.levels - 1, 0, 0))
        fail_msg("level %d band %d sector %d: its arc is seen %s but culled", level, band, sector,
                 down ? "from above" : "along the ground");
}

static void test_arcs_are_not_culled(void **state)
{
    (void)state;
    struct check_random r = {7};
    for (int level = 1; level < RINGS.levels; level++)
        for (int i = 0; i < 100; i++) look_at_arc(&r, level, i % 2);
}

static void test_culling_culls(void **state)
{
    (void)state;
    geo_camera c = {.position = {0.8, 0.2, 1000}, .pitch = 0, .fov_y = 1};
    projection p = projection_make(GEO_WGS84, &c, c.position.lat, c.position.lon, 1280, 960);
    cell_view v = projection_cell_view(&p, -430, 4800);
    int drawn = 0, last = 20;
    for (int level = 0; level <= last; level++)
        for (int k = 0; k < CELL_BANDS * CELL_SECTORS; k++)
            drawn +=
                visible(&v, cell_index(level, k / CELL_SECTORS, k % CELL_SECTORS), last, 0, 4800);
    print_message("%d of %d cells drawn\n", drawn, (last + 1) * CELL_BANDS * CELL_SECTORS);
    assert_true(drawn > 50 && drawn < (last + 1) * CELL_BANDS * CELL_SECTORS / 3);
}

// Every vertex row and column belongs to a cell, neighbours share their border, the two halves do
// not share columns.
static void test_cells_cover_the_rings(void **state)
{
    (void)state;
    int columns = ring_columns(&RINGS), rows = ring_count(&RINGS) + CELL_FILL_RINGS + 1;
    unsigned char *owner = calloc((size_t)columns * (size_t)rows, 1);
    uint64_t quads = 0;
    for (int cell = 0; cell < cell_count(&RINGS); cell++) {
        cell_span s = cell_vertices(&RINGS, cell);
        assert_true(s.row + s.rows <= (uint32_t)rows && s.column + s.columns <= (uint32_t)columns);
        uint32_t seam = (uint32_t)RINGS.azimuth_steps / 2;
        assert_true(s.column + s.columns - 1 <= seam || s.column > seam);
        for (uint32_t y = 0; y < s.rows; y++)
            for (uint32_t x = 0; x < s.columns; x++)
                owner[(s.row + y) * (uint32_t)columns + s.column + x]++;
        quads += (uint64_t)(s.rows - 1) * (s.columns - 1);
    }
    for (int i = 0; i < columns * rows; i++) assert_true(owner[i] >= 1 && owner[i] <= 4);
    assert_int_equal(quads, 1024ull * (40 * 22 + CELL_FILL_RINGS));
    free(owner);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_culling_is_conservative),
        cmocka_unit_test(test_arcs_are_not_culled),
        cmocka_unit_test(test_culling_culls),
        cmocka_unit_test(test_cells_cover_the_rings),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
