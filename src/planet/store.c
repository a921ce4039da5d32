// SQLite at the room's edge: codes become status, and a message names the file.
#include "planet/store.h"

#include <math.h>
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "base/log.h"
#include "base/memory.h"
#include "planet/planet_file.h"

int64_t store_hash(const void *data, size_t size)
{
    return (int64_t)XXH3_64bits(data, size);
}

int64_t store_hash_of(int version, const void *data, size_t size)
{
    if (version > 2) return store_hash(data, size);
    const unsigned char *bytes = data;
    uint64_t hash = 0xcbf29ce484222325u;
    for (size_t i = 0; i < size; i++) hash = (hash ^ bytes[i]) * 0x100000001b3u;
    return (int64_t)hash;
}

static status from_sqlite(int code)
{
    switch (code & 0xff) {
    case SQLITE_NOMEM:
        return ERR_MEMORY;
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
    case SQLITE_ERROR: // a table or column that is not there
    case SQLITE_MISMATCH:
    case SQLITE_TOOBIG: // a body longer than any tile's
        return ERR_FORMAT;
    default:
        return ERR_IO;
    }
}

status store_status(sqlite3 *db)
{
    return from_sqlite(db ? sqlite3_errcode(db) : SQLITE_NOMEM);
}

status store_error(sqlite3 *db, const char *path)
{
    log_error("%s: %s", path, db ? sqlite3_errmsg(db) : "out of memory");
    return store_status(db);
}

status store_exec(sqlite3 *db, const char *path, const char *sql)
{
    return sqlite3_exec(db, sql, NULL, NULL, NULL) == SQLITE_OK ? OK : store_error(db, path);
}

status store_prepare(sqlite3 *db, const char *path, const char *sql, sqlite3_stmt **out)
{
    *out = NULL;
    return sqlite3_prepare_v3(db, sql, -1, SQLITE_PREPARE_PERSISTENT, out, NULL) == SQLITE_OK
               ? OK
               : store_error(db, path);
}

status store_query_int(sqlite3 *db, const char *path, const char *sql, int *out)
{
    sqlite3_stmt *stmt;
    status s = store_prepare(db, path, sql, &stmt);
    if (!s) {
        if (sqlite3_step(stmt) == SQLITE_ROW) *out = sqlite3_column_int(stmt, 0);
        else s = store_error(db, path);
    }
    sqlite3_finalize(stmt);
    return s;
}

void store_bind_tile(sqlite3_stmt *stmt, tile_id id)
{
    sqlite3_bind_int(stmt, 1, id.layer);
    sqlite3_bind_int(stmt, 2, id.zoom);
    sqlite3_bind_int(stmt, 3, id.row);
    sqlite3_bind_int(stmt, 4, id.col);
}

status store_check(sqlite3 *db, const char *path, int *version)
{
    int application = 0;
    *version = 0;
    status s = store_query_int(db, path, "PRAGMA application_id", &application);
    if (!s) s = store_query_int(db, path, "PRAGMA user_version", version);
    if (s) return s;
    if (application != STORE_APPLICATION_ID) {
        log_error("%s: not a planet file", path);
        return ERR_FORMAT;
    }
    if (*version < 1 || *version > PLANET_SCHEMA_VERSION) {
        log_error("%s: planet file of version %d, this program reads versions 1 to %d", path,
                  *version, PLANET_SCHEMA_VERSION);
        return ERR_VERSION;
    }
    return OK;
}

// What has a meaning in a URI is escaped.
char *store_uri(const char *path, bool immutable)
{
    static const char digits[] = "0123456789abcdef";
    size_t size = 3 * strlen(path) + 64, n = 5;
    char *uri = NEW_ARRAY(char, size);
    memcpy(uri, "file:", n);
    for (const char *c = path; *c; c++) {
        bool plain = !strchr("%?#", *c);
        uri[n++] = plain ? *c : '%';
        if (plain) continue;
        uri[n++] = digits[(unsigned char)*c >> 4];
        uri[n++] = digits[(unsigned char)*c & 15];
    }
    snprintf(uri + n, size - n, "?mode=ro%s", immutable ? "&immutable=1" : "");
    return uri;
}

void store_restrict(sqlite3 *db)
{
    sqlite3_db_config(db, SQLITE_DBCONFIG_DEFENSIVE, 1, NULL);
    sqlite3_db_config(db, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, NULL);
    sqlite3_db_config(db, SQLITE_DBCONFIG_ENABLE_VIEW, 0, NULL);
    sqlite3_db_config(db, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, NULL);
    sqlite3_limit(db, SQLITE_LIMIT_LENGTH, STORE_MAX_BODY + 4096);
}

status store_check_body(const char *path, int version, tile_id id, const void *data, size_t size,
                        int64_t hash)
{
    if (store_hash_of(version, data, size) == hash) return OK;
    log_error("%s: tile %s/%d/%d/%d: corrupt: its body is not what was written", path,
              tile_layer_name(id.layer), id.zoom, id.row, id.col);
    return ERR_FORMAT;
}

float store_float(sqlite3_stmt *stmt, int column)
{
    return sqlite3_column_type(stmt, column) == SQLITE_NULL
               ? NAN
               : (float)sqlite3_column_double(stmt, column);
}

static status copy_body(sqlite3_stmt *stmt, codec_blob *body)
{
    const void *data = sqlite3_column_blob(stmt, 0);
    size_t size = (size_t)sqlite3_column_bytes(stmt, 0);
    body->data = malloc(size ? size : 1);
    if (!body->data) return ERR_MEMORY;
    if (size) memcpy(body->data, data, size);
    body->size = size;
    return OK;
}

status store_get_body(sqlite3 *db, const char *path, int version, sqlite3_stmt *stmt, tile_id id,
                      codec_blob *body, float *min, float *max)
{
    *body = (codec_blob){0};
    *min = *max = 0;
    store_bind_tile(stmt, id);
    int code = sqlite3_step(stmt);
    status s = code == SQLITE_DONE  ? ERR_NOT_FOUND
               : code == SQLITE_ROW ? OK
                                    : store_error(db, path);
    if (!s) s = copy_body(stmt, body);
    if (!s)
        s = store_check_body(path, version, id, body->data, body->size,
                             sqlite3_column_int64(stmt, 1));
    if (!s) {
        *min = store_float(stmt, 2);
        *max = store_float(stmt, 3);
    }
    sqlite3_reset(stmt);
    if (s) codec_blob_deinit(body);
    return s;
}
