#include "model.h"

#include "check.h"
#include "oracle.h"

void model_init(struct model *m, const clipmap_params *params, int threads, int pool_capacity)
{
    *m = (struct model){.params = *params};
    m->pyramid = fake_pyramid_create();
    m->pool = pool_create(threads, pool_capacity);
    assert_int_equal(clipmap_create(m->pyramid, m->pool, params, &m->clipmap), OK);
    for (int i = 0; i < params->levels; i++) {
        size_t count = (size_t)params->shape.rows * (size_t)params->shape.cols;
        m->texels[i] = calloc(count, sizeof(float));
        m->recast[i] = calloc(count, 1);
    }
}

void model_deinit(struct model *m)
{
    clipmap_destroy(&m->clipmap);
    assert_null(m->clipmap);
    assert_int_equal(fake_pyramid_held(m->pyramid), 0);
    pool_destroy(&m->pool);
    fake_pyramid_destroy(&m->pyramid);
    for (int i = 0; i < m->params.levels; i++) {
        free(m->texels[i]);
        free(m->recast[i]);
    }
}

static float *texel_row(const struct model *m, int level, int64_t row)
{
    const window_shape *s = &m->params.shape;
    return m->texels[level] + (size_t)window_texel(row, s->rows) * (size_t)s->cols;
}

static bool rects_equal(window_rect a, window_rect b)
{
    return a.row0 == b.row0 && a.row1 == b.row1 && a.col0 == b.col0 && a.col1 == b.col1;
}

static uint8_t *recast_row(const struct model *m, int level, int64_t row)
{
    const window_shape *s = &m->params.shape;
    return m->recast[level] + (size_t)window_texel(row, s->rows) * (size_t)s->cols;
}

static int64_t floor_div(int64_t a, int64_t b)
{
    return a / b - (a % b < 0);
}

// Of samples of the old width, by the words of clipmap_set_recast: the column `col` of the new.
static float recast_sample(const float *old, int cols, bool widens, int64_t col)
{
    if (widens)
        return 0.5f * (old[window_texel(2 * col, cols)] + old[window_texel(2 * col + 1, cols)]);
    int64_t at = floor_div(col, 2), east = col - 2 * at ? 1 : -1;
    return (-9 * old[window_texel(at - east, cols)] + 111 * old[window_texel(at, cols)] +
            29 * old[window_texel(at + east, cols)] - 3 * old[window_texel(at + 2 * east, cols)]) /
           128;
}

static void recast(void *user, const window *from, const window *to, window_rect valid)
{
    struct model *m = user;
    int cols = m->params.shape.cols;
    float old[8192];
    assert_int_equal(abs(from->share - to->share), 1);
    assert_true(rects_equal(window_rect_intersect(valid, to->rect), valid));
    for (int64_t row = valid.row0; row < valid.row1; row++) {
        float *texels = texel_row(m, to->level, row);
        uint8_t *marks = recast_row(m, to->level, row);
        memcpy(old, texels, (size_t)cols * sizeof *old);
        for (int64_t col = valid.col0; col < valid.col1; col++) {
            int at = window_texel(col, cols);
            texels[at] = recast_sample(old, cols, to->share < from->share, col);
            marks[at] = 1;
        }
    }
    m->recasts++;
}

void model_recast(struct model *m)
{
    clipmap_set_recast(m->clipmap, recast, m);
}

static void check_strip(const struct model *m, const clipmap_strip *s)
{
    const window_shape *shape = &m->params.shape;
    assert_true(s->rows > 0 && s->cols > 0);
    assert_int_equal(s->rows, s->rect.row1 - s->rect.row0);
    assert_int_equal(s->cols, s->rect.col1 - s->rect.col0);
    assert_int_equal(s->tex_row, window_texel(s->rect.row0, shape->rows));
    assert_int_equal(s->tex_col, window_texel(s->rect.col0, shape->cols));
    assert_true(s->tex_row + s->rows <= shape->rows && s->tex_col + s->cols <= shape->cols);
    assert_int_equal(s->bytes, (s->residuals ? 2 : 4) * s->rows * s->cols);
}

// What heights of a zoom are whole multiples of, by the words of clipmap/residual.h.
static double quantum_of(int zoom)
{
    return zoom < 15 ? 32 / (double)(1 << zoom) : 1.0 / 1024;
}

// Of four samples the one a quarter on from the second (after) or before the third, in quanta.
static int64_t between(const int64_t h[4], bool after)
{
    const int64_t *v = h;
    int64_t sum = after ? -9 * v[0] + 111 * v[1] + 29 * v[2] - 3 * v[3]
                        : -3 * v[0] + 29 * v[1] + 111 * v[2] - 9 * v[3];
    return floor_div(sum + 64, 128);
}

// Residuals and what the level before holds now make up the samples, bit by bit.
static void check_residuals(const struct model *m, const clipmap_strip *s)
{
    double quantum = quantum_of(s->window.zoom);
    const float *want = s->samples;
    const int16_t *residual = s->residuals;
    for (int64_t row = s->rect.row0; row < s->rect.row1; row++)
        for (int64_t col = s->rect.col0; col < s->rect.col1; col++) {
            bool south = row & 1, east = col & 1;
            int64_t first_row = floor_div(row, 2) + south - 2,
                    first_col = floor_div(col, 2) + east - 2, across[4];
            for (int k = 0; k < 4; k++) {
                int64_t h[4];
                for (int i = 0; i < 4; i++) {
                    float t =
                        texel_row(m, s->level - 1,
                                  first_row + i)[window_texel(first_col + k, m->params.shape.cols)];
                    assert_true(t == t); // not poisoned
                    h[i] = llrint((double)t / quantum);
                }
                across[k] = between(h, south);
            }
            double sum = (double)(between(across, east) + *residual++) * quantum;
            if (sum == (double)*want++) continue;
            print_error("level %d row %lld column %lld: the sum is %g\n", s->level, (long long)row,
                        (long long)col, sum);
            fail();
        }
}

bool model_take(struct model *m, size_t budget)
{
    clipmap_strip s;
    if (m->count == MODEL_PENDING || !clipmap_next_strip(m->clipmap, budget, &s)) return false;
    check_strip(m, &s);
    assert_true(s.bytes <= budget);
    if (s.residuals) check_residuals(m, &s);
    for (int64_t row = s.rect.row0; row < s.rect.row1 && !s.again; row++)
        memset(texel_row(m, s.level, row) + s.tex_col, 0xFF, (size_t)s.cols * sizeof(float));
    m->pending[(m->first + m->count++) % MODEL_PENDING] = s;
    return true;
}

bool model_upload(struct model *m)
{
    if (!m->count) return false;
    clipmap_strip s = m->pending[m->first];
    m->first = (m->first + 1) % MODEL_PENDING;
    m->count--;
    const float *from = s.samples;
    for (int64_t row = s.rect.row0; row < s.rect.row1; row++, from += s.cols) {
        memcpy(texel_row(m, s.level, row) + s.tex_col, from, (size_t)s.cols * sizeof(float));
        memset(recast_row(m, s.level, row) + s.tex_col, 0, (size_t)s.cols);
    }
    clipmap_uploaded(m->clipmap, &s);
    return true;
}

void model_finish(struct model *m)
{
    for (int i = 0; i < 30000 && !clipmap_complete(m->clipmap, NULL); i++) {
        clipmap_wait(m->clipmap, 0.001);
        while (model_take(m, SIZE_MAX)) continue;
        while (model_upload(m)) continue;
    }
    assert_true(clipmap_complete(m->clipmap, NULL));
}

static void check_height_row(const struct model *m, int level, const clipmap_level *s, int64_t row)
{
    int cols = m->params.shape.cols;
    float want[8192];
    const float *texels = texel_row(m, level, row);
    const uint8_t *marks = recast_row(m, level, row);
    double q = quantum_of(s->held.zoom);
    oracle_heights(cols, s->held.zoom, s->held.share, row, s->valid.col0, s->valid.col1, want);
    for (int64_t i = 0; m->params.residuals && i < s->valid.col1 - s->valid.col0; i++)
        want[i] = (float)(nearbyint((double)want[i] / q) * q);
    for (int64_t col = s->valid.col0; col < s->valid.col1; col++) {
        float got = texels[window_texel(col, cols)], w = want[col - s->valid.col0];
        bool recast = marks[window_texel(col, cols)] && !s->complete;
        if ((got == w || recast) && s->min <= got && got <= s->max) continue;
        print_error("level %d share %d row %lld column %lld: got %g, want %g, bounds %g .. %g\n",
                    level, s->held.share, (long long)row, (long long)col, (double)got, (double)w,
                    (double)s->min, (double)s->max);
        fail();
    }
}

static void check_color_row(const struct model *m, int level, const clipmap_level *s, int64_t row)
{
    int cols = m->params.shape.cols;
    double want[4096][4];
    const float *texels = texel_row(m, level, row);
    oracle_colors(cols, s->held.zoom, s->held.share, row, s->valid.col0, s->valid.col1, want);
    for (int64_t col = s->valid.col0; col < s->valid.col1; col++) {
        const uint8_t *got = (const uint8_t *)(texels + window_texel(col, cols));
        for (int c = 0; c < 4; c++) check_near(got[c], want[col - s->valid.col0][c], 0.65);
    }
}

static int64_t check_level(const struct model *m, int level)
{
    clipmap_level s = clipmap_level_state(m->clipmap, level);
    window_rect v = s.valid;
    bool same = s.held.share == s.window.share;
    bool whole = same && !window_rect_empty(v) && rects_equal(v, s.window.rect);
    assert_true(s.complete ? whole : !whole || m->recasts > 0);
    if (window_rect_empty(v)) {
        assert_true(s.min > s.max);
        return 0;
    }
    if (same) assert_true(rects_equal(window_rect_intersect(v, s.window.rect), v));
    assert_true(v.col1 - v.col0 <= m->params.shape.cols && v.row1 - v.row0 <= m->params.shape.rows);
    for (int64_t row = v.row0; row < v.row1; row++) {
        if (m->params.layer == LAYER_HEIGHT) check_height_row(m, level, &s, row);
        else check_color_row(m, level, &s, row);
    }
    return (v.row1 - v.row0) * (v.col1 - v.col0);
}

static int64_t check_levels(const struct model *m, int first, int step)
{
    int64_t samples = 0;
    for (int i = first; i < m->params.levels; i += step) samples += check_level(m, i);
    struct clipmap_counters c;
    clipmap_counters(m->clipmap, &c);
    size_t bound = m->params.staging_bytes ? m->params.staging_bytes : (size_t)32 << 20;
    assert_true(c.staging_bytes <= bound);
    assert_true(m->params.residuals || !c.residuals);
    return samples;
}

int64_t model_check(const struct model *m)
{
    return check_levels(m, 0, 1);
}

int64_t model_check_third(const struct model *m, int phase)
{
    return check_levels(m, phase % 3, 3);
}

uint64_t model_hash(const struct model *m, int last)
{
    uint64_t h = 14695981039346656037u;
    size_t bytes = (size_t)m->params.shape.rows * (size_t)m->params.shape.cols * sizeof(float);
    for (int i = 0; i <= last; i++)
        for (size_t b = 0; b < bytes; b++)
            h = (h ^ ((const unsigned char *)m->texels[i])[b]) * 1099511628211u;
    return h;
}
