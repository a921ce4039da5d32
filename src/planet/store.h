// What the reader and the writer of planet files share: the schema, the check value of bodies, and
// SQLite's errors as status. Private to
// planet_file.c, planet_part.c and planet_writer.c.
//   meta(key, value)                                  one row a fact, see store_meta.c
//   body(id, hash, data)                              tile bodies, each stored once; hash:
//   store_hash tile(layer, zoom, row, col, body, min, max)       body: body.id; min, max: NULL
//   without samples
// PRAGMA application_id is STORE_APPLICATION_ID, user_version PLANET_SCHEMA_VERSION.
#ifndef PERIGEE_PLANET_STORE_H
#define PERIGEE_PLANET_STORE_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "planet/codec.h"

struct sqlite3;
struct sqlite3_stmt;
struct planet_meta;

enum { STORE_APPLICATION_ID = 0x50524745, STORE_MAX_BODY = 1 << 20 };

// XXH3 of the bytes, 64 bits, as SQLite's signed integer.
int64_t store_hash(const void *data, size_t size);

// The same as planet files of a version have it: up to 2 it was FNV-1a.
int64_t store_hash_of(int version, const void *data, size_t size);

// Logs SQLite's message for `path` and gives the status for its code.
status store_error(struct sqlite3 *db, const char *path);

// The same without a word.
status store_status(struct sqlite3 *db);

status store_exec(struct sqlite3 *db, const char *path, const char *sql);
status store_prepare(struct sqlite3 *db, const char *path, const char *sql,
                     struct sqlite3_stmt **out);

// Reads one integer, e.g. of a PRAGMA.
status store_query_int(struct sqlite3 *db, const char *path, const char *sql, int *out);

// Parameters 1-4: layer, zoom, row, col.
void store_bind_tile(struct sqlite3_stmt *stmt, tile_id id);

// file: URI for reading a path, freed by the caller. immutable: as it is, without lock or log.
char *store_uri(const char *path, bool immutable);

// Nothing in the file's schema may run code, and no value may be larger than a tile can be.
void store_restrict(struct sqlite3 *db);

// ERR_FORMAT, logged with path and tile, when a body is not the one that was written.
// `version`: of the file.
status store_check_body(const char *path, int version, tile_id id, const void *data, size_t size,
                        int64_t hash);

// A column as float; NaN when it is NULL.
float store_float(struct sqlite3_stmt *stmt, int column);

// Runs a statement of the columns data, hash, min, max for a tile: its body (copied, checked) and
// range. ERR_NOT_FOUND silently.
status store_get_body(struct sqlite3 *db, const char *path, int version, struct sqlite3_stmt *stmt,
                      tile_id id, codec_blob *body, float *min, float *max);

// ERR_FORMAT or ERR_VERSION, logged, when the open database is not a planet file that can be read.
// version: the file's own.
status store_check(struct sqlite3 *db, const char *path, int *version);

status store_meta_read(struct sqlite3 *db, const char *path, struct planet_meta *out);
status store_meta_write(struct sqlite3 *db, const char *path, const struct planet_meta *meta);

#endif
