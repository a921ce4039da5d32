// A reader under one lock, a queue under another, and the writer's thread, which alone uses its
// connection. After a failure nothing is written for REST_S; then it is tried again.
#include "planet/disk_cache.h"

#include <errno.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/memory.h"
#include "planet/disk_cache_db.h"

enum { QUEUE_ITEMS = 1024, QUEUE_BYTES = 32 << 20, BATCH = 64 };

static const double REST_S = 30;

struct queued {
    enum disk_op op;
    char *url;
    disk_item item;
};

struct disk_cache {
    char *path;
    uint64_t max_bytes;
    pthread_mutex_t read_lock;
    struct disk_db *reader, *writer; // writer NULL: read only
    pthread_mutex_t lock;            // of what follows
    pthread_cond_t changed;
    struct queued queue[QUEUE_ITEMS];
    int first, count;
    size_t queue_bytes;
    bool stopping, writing, told;
    double rest_until_s;
    struct disk_cache_counters counters;
    pthread_t thread;
};

static char *copy_of(const char *text)
{
    char *copy = NEW_ARRAY(char, strlen(text) + 1);
    return strcpy(copy, text);
}

void disk_item_deinit(disk_item *item)
{
    free(item->data);
    *item = (disk_item){0};
}

static void queued_free(struct queued *q)
{
    free(q->url);
    disk_item_deinit(&q->item);
}

// Told once an outage.
static void write_failed(struct disk_cache *c, const char *why)
{
    disk_db_undo(c->writer);
    pthread_mutex_lock(&c->lock);
    bool first = !c->told;
    c->told = true;
    c->counters.failed++;
    c->rest_until_s = clock_now_s() + REST_S;
    pthread_mutex_unlock(&c->lock);
    if (first) log_warn("%s: %s; tiles are not kept for now", c->path, why);
}

static void write_batch(struct disk_cache *c, struct queued *batch, int count)
{
    uint64_t total = 0, evicted = 0;
    status s = disk_db_begin(c->writer);
    for (int i = 0; !s && i < count; i++)
        s = disk_db_apply(c->writer, batch[i].op, batch[i].url, &batch[i].item);
    if (!s) s = disk_db_end(c->writer, c->max_bytes, &total, &evicted);
    if (s) {
        write_failed(c, disk_db_message(c->writer));
        return;
    }
    pthread_mutex_lock(&c->lock);
    c->counters.written += (uint64_t)count;
    c->counters.bytes = total;
    c->counters.evicted += evicted;
    c->told = false;
    pthread_mutex_unlock(&c->lock);
}

static int take_batch(struct disk_cache *c, struct queued batch[BATCH])
{
    int n = c->count < BATCH ? c->count : BATCH;
    for (int i = 0; i < n; i++) {
        batch[i] = c->queue[(c->first + i) % QUEUE_ITEMS];
        c->queue_bytes -= batch[i].item.size;
    }
    c->first = (c->first + n) % QUEUE_ITEMS;
    c->count -= n;
    return n;
}

static void *write_all(void *arg)
{
    struct disk_cache *c = arg;
    struct queued batch[BATCH];
    pthread_mutex_lock(&c->lock);
    for (;;) {
        while (!c->count && !c->stopping) pthread_cond_wait(&c->changed, &c->lock);
        if (!c->count) break;
        int n = take_batch(c, batch);
        c->writing = true;
        pthread_mutex_unlock(&c->lock);
        write_batch(c, batch, n);
        for (int i = 0; i < n; i++) queued_free(&batch[i]);
        pthread_mutex_lock(&c->lock);
        c->writing = false;
        pthread_cond_broadcast(&c->changed);
    }
    pthread_mutex_unlock(&c->lock);
    return NULL;
}

static void make_folders(const char *path)
{
    char *folder = copy_of(path);
    for (char *slash = folder + 1; (slash = strchr(slash, '/')); slash++) {
        *slash = '\0';
        mkdir(folder, 0777);
        *slash = '/';
    }
    free(folder);
}

static status open_parts(struct disk_cache *c)
{
    char why[256], first_why[256];
    make_folders(c->path);
    status s = disk_db_open(c->path, false, first_why, &c->writer);
    bool read_only = s == ERR_IO;
    if (!s || read_only) s = disk_db_open(c->path, read_only, why, &c->reader);
    if (s) log_warn("%s: %s; going on without a cache on disk", c->path, first_why);
    else if (read_only) log_warn("%s: %s; nothing is added to it", c->path, first_why);
    return s;
}

status disk_cache_open(const char *path, uint64_t max_bytes, struct disk_cache **out)
{
    struct disk_cache *c = NEW(struct disk_cache);
    c->path = copy_of(path);
    c->max_bytes = max_bytes;
    pthread_mutex_init(&c->read_lock, NULL);
    pthread_mutex_init(&c->lock, NULL);
    pthread_cond_init(&c->changed, NULL);
    status s = open_parts(c);
    if (!s && c->writer && pthread_create(&c->thread, NULL, write_all, c)) {
        log_warn("%s: no thread for it; nothing is added to it", path);
        disk_db_close(&c->writer);
    }
    *out = c;
    if (s) disk_cache_close(out);
    return s;
}

void disk_cache_close(struct disk_cache **cache)
{
    struct disk_cache *c = *cache;
    if (!c) return;
    if (c->writer && c->reader) {
        pthread_mutex_lock(&c->lock);
        c->stopping = true;
        pthread_cond_broadcast(&c->changed);
        pthread_mutex_unlock(&c->lock);
        pthread_join(c->thread, NULL);
    }
    disk_db_close(&c->reader);
    disk_db_close(&c->writer);
    pthread_cond_destroy(&c->changed);
    pthread_mutex_destroy(&c->lock);
    pthread_mutex_destroy(&c->read_lock);
    free(c->path);
    free(c);
    *cache = NULL;
}

static disk_item item_copy(const disk_item *item)
{
    disk_item copy = *item;
    copy.data = item->data ? malloc(item->size ? item->size : 1) : NULL;
    if (copy.data) memcpy(copy.data, item->data, item->size);
    return copy;
}

static void enqueue(struct disk_cache *c, enum disk_op op, const char *url, const disk_item *item)
{
    if (!c->writer) return;
    pthread_mutex_lock(&c->lock);
    if (c->count == QUEUE_ITEMS || c->queue_bytes + item->size > QUEUE_BYTES ||
        clock_now_s() < c->rest_until_s) {
        c->counters.dropped++;
    } else {
        struct queued q = {op, copy_of(url), item_copy(item)};
        if (item->data && !q.item.data) {
            c->counters.dropped++;
            queued_free(&q);
        } else {
            c->queue[(c->first + c->count++) % QUEUE_ITEMS] = q;
            c->queue_bytes += item->size;
            pthread_cond_broadcast(&c->changed);
        }
    }
    pthread_mutex_unlock(&c->lock);
}

bool disk_cache_get(struct disk_cache *c, const char *url, disk_item *out)
{
    pthread_mutex_lock(&c->read_lock);
    status s = disk_db_get(c->reader, url, out);
    pthread_mutex_unlock(&c->read_lock);
    pthread_mutex_lock(&c->lock);
    if (s) c->counters.misses++;
    else c->counters.hits++;
    pthread_mutex_unlock(&c->lock);
    if (!s) enqueue(c, DISK_USE, url, &(disk_item){0});
    return !s;
}

void disk_cache_put(struct disk_cache *c, const char *url, const disk_item *item)
{
    if (item->size <= c->max_bytes / 4) enqueue(c, DISK_PUT, url, item);
}

void disk_cache_renew(struct disk_cache *c, const char *url, double max_age_s)
{
    enqueue(c, DISK_RENEW, url, &(disk_item){.max_age_s = max_age_s});
}

void disk_cache_forget(struct disk_cache *c, const char *url)
{
    enqueue(c, DISK_FORGET, url, &(disk_item){0});
}

void disk_cache_flush(struct disk_cache *c)
{
    pthread_mutex_lock(&c->lock);
    while (c->count || c->writing) pthread_cond_wait(&c->changed, &c->lock);
    pthread_mutex_unlock(&c->lock);
}

void disk_cache_counters(struct disk_cache *c, struct disk_cache_counters *out)
{
    pthread_mutex_lock(&c->lock);
    *out = c->counters;
    pthread_mutex_unlock(&c->lock);
}
