// How much a zoom adds to its parent, measured on the tiles of an import.
#include <math.h>
#include <pthread.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/pool.h"
#include "planet/import_bounded.h"
#include "planet/synthesis.h"
#include "planet/upsample.h"

enum { TILES_A_ZOOM = 64, BATCH = 16, SAMPLES = TILE_SIZE * TILE_SIZE };

struct tile_source {
    bounded_source file;
    bool (*kept)(void *user, tile_id id, float *heights);
    void *user;
};

// A tile and its parent, as workers read them.
struct pair {
    const struct tile_source *source;
    tile_id id;
    float *child, *parent;
    status result; // ERR_NOT_FOUND: there is no parent
};

// Sums are taken in the order of the tiles, while workers read the next ones.
struct measure {
    struct pool *pool;
    struct pair pairs[2 * BATCH];
    float *around, *relief;
    double radius, residual2, relief2;
};

// The samples around a child, from its parent alone: what the parent's neighbours would give is
// NaN, and so is not measured.
static region around_child(const struct measure *m, const struct pair *p, const region *child)
{
    tile_id parent = tile_parent(p->id);
    region r = region_parent(child);
    r.data = m->around;
    int64_t north = (int64_t)TILE_SIZE * parent.row, west = (int64_t)TILE_SIZE * parent.col;
    for (int y = 0; y < r.rows; y++)
        for (int x = 0; x < r.cols; x++) {
            int64_t row = r.row + y - north, col = r.col + x - west;
            bool here = row >= 0 && row < TILE_SIZE && col >= 0 && col < TILE_SIZE;
            r.data[y * r.stride + x] = here ? p->parent[row * TILE_SIZE + col] : NAN;
        }
    return r;
}

static void measure_pair(struct measure *m, const struct pair *p)
{
    region child = region_of_tile(p->id, 1, p->child), around = around_child(m, p, &child);
    synthesis_relief(&around, m->relief);
    synthesis_temper(&around, m->radius, m->relief);
    for (int row = 0; row < TILE_SIZE; row++) {
        float up[TILE_SIZE], relief[TILE_SIZE];
        bool flat[TILE_SIZE];
        upsample_child_row(&around, &child, row, up, flat);
        upsample_linear_row(&around, m->relief, &child, row, relief);
        for (int i = 0; i < TILE_SIZE; i++) {
            double residual = (double)p->child[row * TILE_SIZE + i] - (double)up[i];
            if (flat[i] || !isfinite(residual) || !isfinite(relief[i])) continue;
            m->residual2 += residual * residual;
            m->relief2 += (double)relief[i] * (double)relief[i];
        }
    }
}

static status read_tile(const struct tile_source *source, tile_id id, float *heights)
{
    if (source->kept && source->kept(source->user, id, heights)) return OK;
    return bounded_read(&source->file, id, heights);
}

static void read_pair(void *arg, int worker)
{
    (void)worker;
    struct pair *p = arg;
    p->result = read_tile(p->source, tile_parent(p->id), p->parent);
    if (p->result) return;
    status s = read_tile(p->source, p->id, p->child);
    p->result = s == ERR_NOT_FOUND ? ERR_FORMAT : s;
}

// Has a batch of the tiles read; how many there are.
static int submit(struct measure *m, struct pair *batch, const tile_id *ids, int count)
{
    int n = count < BATCH ? count : BATCH;
    for (int i = 0; i < n; i++) {
        batch[i].id = ids[i];
        pool_submit(m->pool, read_pair, &batch[i]);
    }
    return n;
}

static status measure_tiles(struct measure *m, const tile_id *ids, int count)
{
    status s = OK;
    struct pair *batch = m->pairs, *next = m->pairs + BATCH;
    for (int n = submit(m, batch, ids, count); !s && n;) {
        pool_drain(m->pool);
        ids += n;
        count -= n;
        int following = submit(m, next, ids, count);
        for (int i = 0; !s && i < n; i++) {
            if (!batch[i].result) measure_pair(m, &batch[i]);
            else if (batch[i].result != ERR_NOT_FOUND) s = batch[i].result;
        }
        struct pair *done = batch;
        batch = next;
        next = done;
        n = following;
    }
    pool_drain(m->pool);
    return s;
}

status planet_measure_gain(struct planet_writer *writer, double radius, int threads,
                           bool (*kept)(void *user, tile_id id, float *heights), void *user,
                           double *gain)
{
    *gain = 0.0;
    pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
    struct tile_source source = {{writer, &lock}, kept, user};
    struct measure m = {.radius = radius,
                        .pool = pool_create(threads, BATCH),
                        .around = NEW_ARRAY(float, SAMPLES * 2),
                        .relief = NEW_ARRAY(float, SAMPLES * 2)};
    float *samples = NEW_ARRAY(float, (size_t)4 * BATCH * SAMPLES);
    for (int i = 0; i < 2 * BATCH; i++) {
        float *child = samples + (size_t)2 * i * SAMPLES;
        m.pairs[i] = (struct pair){.source = &source, .child = child, .parent = child + SAMPLES};
    }
    tile_id ids[TILES_A_ZOOM];
    int zoom = planet_writer_max_zoom(writer, LAYER_HEIGHT);
    status s = OK;
    for (int k = 0; !s && k < 3 && zoom - k > 0; k++) {
        int count = 0;
        s = planet_writer_sample(writer, LAYER_HEIGHT, zoom - k, TILES_A_ZOOM, ids, &count);
        if (!s) s = measure_tiles(&m, ids, count);
    }
    pool_destroy(&m.pool);
    free(samples);
    free(m.around);
    free(m.relief);
    if (!s && m.relief2 > 0.0)
        *gain = clamp_double(sqrt(m.residual2 / m.relief2), SYNTHESIS_GAIN_MIN, SYNTHESIS_GAIN_MAX);
    return s;
}
