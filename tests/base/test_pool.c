#include "check.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>

#include "base/pool.h"

static atomic_int done, wrong_worker;

static void count(void *arg, int worker)
{
    int threads = *(int *)arg;
    if (worker < 0 || worker >= threads) atomic_fetch_add(&wrong_worker, 1);
    atomic_fetch_add(&done, 1);
}

static void all_jobs_run(void **state)
{
    (void)state;
    for (int threads = 1; threads <= 8; threads *= 2) {
        atomic_store(&done, 0);
        struct pool *p = pool_create(threads, 7);
        assert_int_equal(pool_threads(p), threads);
        for (int i = 0; i < 2000; i++) pool_submit(p, count, &threads);
        pool_drain(p);
        assert_int_equal(atomic_load(&done), 2000);
        for (int i = 0; i < 5; i++) pool_submit(p, count, &threads);
        pool_destroy(&p);
        assert_null(p);
        assert_int_equal(atomic_load(&done), 2005);
    }
    assert_int_equal(atomic_load(&wrong_worker), 0);
}

// A gate that holds workers until it is opened, and tells how many stand before it.
struct gate {
    pthread_mutex_t lock;
    pthread_cond_t changed;
    int waiting;
    bool open;
};

static void wait_at_gate(void *arg, int worker)
{
    (void)worker;
    struct gate *g = arg;
    pthread_mutex_lock(&g->lock);
    g->waiting++;
    pthread_cond_broadcast(&g->changed);
    while (!g->open) pthread_cond_wait(&g->changed, &g->lock);
    pthread_mutex_unlock(&g->lock);
    atomic_fetch_add(&done, 1);
}

static void gate_await(struct gate *g, int count_waiting)
{
    pthread_mutex_lock(&g->lock);
    while (g->waiting < count_waiting) pthread_cond_wait(&g->changed, &g->lock);
    pthread_mutex_unlock(&g->lock);
}

static void gate_open(struct gate *g)
{
    pthread_mutex_lock(&g->lock);
    g->open = true;
    pthread_cond_broadcast(&g->changed);
    pthread_mutex_unlock(&g->lock);
}

// Two workers busy, three jobs waiting: full.
static void try_submit_is_bounded(void **state)
{
    (void)state;
    struct gate g = {PTHREAD_MUTEX_INITIALIZER, PTHREAD_COND_INITIALIZER, 0, false};
    atomic_store(&done, 0);
    struct pool *p = pool_create(2, 3);
    for (int i = 0; i < 2; i++) assert_true(pool_try_submit(p, wait_at_gate, &g));
    gate_await(&g, 2);
    for (int i = 0; i < 3; i++) assert_true(pool_try_submit(p, wait_at_gate, &g));
    for (int i = 0; i < 10; i++) assert_false(pool_try_submit(p, wait_at_gate, &g));
    assert_int_equal(atomic_load(&done), 0);
    gate_open(&g);
    pool_drain(p);
    assert_int_equal(atomic_load(&done), 5);
    assert_true(pool_try_submit(p, wait_at_gate, &g));
    pool_destroy(&p);
    assert_int_equal(atomic_load(&done), 6);
}

struct submitter {
    struct pool *pool;
    struct gate *gate;
    atomic_bool returned;
};

static void *submit_one(void *arg)
{
    struct submitter *s = arg;
    pool_submit(s->pool, wait_at_gate, s->gate);
    atomic_store(&s->returned, true);
    return NULL;
}

static void submit_waits_for_room(void **state)
{
    (void)state;
    struct gate g = {PTHREAD_MUTEX_INITIALIZER, PTHREAD_COND_INITIALIZER, 0, false};
    atomic_store(&done, 0);
    struct pool *p = pool_create(1, 1);
    pool_submit(p, wait_at_gate, &g);
    gate_await(&g, 1);
    pool_submit(p, wait_at_gate, &g);
    struct submitter s = {.pool = p, .gate = &g};
    pthread_t thread;
    assert_int_equal(pthread_create(&thread, NULL, submit_one, &s), 0);
    for (int i = 0; i < 1000; i++) sched_yield();
    assert_false(atomic_load(&s.returned));
    gate_open(&g);
    pthread_join(thread, NULL);
    assert_true(atomic_load(&s.returned));
    pool_drain(p);
    assert_int_equal(atomic_load(&done), 3);
    pool_destroy(&p);
}

// First in, first out with one worker.
static int order[100];
static int order_count;

static void note_order(void *arg, int worker)
{
    (void)worker;
    order[order_count++] = *(int *)arg;
}

static void is_a_queue(void **state)
{
    (void)state;
    int numbers[100];
    struct pool *p = pool_create(1, 4);
    for (int i = 0; i < 100; i++) {
        numbers[i] = i;
        pool_submit(p, note_order, &numbers[i]);
    }
    pool_drain(p);
    assert_int_equal(order_count, 100);
    for (int i = 0; i < 100; i++) assert_int_equal(order[i], i);
    pool_destroy(&p);
}

static void edges(void **state)
{
    (void)state;
    struct pool *none = NULL;
    pool_destroy(&none);
    struct pool *p = pool_create(0, 1);
    assert_true(pool_threads(p) >= 1);
    pool_drain(p);
    pool_destroy(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_jobs_run),
        cmocka_unit_test(try_submit_is_bounded),
        cmocka_unit_test(submit_waits_for_room),
        cmocka_unit_test(is_a_queue),
        cmocka_unit_test(edges),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
