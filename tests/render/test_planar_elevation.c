// The elevation maps computed on the GPU against the CPU's own from the same windows: in float, the
// same bits (the shader's sums are `precise`, so that no driver may reorder or fuse them); in
// double, by longitudes and latitudes, within units in the last place. The coarser height is that
// of the coarser level's triangle, by barycentric coordinates.
#include "render/scene.h"

#include "render/planar_parts.h"
#include "render/view.h"

enum { N = 255, T = N + 1, LEVELS = 24 };

struct maps {
    struct levels_block block;
    window held[LEVELS];
    window_shape shape;
    float *heights;              // of all windows
    float (*elevation)[T][T][2]; // level, row, column; own and coarser height
    const struct planar *planar;
    int sampled_last;
};

static float texel(const struct maps *m, int level, int row, int column)
{
    const float *torus = m->block.height_torus[level];
    int tr = row + (int)torus[0], tc = (column + (int)torus[1]) & (m->shape.cols - 1);
    tr = tr >= m->shape.rows ? tr - m->shape.rows : tr < 0 ? tr + m->shape.rows : tr;
    return m->heights[((size_t)level * (size_t)m->shape.rows + (size_t)tr) * (size_t)m->shape.cols +
                      (size_t)tc];
}

// As the shader's window_height, operation by operation.
static float height_float(const struct maps *m, int level, float row, float column)
{
    float r0 = floorf(row), c0 = floorf(column), fr = row - r0 - 0.5f, fc = column - c0 - 0.5f;
    int r = (int)r0, c = (int)c0, dr = fr < 0 ? -1 : 1, dc = fc < 0 ? -1 : 1;
    fr = fabsf(fr);
    fc = fabsf(fc);
    float h = texel(m, level, r, c), h_row = texel(m, level, r + dr, c),
          h_col = texel(m, level, r, c + dc), h_both = texel(m, level, r + dr, c + dc);
    float d_row = h_row - h, d_col = h_col - h;
    return h + (fr * d_row + fc * (d_col + fr * (h_both - h_col - d_row)));
}

// By how many units in the last place of a float of this size two heights differ.
static double units(double a, double b, double size)
{
    return fabs(a - b) / ldexp(1, ilogb(size) - 23);
}

// And the largest of the samples that it is made of.
static double height_double(const struct maps *m, int level, double row, double column,
                            double *largest)
{
    double r = row - 0.5, c = column - 0.5, r0 = floor(r), c0 = floor(c), fr = r - r0, fc = c - c0;
    int i = (int)r0, k = (int)c0;
    double nw = (double)texel(m, level, i, k), ne = (double)texel(m, level, i, k + 1),
           sw = (double)texel(m, level, i + 1, k), se = (double)texel(m, level, i + 1, k + 1);
    *largest = fmax(fmax(fabs(nw), fabs(ne)), fmax(fabs(sw), fabs(se)));
    return (1 - fr) * ((1 - fc) * nw + fc * ne) + fr * ((1 - fc) * sw + fc * se);
}

static bool whole_weight(const struct maps *m, int level, double row, double column)
{
    const float *v = m->block.height_valid[level];
    return row - (double)v[0] >= 5 && (double)v[1] - row >= 5 && column - (double)v[2] >= 5 &&
           (double)v[3] - column >= 5 && m->block.height_torus[level][2] == 1;
}

// Where a vertex lies in its window, by its longitude and latitude.
static void place(const struct maps *m, const nest_square *s, int level, int i, int k, double *row,
                  double *column)
{
    double lat = M_PI / 2 - (double)(s->row + i) * s->step,
           lon = (double)(s->column + k) * s->step - M_PI;
    window_coordinates(&m->shape, &m->held[level], lat, lon, row, column);
    *row = round(4 * (*row - (double)m->held[level].rect.row0)) / 4; // exact, as the steps are
    *column = round(4 * (*column - (double)m->held[level].rect.col0)) / 4;
}

static void read_maps(perigee_view *view, struct maps *m)
{
    *m = (struct maps){.planar = (const struct planar *)view->geometry,
                       .shape = windows_height_samples(view->windows),
                       .sampled_last = windows_last_height(view->windows)};
    windows_fill_block(view->windows, &m->block);
    size_t samples = (size_t)m->shape.rows * (size_t)m->shape.cols;
    m->heights = calloc(samples * LEVELS, sizeof(float));
    m->elevation = calloc(LEVELS, sizeof *m->elevation);
    assert_non_null(m->heights);
    assert_non_null(m->elevation);
    for (int i = 0; i <= m->sampled_last; i++) {
        m->held[i] = windows_held(view->windows, i);
        glGetTextureSubImage(windows_heights(view->windows), 0, 0, 0, i, m->shape.cols,
                             m->shape.rows, 1, GL_RED, GL_FLOAT, (GLsizei)(samples * sizeof(float)),
                             m->heights + (size_t)i * samples);
    }
    glGetTextureImage(planar_elevation_texture(m->planar->elevation), 0, GL_RG, GL_FLOAT,
                      (GLsizei)(LEVELS * sizeof *m->elevation), m->elevation);
}

struct tally {
    int vertices, same_bits;
    double off_double, off_coarser; // units in the last place: of the largest sample; of itself
};

static void check_level(const struct maps *m, int level, struct tally *t)
{
    const struct planar *p = m->planar;
    const nest_square *s = &p->square[level];
    int sampled = level < m->sampled_last ? level : m->sampled_last;
    for (int i = 0; i < N; i++) {
        if (fabs(nest_latitude(s, i)) >= M_PI / 2) continue; // at a pole all is one point
        for (int k = 0; k < N; k++) {
            double row, column;
            place(m, s, sampled, i, k, &row, &column);
            if (!whole_weight(m, sampled, row, column)) continue;
            const float *got = m->elevation[level][i][k];
            float want = height_float(m, sampled, (float)row, (float)column);
            t->vertices++;
            t->same_bits += memcmp(got, &want, sizeof want) == 0;
            double largest, exact = height_double(m, sampled, row, column, &largest);
            t->off_double = fmax(t->off_double, units((double)got[0], exact, largest));
            if (level == p->first) continue;
            // On the coarser level's triangles, whose diagonals run from north-west to south-east.
            const nest_square *c = &p->square[level - 1];
            double r = (double)(s->row + i) / 2 - (double)c->row,
                   q = (double)(s->column + k) / 2 - (double)c->column, fr = r - floor(r),
                   fq = q - floor(q);
            int r0 = (int)floor(r), q0 = (int)floor(q);
            const float(*e)[T][2] = m->elevation[level - 1];
            double nw = e[r0][q0][0], ne = e[r0][q0 + 1][0], sw = e[r0 + 1][q0][0],
                   se = e[r0 + 1][q0 + 1][0];
            double h = fq >= fr ? nw + fq * (ne - nw) + fr * (se - ne)
                                : nw + fr * (sw - nw) + fq * (se - sw);
            t->off_coarser = fmax(t->off_coarser, units((double)got[1], h, h));
        }
    }
}

static void test_cpu_and_gpu_agree(void **state)
{
    (void)state;
    perigee_planet *planet = scene_planet();
    perigee_view_params params = {.mode = PERIGEE_MODE_PLANAR, .texels = 256, .planar_n = N};
    perigee_view *view = scene_view(planet, &params);
    // At 65 N the windows' columns are twice as wide as the square's.
    static const double places[][3] = {{12, 34, 900}, {-47, 179.999, 2e4}, {65, -20, 3e5}};
    for (int i = 0; i < 3; i++) {
        perigee_camera c = {.lat_deg = places[i][0], .lon_deg = places[i][1], .fov_deg = 60};
        c.alt_m = places[i][2] + analytic_height(c.lat_deg * M_PI / 180, c.lon_deg * M_PI / 180);
        struct maps m;
        struct tally t = {0};
        scene_render(view, &c, 64, 64);
        read_maps(view, &m);
        for (int level = m.planar->first; level <= m.planar->last; level++)
            check_level(&m, level, &t);
        print_message("%g, %g: levels %d to %d, %d vertices, %d with the same bits; of double "
                      "within %.3f units in the last place; coarser within %.3f\n",
                      c.lat_deg, c.lon_deg, m.planar->first, m.planar->last, t.vertices,
                      t.same_bits, t.off_double, t.off_coarser);
        assert_true(t.vertices > 200000);
        assert_int_equal(t.same_bits, t.vertices);
        assert_true(t.off_double <= 1);
        assert_true(t.off_coarser <= 0.5);
        free(m.heights);
        free(m.elevation);
    }
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_cpu_and_gpu_agree)};
    int rc = scene_open();
    return rc ? rc : scene_close(cmocka_run_group_tests(tests, NULL, NULL));
}
