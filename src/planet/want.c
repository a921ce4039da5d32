// Invariant: holders = 1 for the asker until it releases, and one for each share not given back;
// the last one frees.
#include "planet/want.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <time.h>

#include "base/clock.h"
#include "base/memory.h"

struct want {
    double priority;
    atomic_bool cancelled;
    atomic_int shares, holders;
    pthread_mutex_t lock;
    pthread_cond_t ready;
};

struct want *want_create(double priority)
{
    struct want *w = NEW(struct want);
    w->priority = priority;
    w->holders = 1;
    pthread_condattr_t monotonic;
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_mutex_init(&w->lock, NULL);
    pthread_cond_init(&w->ready, &monotonic);
    pthread_condattr_destroy(&monotonic);
    return w;
}

static void let_go(struct want *w)
{
    if (atomic_fetch_sub(&w->holders, 1) > 1) return;
    pthread_cond_destroy(&w->ready);
    pthread_mutex_destroy(&w->lock);
    free(w);
}

void want_cancel(struct want *w)
{
    atomic_store(&w->cancelled, true);
}

void want_release(struct want **want)
{
    if (!*want) return;
    want_cancel(*want);
    let_go(*want);
    *want = NULL;
}

bool want_ready(const struct want *w)
{
    return atomic_load(&w->shares) == 0;
}

bool want_wait(struct want *w, double timeout_s)
{
    double end = clock_now_s() + (timeout_s < 1e6 ? timeout_s : 1e6);
    struct timespec t = {.tv_sec = (time_t)end};
    t.tv_nsec = (long)((end - (double)t.tv_sec) * 1e9);
    pthread_mutex_lock(&w->lock);
    while (!want_ready(w) && clock_now_s() < end) pthread_cond_timedwait(&w->ready, &w->lock, &t);
    pthread_mutex_unlock(&w->lock);
    return want_ready(w);
}

struct want *want_take(struct want *w)
{
    atomic_fetch_add(&w->holders, 1);
    atomic_fetch_add(&w->shares, 1);
    return w;
}

bool want_cancelled(const struct want *w)
{
    return atomic_load(&w->cancelled);
}

double want_priority(const struct want *w)
{
    return w->priority;
}

void want_give_back(struct want **want)
{
    struct want *w = *want;
    pthread_mutex_lock(&w->lock);
    if (atomic_fetch_sub(&w->shares, 1) == 1) pthread_cond_broadcast(&w->ready);
    pthread_mutex_unlock(&w->lock);
    let_go(w);
    *want = NULL;
}
