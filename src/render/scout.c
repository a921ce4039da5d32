// One question at a time. Invariant: while `busy`, `question` and `want` are the worker's; else the
// owner's. A question whose tiles are on their way is asked again when they have come, for the
// camera of that moment, so that a moving camera does not cancel and ask for them in every frame.
#include "render/scout.h"

#include <errno.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/clock.h"
#include "base/memory.h"

struct sight {
    geo_camera camera;
    double aspect;
    gaze gaze;
};

struct scout {
    struct pyramid *pyramid;
    struct pool *pool;
    struct want *want;
    struct sight question;
    struct sight known; // known.gaze.exact, or nothing is
    pthread_mutex_t lock;
    pthread_cond_t idle;
    bool busy; // under the lock
};

struct scout *scout_create(struct pyramid *pyramid, struct pool *pool)
{
    struct scout *s = NEW(struct scout);
    s->pyramid = pyramid;
    s->pool = pool;
    pthread_condattr_t monotonic;
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_mutex_init(&s->lock, NULL);
    pthread_cond_init(&s->idle, &monotonic);
    pthread_condattr_destroy(&monotonic);
    return s;
}

void scout_destroy(struct scout **scout)
{
    struct scout *s = *scout;
    if (!s) return;
    pthread_mutex_lock(&s->lock);
    while (s->busy) pthread_cond_wait(&s->idle, &s->lock);
    pthread_mutex_unlock(&s->lock);
    want_release(&s->want);
    pthread_cond_destroy(&s->idle);
    pthread_mutex_destroy(&s->lock);
    free(s);
    *scout = NULL;
}

static void work(void *arg, int worker)
{
    (void)worker;
    struct scout *s = arg;
    struct sight *q = &s->question;
    q->gaze = gaze_try(s->pyramid, &q->camera, q->aspect, s->want);
    pthread_mutex_lock(&s->lock);
    s->busy = false;
    pthread_cond_broadcast(&s->idle);
    pthread_mutex_unlock(&s->lock);
}

static bool is_of(const struct sight *s, const geo_camera *camera, double aspect)
{
    return s->gaze.exact && s->aspect == aspect && !memcmp(&s->camera, camera, sizeof *camera);
}

static bool is_busy(struct scout *s)
{
    pthread_mutex_lock(&s->lock);
    bool busy = s->busy;
    pthread_mutex_unlock(&s->lock);
    return busy;
}

static void ask(struct scout *s, const geo_camera *camera, double aspect)
{
    const double before_all = -1; // the whole frame depends on it
    if (s->want && !want_ready(s->want)) return;
    want_release(&s->want);
    s->want = want_create(before_all);
    s->question = (struct sight){.camera = *camera, .aspect = aspect};
    s->busy = true;
    if (!pool_try_submit(s->pool, work, s)) s->busy = false; // next time
}

gaze scout_look(struct scout *s, const geo_camera *camera, double aspect)
{
    bool busy = is_busy(s);
    if (!busy && is_of(&s->question, camera, aspect)) s->known = s->question;
    if (is_of(&s->known, camera, aspect)) return s->known.gaze;
    gaze guess = gaze_guess(s->pyramid, camera, aspect);
    if (guess.exact) s->known = (struct sight){*camera, aspect, guess};
    else if (!busy) ask(s, camera, aspect);
    return guess;
}

void scout_forget(struct scout *s)
{
    s->known.gaze.exact = false;
    if (!is_busy(s)) s->question.gaze.exact = false;
}

void scout_wait(struct scout *s, double timeout_s)
{
    double end = clock_now_s() + timeout_s;
    struct timespec t = {.tv_sec = (time_t)end};
    t.tv_nsec = (long)((end - (double)t.tv_sec) * 1e9);
    pthread_mutex_lock(&s->lock);
    while (s->busy && pthread_cond_timedwait(&s->idle, &s->lock, &t) != ETIMEDOUT) continue;
    bool busy = s->busy;
    pthread_mutex_unlock(&s->lock);
    if (!busy && s->want && !s->question.gaze.exact) want_wait(s->want, end - clock_now_s());
}
