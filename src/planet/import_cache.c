#include "planet/import_cache.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "planet/import_light.h"

// A tile that is not stored counts too, so that the lists stay short enough to be searched.
enum { SAMPLES = TILE_SIZE * TILE_SIZE, ENTRY_BYTES = 1 << 14, BUCKETS = 1 << 10 };

// Invariant: an entry with users > 0 or loading is not evicted; `bytes` is the sum over entries.
struct entry {
    cached_tile tile;
    size_t bytes;
    unsigned long used;
    int users;
    bool loading;
    status failed;
    struct entry *next;
};

struct import_cache {
    struct import_store *store;
    pthread_mutex_t lock;
    pthread_cond_t loaded;
    struct entry *buckets[BUCKETS];
    size_t bytes, limit;
    unsigned long clock;
};

struct import_cache *import_cache_create(struct import_store *store, size_t bytes)
{
    struct import_cache *c = NEW(struct import_cache);
    c->store = store;
    c->limit = bytes;
    pthread_mutex_init(&c->lock, NULL);
    pthread_cond_init(&c->loaded, NULL);
    return c;
}

static void free_entry(struct entry *e)
{
    free(e->tile.planes);
    free(e);
}

void import_cache_destroy(struct import_cache **cache)
{
    struct import_cache *c = *cache;
    if (!c) return;
    for (int i = 0; i < BUCKETS; i++)
        while (c->buckets[i]) {
            struct entry *e = c->buckets[i];
            c->buckets[i] = e->next;
            free_entry(e);
        }
    pthread_mutex_destroy(&c->lock);
    pthread_cond_destroy(&c->loaded);
    free(c);
    *cache = NULL;
}

static struct entry **bucket_of(struct import_cache *c, tile_id id)
{
    uint32_t hash = ((uint32_t)id.row * 0x9e3779b1u ^ (uint32_t)id.col) * 0x85ebca6bu;
    return &c->buckets[(hash + (uint32_t)id.zoom) % BUCKETS];
}

// Lock held. NULL: there is none.
static struct entry *find(struct import_cache *c, tile_id id)
{
    struct entry *e = *bucket_of(c, id);
    while (e && !tile_id_equal(e->tile.id, id)) e = e->next;
    return e;
}

// Lock held. A new entry, of which there is none yet.
static struct entry *insert(struct import_cache *c, tile_id id)
{
    struct entry *e = NEW(struct entry), **bucket = bucket_of(c, id);
    e->tile.id = id;
    e->next = *bucket;
    *bucket = e;
    return e;
}

// Lock held. What an entry takes, now that it is known.
static void count_bytes(struct import_cache *c, struct entry *e)
{
    e->bytes = ENTRY_BYTES;
    if (e->tile.planes)
        e->bytes += SAMPLES * sizeof(float) * (e->tile.id.layer == LAYER_COLOR ? 3 : 1);
    c->bytes += e->bytes;
    e->used = ++c->clock;
}

// Lock held. Frees the entries used longest ago until the bound holds.
static void evict(struct import_cache *c)
{
    while (c->bytes > c->limit) {
        struct entry **oldest = NULL;
        for (int i = 0; i < BUCKETS; i++)
            for (struct entry **p = &c->buckets[i]; *p; p = &(*p)->next)
                if (!(*p)->users && !(*p)->loading && (!oldest || (*p)->used < (*oldest)->used))
                    oldest = p;
        if (!oldest) return;
        struct entry *e = *oldest;
        *oldest = e->next;
        c->bytes -= e->bytes;
        free_entry(e);
    }
}

static status decode_pixels(const codec_blob *body, int channels, float *planes)
{
    unsigned char *pixels = malloc((size_t)SAMPLES * (size_t)channels);
    if (!pixels) return ERR_MEMORY;
    status s = codec_pixels_decode(body->data, body->size, channels, pixels);
    for (int c = 0; !s && c < channels; c++)
        for (int i = 0; i < SAMPLES; i++) planes[c * SAMPLES + i] = pixels[i * channels + c];
    if (!s) light_decode(planes, (size_t)SAMPLES * (size_t)channels);
    free(pixels);
    return s;
}

static status load(struct import_cache *c, cached_tile *t)
{
    codec_blob body = {0};
    status s = import_store_get(c->store, t->id, &body, &t->min, &t->max);
    if (s) return s == ERR_NOT_FOUND ? OK : s;
    int channels = t->id.layer == LAYER_COLOR ? 3 : 1;
    t->planes = malloc((size_t)SAMPLES * (size_t)channels * sizeof(float));
    if (!t->planes) s = ERR_MEMORY;
    if (!s && t->id.layer == LAYER_HEIGHT) {
        s = codec_height_decode_tile(t->id, body.data, body.size, import_store_base_height,
                                     c->store, t->planes);
        for (int i = 0; !s && i < SAMPLES && !t->has_nan; i++) t->has_nan = isnan(t->planes[i]);
    } else if (!s) {
        s = decode_pixels(&body, channels, t->planes);
    }
    codec_blob_deinit(&body);
    if (s)
        log_error("%s tile %d/%d/%d, just written, cannot be decoded: %s",
                  tile_layer_name(t->id.layer), t->id.zoom, t->id.row, t->id.col, status_text(s));
    return s;
}

status import_cache_acquire(struct import_cache *c, tile_id id, const cached_tile **out)
{
    pthread_mutex_lock(&c->lock);
    struct entry *e = find(c, id);
    if (e) {
        e->users++;
        while (e->loading) pthread_cond_wait(&c->loaded, &c->lock);
    } else {
        e = insert(c, id);
        e->users = 1;
        e->loading = true;
        pthread_mutex_unlock(&c->lock);
        status s = load(c, &e->tile);
        pthread_mutex_lock(&c->lock);
        e->failed = s;
        e->loading = false;
        count_bytes(c, e);
        pthread_cond_broadcast(&c->loaded);
        evict(c);
    }
    e->used = ++c->clock;
    status s = e->failed;
    if (s) e->users--;
    pthread_mutex_unlock(&c->lock);
    *out = s ? NULL : &e->tile;
    return s;
}

void import_cache_release(struct import_cache *c, const cached_tile *tile)
{
    if (!tile) return;
    pthread_mutex_lock(&c->lock);
    find(c, tile->id)->users--;
    evict(c);
    pthread_mutex_unlock(&c->lock);
}

bool import_cache_copy(struct import_cache *c, tile_id id, float *heights)
{
    pthread_mutex_lock(&c->lock);
    struct entry *e = find(c, id);
    bool there = e && !e->loading && e->tile.planes;
    if (there) e->users++;
    pthread_mutex_unlock(&c->lock);
    if (!there) return false;
    memcpy(heights, e->tile.planes, SAMPLES * sizeof *heights);
    import_cache_release(c, &e->tile);
    return true;
}

void import_cache_drop(struct import_cache *c, tile_id id)
{
    pthread_mutex_lock(&c->lock);
    struct entry **p = bucket_of(c, id);
    while (*p && !tile_id_equal((*p)->tile.id, id)) p = &(*p)->next;
    struct entry *e = *p;
    if (e) {
        *p = e->next;
        c->bytes -= e->bytes;
        free_entry(e);
    }
    pthread_mutex_unlock(&c->lock);
}

void import_cache_add(struct import_cache *c, tile_id id, const float *heights, float min,
                      float max)
{
    float *planes = malloc(SAMPLES * sizeof *planes);
    if (!planes) return; // it is read back when it is needed
    memcpy(planes, heights, SAMPLES * sizeof *planes);
    int gaps = 0;
    for (int i = 0; i < SAMPLES; i++) gaps += isnan(heights[i]);
    pthread_mutex_lock(&c->lock);
    if (find(c, id)) {
        free(planes);
    } else {
        struct entry *e = insert(c, id);
        e->tile = (cached_tile){id, planes, gaps > 0, min, max};
        count_bytes(c, e);
        evict(c);
    }
    pthread_mutex_unlock(&c->lock);
}
