// SQLite at the room's edge: codes become status, and a message names the file.
#include "planet/store.h"

#include <sqlite3.h>

#include "base/log.h"
#include "planet/planet_file.h"

int64_t store_hash(const void *data, size_t size)
{
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
        return ERR_FORMAT;
    default:
        return ERR_IO;
    }
}

status store_error(sqlite3 *db, const char *path)
{
    int code = db ? sqlite3_errcode(db) : SQLITE_NOMEM;
    log_error("%s: %s", path, db ? sqlite3_errmsg(db) : "out of memory");
    return from_sqlite(code);
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

status store_check(sqlite3 *db, const char *path)
{
    int application = 0, version = 0;
    status s = store_query_int(db, path, "PRAGMA application_id", &application);
    if (!s) s = store_query_int(db, path, "PRAGMA user_version", &version);
    if (s) return s;
    if (application != STORE_APPLICATION_ID) {
        log_error("%s: not a planet file", path);
        return ERR_FORMAT;
    }
    if (version != PLANET_SCHEMA_VERSION) {
        log_error("%s: planet file of version %d, this program reads version %d", path, version,
                  PLANET_SCHEMA_VERSION);
        return ERR_VERSION;
    }
    return OK;
}
