// A fixed set of worker threads over one bounded first-in first-out queue.
#ifndef PERIGEE_BASE_POOL_H
#define PERIGEE_BASE_POOL_H

#include <stdbool.h>

struct pool;

// Runs on a worker; `worker` is its index in [0, threads), so that a job may use that worker's own
// handles.
typedef void (*pool_job)(void *arg, int worker);

// `threads` >= 1 (0: one for each processor), `capacity` >= 1 waiting jobs. Aborts when threads
// cannot be made.
struct pool *pool_create(int threads, int capacity);

// Waits for every job submitted, then joins the workers.
void pool_destroy(struct pool **pool);

int pool_threads(const struct pool *pool);

// Queues a job; false, and nothing done, when the queue is full. Any thread.
bool pool_try_submit(struct pool *pool, pool_job job, void *arg);

// Queues a job, waiting for room. Any thread but a worker of this pool.
void pool_submit(struct pool *pool, pool_job job, void *arg);

// Waits until no job is queued or running. Any thread but a worker of this pool.
void pool_drain(struct pool *pool);

#endif
