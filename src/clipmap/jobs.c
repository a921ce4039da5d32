// Invariant, under the lock: unfinished = jobs queued, running or dropped; runners = tasks in the
// pool, waiting or running, never more than the pool's threads. Fields other than `state` change
// hands with it: the worker's while running or dropped, else the owner's.
#include "clipmap/jobs.h"

#include <assert.h>
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <time.h>

#include "base/clock.h"
#include "base/memory.h"
#include "clipmap/residual.h"

enum { MAX_STRIP_ROWS = CLIPMAP_MAX_ROWS, MIN_BLOCKS = 8, MAX_BLOCKS = 256 };

struct clip_jobs {
    struct clip_jobs_params params;
    int max_rows, count;
    size_t block_bytes, block_ranges, block_parents;
    unsigned char *samples;
    clip_range *ranges;
    int16_t *residuals;
    float *parents;
    struct clip_job *job;
    uint64_t next_order;
    pthread_mutex_t lock;
    pthread_cond_t changed;
    int runners, unfinished;
};

// Blocks of 64 rows as many as the bound allows, of fewer rows where it is tight.
static void choose_blocks(struct clip_jobs *j)
{
    size_t row_bytes = 4 * (size_t)j->params.shape.cols, bound = j->params.staging_bytes;
    j->max_rows = MAX_STRIP_ROWS;
    while (j->max_rows > 1 && bound / (row_bytes * (size_t)j->max_rows) < MIN_BLOCKS)
        j->max_rows /= 2;
    j->block_bytes = row_bytes * (size_t)j->max_rows;
    j->block_parents = (size_t)(j->max_rows / 2 + 4) * (size_t)(j->params.shape.cols / 2 + 4);
    size_t aside = j->params.residuals ? j->block_bytes / 2 + 4 * j->block_parents : 0;
    size_t count = bound / (j->block_bytes + aside);
    j->count = count > MAX_BLOCKS ? MAX_BLOCKS : count < 1 ? 1 : (int)count;
    j->block_ranges = (size_t)j->max_rows * (size_t)(j->params.shape.cols / CLIP_CELL);
}

status clip_jobs_create(const struct clip_jobs_params *params, struct clip_jobs **out)
{
    struct clip_jobs *j = NEW(struct clip_jobs);
    j->params = *params;
    choose_blocks(j);
    size_t ranges = params->layer == LAYER_HEIGHT ? j->block_ranges : 0;
    j->job = NEW_ARRAY(struct clip_job, (size_t)j->count);
    pthread_condattr_t monotonic;
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_mutex_init(&j->lock, NULL);
    pthread_cond_init(&j->changed, &monotonic);
    pthread_condattr_destroy(&monotonic);
    j->samples = calloc((size_t)j->count, j->block_bytes);
    if (ranges) j->ranges = calloc((size_t)j->count * ranges, sizeof *j->ranges);
    bool residuals = params->residuals && params->layer == LAYER_HEIGHT;
    if (residuals) {
        j->residuals = calloc((size_t)j->count, j->block_bytes / 2);
        j->parents = calloc((size_t)j->count * j->block_parents, sizeof *j->parents);
    }
    *out = j;
    if (!j->samples || (ranges && !j->ranges) || (residuals && (!j->residuals || !j->parents))) {
        clip_jobs_destroy(out);
        return ERR_MEMORY;
    }
    for (int i = 0; i < j->count; i++) {
        j->job[i].samples = j->samples + (size_t)i * j->block_bytes;
        if (ranges) j->job[i].ranges = j->ranges + (size_t)i * ranges;
        if (!residuals) continue;
        j->job[i].residuals = j->residuals + (size_t)i * (j->block_bytes / 4);
        j->job[i].parents = j->parents + (size_t)i * j->block_parents;
    }
    return OK;
}

void clip_jobs_destroy(struct clip_jobs **jobs)
{
    struct clip_jobs *j = *jobs;
    if (!j) return;
    pthread_mutex_lock(&j->lock);
    for (int i = 0; i < j->count; i++)
        if (j->job[i].state == CLIP_JOB_QUEUED) j->job[i].state = CLIP_JOB_FREE;
    for (int i = 0; j->job && i < j->count; i++)
        if (j->job[i].want) want_cancel(j->job[i].want);
    while (j->runners) pthread_cond_wait(&j->changed, &j->lock);
    for (int i = 0; j->job && i < j->count; i++) want_release(&j->job[i].want);
    pthread_mutex_unlock(&j->lock);
    pthread_cond_destroy(&j->changed);
    pthread_mutex_destroy(&j->lock);
    free(j->samples);
    free(j->ranges);
    free(j->residuals);
    free(j->parents);
    free(j->job);
    free(j);
    *jobs = NULL;
}

int clip_jobs_max_rows(const struct clip_jobs *j)
{
    return j->max_rows;
}

static bool goes_before(const struct clip_job *a, const struct clip_job *b)
{
    if (a->window.level != b->window.level) return a->window.level < b->window.level;
    return a->order < b->order;
}

static struct clip_job *first_queued(struct clip_jobs *j)
{
    struct clip_job *best = NULL;
    for (int i = 0; i < j->count; i++) {
        struct clip_job *job = &j->job[i];
        if (job->state == CLIP_JOB_QUEUED && (!best || goes_before(job, best))) best = job;
    }
    return best;
}

static void set_free(struct clip_job *job)
{
    want_release(&job->want);
    job->state = CLIP_JOB_FREE;
}

// Rounds the samples, and finds their residuals where the level before can have columns twice as
// wide, nothing stands in for its samples, and 16 bits are enough.
static void find_residuals(const struct clip_jobs *j, struct clip_job *job)
{
    const struct clip_jobs_params *p = &j->params;
    const window *w = &job->window;
    window_rect around = window_rect_parents(job->rect);
    size_t rows = (size_t)(around.row1 - around.row0), cols = (size_t)(around.col1 - around.col0),
           count = (size_t)(job->rect.row1 - job->rect.row0) *
                   (size_t)(job->rect.col1 - job->rect.col0);
    double until_s;
    clip_residual_round(w->zoom, job->samples, count);
    job->has_residuals = false;
    if (w->zoom == 0 || w->share == 0) return;
    const window coarser = {.level = w->level - 1, .zoom = w->zoom - 1, .share = w->share - 1};
    if (clipmap_try_fill(p->pyramid, p->layer, &p->shape, &coarser, around, job->want, job->parents,
                         &until_s) ||
        until_s != (double)INFINITY)
        return;
    clip_residual_round(coarser.zoom, job->parents, rows * cols);
    job->has_residuals =
        clip_residual_find(w->zoom, job->rect, job->samples, job->parents, job->residuals);
}

// Ranges of a block in which the rectangle has but a part, `cells` blocks in a row of it.
static status find_block(const struct clip_jobs *j, struct clip_job *job, int64_t col0,
                         clip_range *first, int cells)
{
    const struct clip_jobs_params *p = &j->params;
    float samples[CLIPMAP_MAX_ROWS * CLIP_CELL];
    clip_range ranges[CLIPMAP_MAX_ROWS];
    window_rect r = {job->rect.row0, job->rect.row1, col0, col0 + CLIP_CELL};
    int rows = (int)(r.row1 - r.row0);
    double until_s;
    status s = clipmap_try_fill(p->pyramid, p->layer, &p->shape, &job->window, r, job->want,
                                samples, &until_s);
    if (s) return s;
    job->until_s = fmin(job->until_s, until_s);
    if (job->residuals) clip_residual_round(job->window.zoom, samples, (size_t)rows * CLIP_CELL);
    clip_bounds_reduce(samples, rows, 0, CLIP_CELL, ranges);
    for (int i = 0; i < rows; i++) first[i * cells] = ranges[i];
    return OK;
}

static status find_ranges(const struct clip_jobs *j, struct clip_job *job)
{
    window_rect r = job->rect;
    int cols = (int)(r.col1 - r.col0), tex_col = window_texel(r.col0, j->params.shape.cols),
        cells = clip_bounds_cells(tex_col, cols), end = (tex_col + cols) % CLIP_CELL;
    clip_bounds_reduce(job->samples, (int)(r.row1 - r.row0), tex_col, cols, job->ranges);
    status s = OK;
    if (tex_col % CLIP_CELL)
        s = find_block(j, job, r.col0 - tex_col % CLIP_CELL, job->ranges, cells);
    if (!s && end && (cells > 1 || tex_col % CLIP_CELL == 0))
        s = find_block(j, job, r.col1 - end, job->ranges + cells - 1, cells);
    return s;
}

// Without the lock.
static status fill(const struct clip_jobs *j, struct clip_job *job)
{
    const struct clip_jobs_params *p = &j->params;
    window_rect r = job->rect;
    status s = clipmap_try_fill(p->pyramid, p->layer, &p->shape, &job->window, r, job->want,
                                job->samples, &job->until_s);
    if (!s && job->residuals) find_residuals(j, job);
    if (!s && job->ranges) s = find_ranges(j, job);
    return s;
}

static void run_one(struct clip_jobs *j, struct clip_job *job)
{
    job->state = CLIP_JOB_RUNNING;
    pthread_mutex_unlock(&j->lock);
    status s = fill(j, job);
    pthread_mutex_lock(&j->lock);
    if (job->state == CLIP_JOB_DROPPED) set_free(job);
    else if (s == ERR_PENDING) job->state = CLIP_JOB_WAITING;
    else job->state = s ? CLIP_JOB_FAILED : CLIP_JOB_READY;
    j->unfinished--;
    pthread_cond_broadcast(&j->changed);
}

// One strip, then to the back of the queue: the pool is shared.
static void run(void *arg, int worker)
{
    (void)worker;
    struct clip_jobs *j = arg;
    pthread_mutex_lock(&j->lock);
    for (struct clip_job *job; (job = first_queued(j));) {
        run_one(j, job);
        if (!first_queued(j) || !pool_try_submit(j->params.pool, run, j)) continue;
        pthread_mutex_unlock(&j->lock);
        return;
    }
    j->runners--;
    pthread_cond_broadcast(&j->changed);
    pthread_mutex_unlock(&j->lock);
}

void clip_jobs_start(struct clip_jobs *j)
{
    int threads = pool_threads(j->params.pool);
    pthread_mutex_lock(&j->lock);
    while (j->runners < threads && j->runners < j->unfinished &&
           pool_try_submit(j->params.pool, run, j))
        j->runners++;
    pthread_mutex_unlock(&j->lock);
}

bool clip_jobs_add(struct clip_jobs *j, const window *w, window_rect rect, double priority,
                   uint64_t frame)
{
    pthread_mutex_lock(&j->lock);
    struct clip_job *job = NULL;
    for (int i = 0; i < j->count && !job; i++)
        if (j->job[i].state == CLIP_JOB_FREE) job = &j->job[i];
    if (job) {
        job->state = w->derived ? CLIP_JOB_BLOCKED : CLIP_JOB_QUEUED;
        job->order = j->next_order++;
        job->frame = frame;
        job->want = want_create(priority);
        job->window = *w;
        job->rect = rect;
        job->handed = job->uploaded = 0;
        job->until_s = INFINITY;
        j->unfinished += !w->derived;
    }
    pthread_mutex_unlock(&j->lock);
    return job != NULL;
}

void clip_jobs_unblock(struct clip_jobs *j, bool (*may)(void *user, const struct clip_job *job),
                       void *user)
{
    pthread_mutex_lock(&j->lock);
    for (int i = 0; i < j->count; i++) {
        struct clip_job *job = &j->job[i];
        if (job->window.derived && (job->state == CLIP_JOB_BLOCKED || job->state == CLIP_JOB_READY))
            job->state = may(user, job) ? CLIP_JOB_READY : CLIP_JOB_BLOCKED;
    }
    pthread_mutex_unlock(&j->lock);
}

static bool is_ready(const struct clip_job *job)
{
    return job->state == CLIP_JOB_READY && job->handed < job->rect.row1 - job->rect.row0;
}

struct clip_job *clip_jobs_ready(struct clip_jobs *j)
{
    struct clip_job *best = NULL;
    pthread_mutex_lock(&j->lock);
    for (int i = 0; i < j->count; i++) {
        struct clip_job *job = &j->job[i];
        if (is_ready(job) && (!best || goes_before(job, best))) best = job;
    }
    pthread_mutex_unlock(&j->lock);
    return best;
}

struct clip_job *clip_jobs_of_samples(struct clip_jobs *j, const void *samples)
{
    size_t offset = (size_t)((const unsigned char *)samples - j->samples);
    assert(offset < (size_t)j->count * j->block_bytes);
    return &j->job[offset / j->block_bytes];
}

void clip_jobs_release(struct clip_jobs *j, struct clip_job *job)
{
    pthread_mutex_lock(&j->lock);
    set_free(job);
    pthread_mutex_unlock(&j->lock);
}

static void drop(struct clip_jobs *j, struct clip_job *job)
{
    switch (job->state) {
    case CLIP_JOB_QUEUED:
        set_free(job);
        j->unfinished--;
        break;
    case CLIP_JOB_RUNNING:
        want_cancel(job->want);
        job->state = CLIP_JOB_DROPPED;
        break;
    case CLIP_JOB_READY:
    case CLIP_JOB_BLOCKED:
        if (job->uploaded < job->handed) job->state = CLIP_JOB_ORPHAN;
        else set_free(job);
        break;
    default:
        set_free(job);
    }
}

int clip_jobs_drop(struct clip_jobs *j, int level, window_rect keep)
{
    int count = 0;
    pthread_mutex_lock(&j->lock);
    for (int i = 0; i < j->count; i++) {
        struct clip_job *job = &j->job[i];
        if (job->state == CLIP_JOB_FREE || job->state == CLIP_JOB_DROPPED ||
            job->state == CLIP_JOB_ORPHAN || job->window.level != level ||
            !window_rect_empty(window_rect_intersect(job->rect, keep)))
            continue;
        drop(j, job);
        count++;
    }
    pthread_mutex_unlock(&j->lock);
    return count;
}

void clip_jobs_retry(struct clip_jobs *j)
{
    pthread_mutex_lock(&j->lock);
    for (int i = 0; i < j->count; i++) {
        if (j->job[i].state != CLIP_JOB_FAILED) continue;
        j->job[i].state = CLIP_JOB_QUEUED;
        j->unfinished++;
    }
    pthread_mutex_unlock(&j->lock);
}

int clip_jobs_wake(struct clip_jobs *j)
{
    int waiting = 0;
    pthread_mutex_lock(&j->lock);
    for (int i = 0; i < j->count; i++) {
        struct clip_job *job = &j->job[i];
        if (job->state != CLIP_JOB_WAITING) continue;
        if (want_ready(job->want)) {
            job->state = CLIP_JOB_QUEUED;
            j->unfinished++;
        } else waiting++;
    }
    pthread_mutex_unlock(&j->lock);
    return waiting;
}

size_t clip_jobs_bytes(struct clip_jobs *j)
{
    size_t samples = 0;
    pthread_mutex_lock(&j->lock);
    for (int i = 0; i < j->count; i++) {
        window_rect r = j->job[i].rect;
        if (j->job[i].state != CLIP_JOB_FREE)
            samples += (size_t)(r.row1 - r.row0) * (size_t)(r.col1 - r.col0);
    }
    pthread_mutex_unlock(&j->lock);
    return 4 * samples;
}

double clip_jobs_clock(void)
{
    return clock_now_s();
}

static bool any_held_up(const struct clip_jobs *j)
{
    for (int i = 0; i < j->count; i++)
        if (j->job[i].state == CLIP_JOB_WAITING || j->job[i].state == CLIP_JOB_BLOCKED) return true;
    return false;
}

static enum clip_wait look(const struct clip_jobs *j)
{
    bool failed = false;
    for (int i = 0; i < j->count; i++) {
        if (is_ready(&j->job[i])) return CLIP_WAIT_READY;
        failed |= j->job[i].state == CLIP_JOB_FAILED;
    }
    return j->unfinished || failed || any_held_up(j) ? CLIP_WAIT_TIMEOUT : CLIP_WAIT_IDLE;
}

enum clip_wait clip_jobs_wait(struct clip_jobs *j, double deadline_s)
{
    const double retry_s = 1e-3; // when the pool had no room for a runner
    const double wake_s = 4e-3;  // when tiles may come
    pthread_mutex_lock(&j->lock);
    enum clip_wait result = look(j);
    double now = clip_jobs_clock();
    if (result == CLIP_WAIT_TIMEOUT && now < deadline_s) {
        if (j->unfinished && !j->runners) deadline_s = fmin(deadline_s, now + retry_s);
        else if (any_held_up(j)) deadline_s = fmin(deadline_s, now + wake_s);
        struct timespec t = {.tv_sec = (time_t)deadline_s};
        t.tv_nsec = (long)((deadline_s - (double)t.tv_sec) * 1e9);
        pthread_cond_timedwait(&j->changed, &j->lock, &t);
        result = CLIP_WAIT_CHANGED;
    }
    pthread_mutex_unlock(&j->lock);
    return result;
}
