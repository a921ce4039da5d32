// The strips in work: a fixed set of blocks, each from being queued until its samples were
// uploaded. Workers take the coarsest level first, and among one level the earliest. Inside the
// clipmap room. All functions: the owner's thread.
#ifndef PERIGEE_CLIPMAP_JOBS_H
#define PERIGEE_CLIPMAP_JOBS_H

#include "clipmap/bounds.h"
#include "clipmap/clipmap.h"

struct clip_jobs;

enum clip_job_state {
    CLIP_JOB_FREE,
    CLIP_JOB_QUEUED,
    CLIP_JOB_RUNNING, // on a worker
    CLIP_JOB_DROPPED, // on a worker, unwanted: freed when the worker returns
    CLIP_JOB_FAILED,  // memory was refused: waits for clip_jobs_retry
    CLIP_JOB_WAITING, // its tiles are on their way: waits for clip_jobs_wake
    CLIP_JOB_BLOCKED, // of a derived window: the level before does not hold enough: see
                      // clip_jobs_unblock
    CLIP_JOB_READY,   // samples, or the derived rectangle, may be handed out
    CLIP_JOB_ORPHAN,  // unwanted, but some of its rows are in the caller's hands
};

struct clip_job {
    enum clip_job_state state; // under the lock of the set
    uint64_t order;
    uint64_t frame;    // in which it was asked for
    struct want *want; // NULL when free
    window window;
    window_rect rect;
    void *samples;
    double until_s;       // clock_now_s until which the samples stand
    clip_range *ranges;   // heights: of the blocks (bounds.h) in which the rectangle has a part
    int16_t *residuals;   // room for them; NULL: not wanted
    float *parents;       // and for what they are found with
    bool has_residuals;   // of all rows
    int handed, uploaded; // rows; the owner's alone
};

struct clip_jobs_params {
    struct pyramid *pyramid;
    struct pool *pool;
    enum tile_layer layer;
    window_shape shape;
    size_t staging_bytes;
    bool residuals; // heights are rounded, and their residuals found where that can be
};

status clip_jobs_create(const struct clip_jobs_params *params, struct clip_jobs **out);
void clip_jobs_destroy(struct clip_jobs **jobs); // drops what is queued, waits for what is running

// Rows of a strip at most.
int clip_jobs_max_rows(const struct clip_jobs *jobs);

// Queues the filling of a rectangle that does not wrap in the texture; false when no block is free.
// priority: of what it needs from the sources, see want.h. frame: kept in the job.
bool clip_jobs_add(struct clip_jobs *jobs, const window *w, window_rect rect, double priority,
                   uint64_t frame);

// Strips of derived windows no worker makes: they are ready while `may` says so.
void clip_jobs_unblock(struct clip_jobs *jobs, bool (*may)(void *user, const struct clip_job *job),
                       void *user);

// Sees to it that workers are on their way to the queued strips.
void clip_jobs_start(struct clip_jobs *jobs);

// The strip to hand out next: ready, with rows not yet handed out; NULL when there is none.
struct clip_job *clip_jobs_ready(struct clip_jobs *jobs);

// The job in whose block `samples` lies.
struct clip_job *clip_jobs_of_samples(struct clip_jobs *jobs, const void *samples);

void clip_jobs_release(struct clip_jobs *jobs, struct clip_job *job);

// Drops the level's strips that have no sample in `keep`. Returns how many.
int clip_jobs_drop(struct clip_jobs *jobs, int level, window_rect keep);

// Queues again what failed.
void clip_jobs_retry(struct clip_jobs *jobs);

// Queues again what waited for tiles that have come. Returns how many still wait.
int clip_jobs_wake(struct clip_jobs *jobs);

size_t clip_jobs_bytes(struct clip_jobs *jobs);

enum clip_wait { CLIP_WAIT_READY, CLIP_WAIT_CHANGED, CLIP_WAIT_IDLE, CLIP_WAIT_TIMEOUT };

// Waits until a strip is ready, a worker has finished anything, nothing is in work, or the time is
// `deadline_s`.
enum clip_wait clip_jobs_wait(struct clip_jobs *jobs, double deadline_s);

// The clock of clip_jobs_wait, s.
double clip_jobs_clock(void);

#endif
