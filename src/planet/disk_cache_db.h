// The database of the disk cache: one connection, one thread at a time. Inside the planet room.
//   item(url, used, fetched, expires, etag, modified, hash, size, data)   used: a growing number
//   state(id, total, uses)     total: bytes of all items, kept by triggers
#ifndef PERIGEE_PLANET_DISK_CACHE_DB_H
#define PERIGEE_PLANET_DISK_CACHE_DB_H

#include "planet/disk_cache.h"

struct disk_db;

enum disk_op { DISK_PUT, DISK_RENEW, DISK_FORGET, DISK_USE };

// ERR_IO, ERR_FORMAT; not logged: *why, room for 256, says it. With `read_only` nothing is written,
// not even beside the file.
status disk_db_open(const char *path, bool read_only, char *why, struct disk_db **out);
void disk_db_close(struct disk_db **db);

status disk_db_get(struct disk_db *db, const char *url, disk_item *out); // ERR_NOT_FOUND, ERR_IO

// One transaction: begin, any number of ops, and at the end eviction down to the bound. When one
// fails all of it is given up.
status disk_db_begin(struct disk_db *db);
status disk_db_apply(struct disk_db *db, enum disk_op op, const char *url, const disk_item *item);
status disk_db_end(struct disk_db *db, uint64_t max_bytes, uint64_t *total, uint64_t *evicted);
void disk_db_undo(struct disk_db *db);

// What SQLite said last.
const char *disk_db_message(struct disk_db *db);

#endif
