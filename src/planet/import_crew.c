#include "planet/import_crew.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <time.h>

#include "base/memory.h"
#include "base/pool.h"
#include "planet/import_shares.h"

#define COMMIT_SECONDS   1.0
#define PROGRESS_SECONDS 0.2
// What workers have to do while a commit waits for the disk, tiles of a thread.
enum { AHEAD = 64 };
// A wait for workers ends after this, to look after the other ranks.
#define WAIT_NS (50 * 1000 * 1000)
#define LOOK_NS (2 * 1000 * 1000)

// Workers make tiles; the main thread, which has given them out, stores what they have made, so
// that they never wait for the disk. Invariant: `lock` guards what stands below it.
struct crew {
    crew_params params;
    struct pool *pool;
    struct workshop *workshop;
    struct shares *shares; // of rank 0
    const char *stage;
    uint64_t stage_tiles, given;
    bool alone; // the other ranks wait
    double committed_s, reported_s;
    int running; // tiles given out and not stored yet
    struct crew_counters counters;
    pthread_mutex_t lock;
    pthread_cond_t finished;
    status failed;
    struct job *made; // the latest first
};

struct job {
    struct crew *crew;
    tile_id id;
    made_tile tile;
    status result;
    struct job *next;
};

static double now_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

struct crew *crew_create(const crew_params *params)
{
    struct crew *c = NEW(struct crew);
    c->params = *params;
    c->pool = pool_create(params->threads, 1024);
    c->shares = shares_create(params->team ? params->team->size : 1);
    c->committed_s = now_s();
    pthread_mutex_init(&c->lock, NULL);
    pthread_cond_init(&c->finished, NULL);
    return c;
}

void crew_destroy(struct crew **crew)
{
    if (!*crew) return;
    pool_destroy(&(*crew)->pool);
    shares_destroy(&(*crew)->shares);
    pthread_cond_destroy(&(*crew)->finished);
    pthread_mutex_destroy(&(*crew)->lock);
    free(*crew);
    *crew = NULL;
}

int crew_threads(const struct crew *crew)
{
    return pool_threads(crew->pool);
}

void crew_begin(struct crew *c, const char *stage, uint64_t tiles, struct workshop *workshop)
{
    c->stage = stage;
    c->stage_tiles = tiles;
    c->given = 0;
    c->workshop = workshop;
    shares_forget(c->shares);
    c->reported_s = -INFINITY; // at once
}

struct crew_counters crew_count(const struct crew *c)
{
    return c->counters;
}

static status fares(struct crew *c)
{
    pthread_mutex_lock(&c->lock);
    status s = c->failed;
    pthread_mutex_unlock(&c->lock);
    return s;
}

static void fail(struct crew *c, status s)
{
    pthread_mutex_lock(&c->lock);
    if (s && !c->failed) c->failed = s;
    pthread_mutex_unlock(&c->lock);
}

static void run_job(void *arg, int worker)
{
    struct job *job = arg;
    struct crew *c = job->crew;
    job->result = fares(c);
    if (!job->result) job->result = workshop_make(c->workshop, worker, job->id, &job->tile);
    pthread_mutex_lock(&c->lock);
    job->next = c->made;
    c->made = job;
    pthread_cond_signal(&c->finished);
    pthread_mutex_unlock(&c->lock);
}

// Stores what workers have made.
static void store_made(struct crew *c)
{
    pthread_mutex_lock(&c->lock);
    struct job *job = c->made;
    c->made = NULL;
    pthread_mutex_unlock(&c->lock);
    while (job) {
        struct job *next = job->next;
        made_tile *tile = &job->tile;
        status s = job->result;
        bool stored = !s && tile->body.size;
        if (stored)
            s = import_store_put(c->params.store, job->id, &tile->body, tile->min, tile->max);
        fail(c, s);
        c->counters.made += stored && !s;
        c->counters.empty += !stored && !s;
        c->counters.uniform += stored && tile->uniform;
        c->counters.bytes += stored ? tile->body.size : 0;
        c->running--;
        codec_blob_deinit(&tile->body);
        free(job);
        job = next;
    }
}

// Commits and reports when it is time.
static void tend(struct crew *c)
{
    double now = now_s();
    if (!fares(c) && now - c->committed_s > COMMIT_SECONDS) {
        fail(c, import_store_commit(c->params.store));
        c->committed_s = now_s();
    }
    if (!c->params.progress || fares(c) || now - c->reported_s < PROGRESS_SECONDS) return;
    c->reported_s = now;
    uint64_t done = c->given - (uint64_t)c->running;
    double share = c->stage_tiles ? (double)done / (double)c->stage_tiles : 1;
    if (c->params.progress(c->params.user, c->stage, share < 1 ? share : 1)) fail(c, ERR_CANCELLED);
}

// Waits until fewer than `limit` tiles are under way, at most `ns`. True when they are.
static bool wait_below(struct crew *c, int limit, long ns)
{
    tend(c);
    store_made(c);
    if (c->running < limit) return true;
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_nsec += ns;
    until.tv_sec += until.tv_nsec / 1000000000;
    until.tv_nsec %= 1000000000;
    pthread_mutex_lock(&c->lock);
    if (!c->made) pthread_cond_timedwait(&c->finished, &c->lock, &until);
    pthread_mutex_unlock(&c->lock);
    store_made(c);
    return c->running < limit;
}

static void submit(struct crew *c, tile_id id)
{
    struct job *job = NEW(struct job);
    *job = (struct job){.crew = c, .id = id};
    c->running++;
    pool_submit(c->pool, run_job, job);
}

// The next tile for a rank that is not there yet.
static bool next_tile(struct crew *c, int rank, tile_id *id)
{
    while (shares_next(c->shares, rank, id)) {
        c->given++;
        if (!import_store_has(c->params.store, *id)) return true;
        c->counters.kept++;
        tend(c);
        if (fares(c)) return false;
    }
    return false;
}

// Rank 0: answers every rank that asks. True when some did; *waiting: ranks not told to stop yet.
static bool serve(struct crew *c, int *waiting)
{
    const import_team *team = c->params.team;
    int rank;
    status s;
    bool any = false;
    while (team && team->asked(team->user, &rank, &s)) {
        tile_id ids[TEAM_BATCH];
        int count = 0, batch = shares_batch(c->shares, rank, TEAM_BATCH);
        any = true;
        fail(c, s);
        while (!fares(c) && count < batch && next_tile(c, rank, &ids[count])) count++;
        if (count == 0) --*waiting;
        team->answer(team->user, rank, ids, count);
    }
    return any;
}

// Rank 0, or the only one.
static void lead(struct crew *c)
{
    int threads = pool_threads(c->pool), waiting = c->alone ? 0 : c->params.team->size - 1;
    bool more = true;
    tile_id id;
    while (more && !fares(c)) {
        int ahead = 2 * threads + shares_batch(c->shares, 0, AHEAD * threads);
        serve(c, &waiting);
        if (!wait_below(c, ahead, waiting ? LOOK_NS : WAIT_NS)) continue;
        more = next_tile(c, 0, &id);
        if (more) submit(c, id);
    }
    while (waiting > 0 || !wait_below(c, 1, waiting ? LOOK_NS : WAIT_NS)) {
        if (!serve(c, &waiting) && waiting) wait_below(c, 0, LOOK_NS);
    }
}

static void follow(struct crew *c)
{
    const import_team *team = c->params.team;
    int count;
    tile_id ids[TEAM_BATCH];
    while ((count = team->ask(team->user, fares(c), ids)) > 0) {
        for (int i = 0; i < count; i++) submit(c, ids[i]);
        while (!wait_below(c, 4 * pool_threads(c->pool), WAIT_NS)) continue;
    }
    while (!wait_below(c, 1, WAIT_NS)) continue;
}

static status agree(struct crew *c, status s)
{
    return c->params.team ? c->params.team->agree(c->params.team->user, s) : s;
}

status crew_look(struct crew *c, bool alone)
{
    c->alone = alone || !c->params.team;
    return agree(c, import_store_look(c->params.store, !c->alone));
}

status crew_make(struct crew *c, struct plan_walk *walk)
{
    bool follows = c->params.team && c->params.team->rank > 0;
    shares_divide(c->shares, walk);
    if (!follows) lead(c);
    else if (!c->alone) follow(c);
    return fares(c);
}

status crew_seal(struct crew *c)
{
    status s = import_store_seal(c->params.store);
    return agree(c, fares(c) ? fares(c) : s);
}
