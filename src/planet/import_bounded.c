#include "planet/import_bounded.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/pool.h"
#include "planet/cache.h"
#include "planet/codec_bounded.h"
#include "planet/codec_predict.h"

// Decoded parents: those of a row of tiles of zoom 8 and its neighbours.
enum { SAMPLES = TILE_SIZE * TILE_SIZE, BATCH = 64, PARENT_BYTES = 160 << 20 };

// One tile of a batch.
struct job {
    struct bounder *bounder;
    planet_row row; // its body is the job's own
    bool keep;      // the body and the range as they are
    codec_blob coded;
    status result;
};

// Invariant: all jobs are of one zoom, and the writer holds every tile of coarser ones. `lock`
// guards the writer while workers run.
struct bounder {
    struct planet_writer *writer;
    double max_error;
    struct pool *pool;
    pthread_mutex_t lock;
    struct cache *parents;
    struct job jobs[BATCH];
    int count;
};

static status corrupt(tile_id id)
{
    log_error("tile height/%d/%d/%d: corrupt in the file being written", id.zoom, id.row, id.col);
    return ERR_FORMAT;
}

static status read_parent(void *user, tile_id id, float *heights)
{
    struct bounder *b = user;
    const pyramid_tile *tile;
    status s = cache_acquire(b->parents, NULL, id, &tile);
    if (s) return s;
    memcpy(heights, tile->heights, CACHE_SAMPLE_BYTES);
    cache_release(b->parents, &tile);
    return OK;
}

static status make_parent(void *user, struct want *want, tile_id id, void *samples,
                          struct cache_made *made)
{
    (void)want;
    (void)made;
    struct bounder *b = user;
    codec_blob body;
    float min, max;
    pthread_mutex_lock(&b->lock);
    status s = planet_writer_get(b->writer, id, &body, &min, &max);
    pthread_mutex_unlock(&b->lock);
    if (s) return s;
    s = codec_height_decode_tile(id, body.data, body.size, read_parent, b, samples);
    codec_blob_deinit(&body);
    return s == ERR_FORMAT ? corrupt(id) : s;
}

struct bounder *bounder_create(struct planet_writer *writer, double max_error, int threads)
{
    struct bounder *b = NEW(struct bounder);
    b->writer = writer;
    b->max_error = max_error;
    b->pool = pool_create(threads, BATCH);
    b->parents = cache_create(PARENT_BYTES, make_parent, b);
    pthread_mutex_init(&b->lock, NULL);
    return b;
}

static void clear(struct bounder *b)
{
    for (int i = 0; i < b->count; i++) {
        codec_blob_deinit(&b->jobs[i].row.body);
        codec_blob_deinit(&b->jobs[i].coded);
    }
    b->count = 0;
}

void bounder_destroy(struct bounder **bounder)
{
    struct bounder *b = *bounder;
    if (!b) return;
    clear(b);
    pool_destroy(&b->pool);
    cache_destroy(&b->parents);
    pthread_mutex_destroy(&b->lock);
    free(b);
    *bounder = NULL;
}

static status code(struct job *job, float *room)
{
    struct bounder *b = job->bounder;
    tile_id id = job->row.id;
    float *samples = room, *parent = room + SAMPLES, *predicted = room + 2 * SAMPLES;
    status s = codec_height_decode(job->row.body.data, job->row.body.size, samples);
    if (s) return s == ERR_FORMAT ? corrupt(id) : s;
    s = id.zoom > 0 ? read_parent(b, tile_parent(id), parent) : ERR_NOT_FOUND;
    if (s && s != ERR_NOT_FOUND) return s;
    predict_tile(id, s ? NULL : parent, predicted);
    return bounded_encode(samples, predicted, b->max_error, &job->coded, parent);
}

static void run_job(void *arg, int worker)
{
    (void)worker;
    struct job *job = arg;
    if (job->keep) return;
    float *room = malloc(3 * SAMPLES * sizeof *room);
    job->result = room ? code(job, room) : ERR_MEMORY;
    free(room);
}

status bounder_flush(struct bounder *b)
{
    for (int i = 0; i < b->count; i++) pool_submit(b->pool, run_job, &b->jobs[i]);
    pool_drain(b->pool);
    status s = OK;
    for (int i = 0; !s && i < b->count; i++) {
        const planet_row *row = &b->jobs[i].row;
        const bool keep = b->jobs[i].keep;
        const float wider = keep ? 0 : (float)(b->max_error * (1 + 1e-6));
        s = b->jobs[i].result;
        if (!s)
            s = planet_writer_put(b->writer, row->id, keep ? &row->body : &b->jobs[i].coded,
                                  row->min - wider, row->max + wider);
    }
    clear(b);
    return s;
}

static status add(struct bounder *b, const planet_row *row, bool keep)
{
    bool full = b->count == BATCH || (b->count && b->jobs[0].row.id.zoom != row->id.zoom);
    status s = full ? bounder_flush(b) : OK;
    if (s) return s;
    struct job *job = &b->jobs[b->count];
    *job = (struct job){.bounder = b, .row = *row, .keep = keep};
    job->row.body.data = malloc(row->body.size);
    if (!job->row.body.data) return ERR_MEMORY;
    memcpy(job->row.body.data, row->body.data, row->body.size);
    b->count++;
    return OK;
}

status bounder_put(struct bounder *b, const planet_row *row)
{
    return add(b, row, false);
}

status bounder_keep(struct bounder *b, const planet_row *row)
{
    return add(b, row, true);
}

static status read_chain(void *source, tile_id id, float *heights)
{
    return bounded_read(source, id, heights);
}

status bounded_read(const bounded_source *source, tile_id id, float *heights)
{
    bounded_source from = *source;
    codec_blob body;
    float min, max;
    if (from.lock) pthread_mutex_lock(from.lock);
    status s = planet_writer_get(from.writer, id, &body, &min, &max);
    if (from.lock) pthread_mutex_unlock(from.lock);
    if (s) return s;
    s = codec_height_decode_tile(id, body.data, body.size, read_chain, &from, heights);
    codec_blob_deinit(&body);
    return s == ERR_FORMAT ? corrupt(id) : s;
}
