// Bodies that came over the network, kept on disk within a bound of bytes, the least recently used
// given up first. One SQLite database in WAL mode: a kill at any moment loses at most what was put
// last, and several programs may use it at once. Writes happen on a thread of its own, so that no
// caller ever waits for a slow disk; when that falls behind, what is put is dropped. A full,
// failing or read-only disk is told once and gone on without. Any thread.
#ifndef PERIGEE_PLANET_DISK_CACHE_H
#define PERIGEE_PLANET_DISK_CACHE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

struct disk_cache;

enum { DISK_TAG_SIZE = 192 };

// A body and what its server said of it.
typedef struct disk_item {
    unsigned char *data; // on the heap; NULL: the server has no such thing
    size_t size;
    char etag[DISK_TAG_SIZE], modified[DISK_TAG_SIZE]; // "": not said
    double max_age_s; // put: how long it may be used unasked; get: 0, or positive while it may be
} disk_item;

struct disk_cache_counters {
    uint64_t hits, misses, written, dropped, failed, evicted;
    uint64_t bytes; // of all bodies with their keys, as of the last write
};

// Makes the file and its folders when they are not there. ERR_IO, ERR_FORMAT (it is something
// else), logged as a warning that it is gone on without.
status disk_cache_open(const char *path, uint64_t max_bytes, struct disk_cache **out);

// Writes what was put, and closes. NULL-safe.
void disk_cache_close(struct disk_cache **cache);

// False when it is not there. A clock that went backwards makes everything old, not young.
bool disk_cache_get(struct disk_cache *cache, const char *url, disk_item *out);
void disk_item_deinit(disk_item *item);

void disk_cache_put(struct disk_cache *cache, const char *url, const disk_item *item); // copied
// It is still what the server has.
void disk_cache_renew(struct disk_cache *cache, const char *url, double max_age_s);
void disk_cache_forget(struct disk_cache *cache, const char *url);

// Waits until all that was put is written or given up.
void disk_cache_flush(struct disk_cache *cache);

void disk_cache_counters(struct disk_cache *cache, struct disk_cache_counters *out);

#endif
