// Hash table of entries; those that nobody holds are also in a list from most to least recently
// used. Waiting for an entry cannot deadlock, because making one waits for coarser zooms only.
#include "planet/cache.h"

#include <assert.h>
#include <math.h>
#include <pthread.h>
#include <stdlib.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/memory.h"

enum entry_state { MAKING, READY, FAILED };

struct entry {
    pyramid_tile tile; // first: a pyramid_tile is handed out and comes back
    void *samples;
    enum entry_state state;
    status failure; // of FAILED
    int holders;
    struct entry *chain;         // same bucket
    struct entry *newer, *older; // among those nobody holds
};

struct cache {
    cache_make make;
    void *user;
    pthread_mutex_t lock;
    pthread_cond_t made;
    struct entry **buckets;
    size_t bucket_count; // a power of two
    size_t count, limit; // entries in memory
    struct entry idle;   // ring: idle.older is the most recently used
    uint64_t hits;
};

static const size_t entry_bytes = sizeof(struct entry) + CACHE_SAMPLE_BYTES;

struct cache *cache_create(size_t bytes, cache_make make, void *user)
{
    struct cache *c = NEW(struct cache);
    c->make = make;
    c->user = user;
    c->limit = bytes / entry_bytes;
    c->bucket_count = 64;
    while (c->bucket_count < 2 * c->limit) c->bucket_count *= 2;
    c->buckets = NEW_ARRAY(struct entry *, c->bucket_count);
    c->idle.newer = c->idle.older = &c->idle;
    pthread_mutex_init(&c->lock, NULL);
    pthread_cond_init(&c->made, NULL);
    return c;
}

static void entry_free(struct entry *e)
{
    free(e->samples);
    free(e);
}

void cache_destroy(struct cache **cache)
{
    struct cache *c = *cache;
    if (!c) return;
    for (size_t i = 0; i < c->bucket_count; i++)
        while (c->buckets[i]) {
            struct entry *e = c->buckets[i];
            assert(e->holders == 0);
            c->buckets[i] = e->chain;
            entry_free(e);
        }
    pthread_cond_destroy(&c->made);
    pthread_mutex_destroy(&c->lock);
    free(c->buckets);
    free(c);
    *cache = NULL;
}

static struct entry **bucket_of(struct cache *c, tile_id id)
{
    uint64_t key = (uint64_t)id.layer << 56 ^ (uint64_t)id.zoom << 50 ^ (uint64_t)id.row << 25 ^
                   (uint64_t)id.col;
    key *= 0x9e3779b97f4a7c15u;
    return &c->buckets[(key >> 32) & (c->bucket_count - 1)];
}

static void unchain(struct cache *c, struct entry *e)
{
    struct entry **link = bucket_of(c, e->tile.id);
    while (*link != e) link = &(*link)->chain;
    *link = e->chain;
}

static void idle_remove(struct entry *e)
{
    e->newer->older = e->older;
    e->older->newer = e->newer;
    e->newer = e->older = NULL;
}

static void idle_add(struct cache *c, struct entry *e)
{
    e->newer = &c->idle;
    e->older = c->idle.older;
    e->older->newer = e;
    c->idle.older = e;
}

// Takes the least recently used entry out of everything, or NULL when all are held.
static struct entry *evict(struct cache *c)
{
    struct entry *e = c->idle.newer;
    if (e == &c->idle) return NULL;
    idle_remove(e);
    unchain(c, e);
    return e;
}

// An entry with room for samples: evicted at the limit, else new. NULL when memory is out.
static struct entry *obtain(struct cache *c)
{
    struct entry *e = c->count >= c->limit ? evict(c) : NULL;
    void *samples = e ? e->samples : malloc(CACHE_SAMPLE_BYTES);
    if (!samples && (e = evict(c))) samples = e->samples;
    if (!samples) {
        log_error("out of memory for a tile, with %zu in memory", c->count);
        return NULL;
    }
    if (!e) {
        e = NEW(struct entry);
        c->count++;
    }
    *e = (struct entry){.samples = samples};
    return e;
}

// The last holder has gone: keep it, or free it when it failed or lies beyond the limit.
static void retire(struct cache *c, struct entry *e)
{
    if (e->state == READY && c->count <= c->limit) {
        idle_add(c, e);
        return;
    }
    if (e->state == READY) unchain(c, e);
    entry_free(e);
    c->count--;
}

static void drop_hold(struct cache *c, struct entry *e)
{
    assert(e->holders > 0);
    if (--e->holders == 0) retire(c, e);
}

static status wait_for(struct cache *c, struct entry *e)
{
    if (e->holders++ == 0) idle_remove(e);
    while (e->state == MAKING) pthread_cond_wait(&c->made, &c->lock);
    if (e->state == READY) {
        c->hits++;
        return OK;
    }
    status s = e->failure;
    drop_hold(c, e);
    return s;
}

// Puts a new entry in the table and makes it, without the lock.
static status make_entry(struct cache *c, struct entry *e, struct want *want, tile_id id)
{
    struct entry **bucket = bucket_of(c, id);
    e->tile.id = id;
    if (id.layer == LAYER_HEIGHT) e->tile.heights = e->samples;
    else e->tile.rgba = e->samples;
    e->state = MAKING;
    e->holders = 1;
    e->chain = *bucket;
    *bucket = e;
    pthread_mutex_unlock(&c->lock);
    struct cache_made made = {.until_s = INFINITY};
    status s = c->make(c->user, want, id, e->samples, &made);
    pthread_mutex_lock(&c->lock);
    e->tile.min = made.min;
    e->tile.max = made.max;
    e->tile.until_s = made.until_s;
    e->state = s ? FAILED : READY;
    e->failure = s;
    pthread_cond_broadcast(&c->made);
    if (s) {
        unchain(c, e);
        drop_hold(c, e);
    }
    return s;
}

// The entry of a tile; one whose time is over is let go when nobody holds it.
static struct entry *find(struct cache *c, tile_id id)
{
    struct entry *e = *bucket_of(c, id);
    while (e && !tile_id_equal(e->tile.id, id)) e = e->chain;
    if (!e || e->holders || e->state != READY || e->tile.until_s == (double)INFINITY) return e;
    if (clock_now_s() < e->tile.until_s) return e;
    idle_remove(e);
    unchain(c, e);
    entry_free(e);
    c->count--;
    return NULL;
}

const pyramid_tile *cache_peek(struct cache *c, tile_id id)
{
    pthread_mutex_lock(&c->lock);
    struct entry *e = find(c, id);
    if (e && e->state != READY) e = NULL;
    if (e && e->holders++ == 0) idle_remove(e);
    pthread_mutex_unlock(&c->lock);
    return e ? &e->tile : NULL;
}

status cache_acquire(struct cache *c, struct want *want, tile_id id, const pyramid_tile **out)
{
    *out = NULL;
    pthread_mutex_lock(&c->lock);
    struct entry *e = find(c, id);
    status s = OK;
    if (e) s = wait_for(c, e);
    else if ((e = obtain(c))) s = make_entry(c, e, want, id);
    else s = ERR_MEMORY;
    pthread_mutex_unlock(&c->lock);
    if (!s) *out = &e->tile;
    return s;
}

void cache_release(struct cache *c, const pyramid_tile **tile)
{
    if (!*tile) return;
    pthread_mutex_lock(&c->lock);
    drop_hold(c, (struct entry *)*tile);
    pthread_mutex_unlock(&c->lock);
    *tile = NULL;
}

void cache_counters(struct cache *c, uint64_t *hits, uint64_t *bytes)
{
    pthread_mutex_lock(&c->lock);
    *hits = c->hits;
    *bytes = c->count * entry_bytes;
    pthread_mutex_unlock(&c->lock);
}
