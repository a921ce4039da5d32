// Invariant: `queued` jobs stand at jobs[head ...] modulo capacity, `busy` workers run one outside
// the lock.
#include "base/pool.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "base/memory.h"

struct entry {
    pool_job job;
    void *arg;
};

struct worker {
    struct pool *pool;
    pthread_t thread;
    int index;
};

struct pool {
    pthread_mutex_t lock;
    pthread_cond_t has_job, has_room, is_idle;
    struct entry *jobs;
    int capacity, head, queued, busy, threads;
    bool stopping;
    struct worker *workers;
};

static void *worker_main(void *arg)
{
    struct worker *w = arg;
    struct pool *p = w->pool;
    pthread_mutex_lock(&p->lock);
    for (;;) {
        while (!p->queued && !p->stopping) pthread_cond_wait(&p->has_job, &p->lock);
        if (!p->queued) break;
        struct entry e = p->jobs[p->head];
        p->head = (p->head + 1) % p->capacity;
        p->queued--;
        p->busy++;
        pthread_cond_signal(&p->has_room);
        pthread_mutex_unlock(&p->lock);
        e.job(e.arg, w->index);
        pthread_mutex_lock(&p->lock);
        p->busy--;
        if (!p->busy && !p->queued) pthread_cond_broadcast(&p->is_idle);
    }
    pthread_mutex_unlock(&p->lock);
    return NULL;
}

struct pool *pool_create(int threads, int capacity)
{
    if (threads <= 0) threads = (int)sysconf(_SC_NPROCESSORS_ONLN);
    if (threads < 1) threads = 1;
    struct pool *p = NEW(struct pool);
    pthread_mutex_init(&p->lock, NULL);
    pthread_cond_init(&p->has_job, NULL);
    pthread_cond_init(&p->has_room, NULL);
    pthread_cond_init(&p->is_idle, NULL);
    p->capacity = capacity < 1 ? 1 : capacity;
    p->jobs = NEW_ARRAY(struct entry, (size_t)p->capacity);
    p->threads = threads;
    p->workers = NEW_ARRAY(struct worker, (size_t)threads);
    for (int i = 0; i < threads; i++) {
        p->workers[i] = (struct worker){.pool = p, .index = i};
        if (!pthread_create(&p->workers[i].thread, NULL, worker_main, &p->workers[i])) continue;
        fprintf(stderr, "perigee: cannot start worker thread %d\n", i);
        abort();
    }
    return p;
}

void pool_destroy(struct pool **pool)
{
    struct pool *p = *pool;
    if (!p) return;
    pthread_mutex_lock(&p->lock);
    p->stopping = true;
    pthread_cond_broadcast(&p->has_job);
    pthread_mutex_unlock(&p->lock);
    for (int i = 0; i < p->threads; i++) pthread_join(p->workers[i].thread, NULL);
    pthread_cond_destroy(&p->has_job);
    pthread_cond_destroy(&p->has_room);
    pthread_cond_destroy(&p->is_idle);
    pthread_mutex_destroy(&p->lock);
    free(p->workers);
    free(p->jobs);
    free(p);
    *pool = NULL;
}

int pool_threads(const struct pool *pool)
{
    return pool->threads;
}

static void push(struct pool *p, pool_job job, void *arg)
{
    p->jobs[(p->head + p->queued) % p->capacity] = (struct entry){job, arg};
    p->queued++;
    pthread_cond_signal(&p->has_job);
}

bool pool_try_submit(struct pool *pool, pool_job job, void *arg)
{
    pthread_mutex_lock(&pool->lock);
    bool room = pool->queued < pool->capacity;
    if (room) push(pool, job, arg);
    pthread_mutex_unlock(&pool->lock);
    return room;
}

void pool_submit(struct pool *pool, pool_job job, void *arg)
{
    pthread_mutex_lock(&pool->lock);
    while (pool->queued == pool->capacity) pthread_cond_wait(&pool->has_room, &pool->lock);
    push(pool, job, arg);
    pthread_mutex_unlock(&pool->lock);
}

void pool_drain(struct pool *pool)
{
    pthread_mutex_lock(&pool->lock);
    while (pool->queued || pool->busy) pthread_cond_wait(&pool->is_idle, &pool->lock);
    pthread_mutex_unlock(&pool->lock);
}
