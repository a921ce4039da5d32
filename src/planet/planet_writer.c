// The writer: one connection with one open transaction; what is pending is what that transaction
// holds, so reads see it. Bodies are new pages at the end, which a rollback journal has written
// once; only where others read the file meanwhile is there a log in its place (WAL), which is
// written first and folded in later. A finished file has a rollback journal, so that it is one file
// that a reader without write access can open.
#include "planet/planet_writer.h"

#include <errno.h>
#include <math.h>
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/log.h"
#include "base/memory.h"
#include "planet/store.h"

static const char schema[] =
    "CREATE TABLE meta(key TEXT PRIMARY KEY, value) WITHOUT ROWID;"
    "CREATE TABLE body(id INTEGER PRIMARY KEY, hash INTEGER NOT NULL, data BLOB NOT NULL);"
    "CREATE INDEX body_hash ON body(hash);"
    "CREATE TABLE tile(layer INTEGER NOT NULL, zoom INTEGER NOT NULL, row INTEGER NOT NULL,"
    " col INTEGER NOT NULL, body INTEGER NOT NULL REFERENCES body(id), min REAL, max REAL,"
    " PRIMARY KEY(layer, zoom, row, col)) WITHOUT ROWID;";

enum statement { HAS, FIND_BODY, ADD_BODY, ADD_TILE, GET, WIDEN, STATEMENT_COUNT };

static const char *const statements[STATEMENT_COUNT] = {
    [HAS] = "SELECT 1 FROM tile WHERE layer = ?1 AND zoom = ?2 AND row = ?3 AND col = ?4",
    [FIND_BODY] = "SELECT id FROM body WHERE hash = ?1 AND data = ?2",
    [ADD_BODY] = "INSERT INTO body(hash, data) VALUES(?1, ?2)",
    [ADD_TILE] = "INSERT OR REPLACE INTO tile(layer, zoom, row, col, body, min, max)"
                 " VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7)",
    [GET] = "SELECT data, hash, min, max FROM tile JOIN body ON body.id = tile.body"
            " WHERE layer = ?1 AND zoom = ?2 AND row = ?3 AND col = ?4",
    [WIDEN] = "UPDATE tile SET min = min(min, ?5), max = max(max, ?6)"
              " WHERE layer = ?1 AND zoom = ?2 AND row = ?3 AND col = ?4",
};

struct planet_writer {
    sqlite3 *db;
    char *path;
    bool bulk;
    sqlite3_stmt *stmt[STATEMENT_COUNT];
};

// Removes the database and what SQLite may have left beside it.
static status remove_file(const char *path)
{
    static const char *const suffixes[] = {"", "-wal", "-shm", "-journal"};
    for (size_t i = 0; i < sizeof suffixes / sizeof suffixes[0]; i++) {
        char *name = sqlite3_mprintf("%s%s", path, suffixes[i]);
        if (!name) return ERR_MEMORY;
        int failed = unlink(name) != 0 && errno != ENOENT;
        if (failed) log_error("%s: cannot be replaced: %s", name, strerror(errno));
        sqlite3_free(name);
        if (failed) return ERR_IO;
    }
    return OK;
}

static status write_schema(struct planet_writer *w, const char *fingerprint)
{
    char sql[128];
    snprintf(sql, sizeof sql, "PRAGMA application_id = %d; PRAGMA user_version = %d",
             STORE_APPLICATION_ID, PLANET_SCHEMA_VERSION);
    struct planet_meta begun = {.ellipsoid = GEO_WGS84, .max_zoom = {-1, -1, -1}};
    status s = store_exec(w->db, w->path, "BEGIN");
    if (!s) s = store_exec(w->db, w->path, schema);
    if (!s) s = store_exec(w->db, w->path, sql);
    if (!s) s = store_meta_write(w->db, w->path, &begun);
    sqlite3_stmt *stmt = NULL;
    if (!s) s = store_prepare(w->db, w->path, "INSERT INTO meta VALUES('fingerprint', ?1)", &stmt);
    if (!s) {
        sqlite3_bind_text(stmt, 1, fingerprint, -1, SQLITE_STATIC);
        if (sqlite3_step(stmt) != SQLITE_DONE) s = store_error(w->db, w->path);
    }
    sqlite3_finalize(stmt);
    return s ? s : store_exec(w->db, w->path, "COMMIT");
}

static status check_fingerprint(struct planet_writer *w, const char *fingerprint)
{
    sqlite3_stmt *stmt;
    int version;
    status s = store_check(w->db, w->path, &version);
    if (s) return s;
    s = store_prepare(w->db, w->path, "SELECT value FROM meta WHERE key = 'fingerprint'", &stmt);
    if (!s) {
        const char *found =
            sqlite3_step(stmt) == SQLITE_ROW ? (const char *)sqlite3_column_text(stmt, 0) : NULL;
        if (!found || strcmp(found, fingerprint) != 0 || version != PLANET_SCHEMA_VERSION) {
            log_error("%s: begun with other sources or settings, cannot be resumed", w->path);
            s = ERR_ARGUMENT;
        }
    }
    sqlite3_finalize(stmt);
    return s;
}

// How the file is written. The order of the pragmas matters.
// Safe: committed every second or so; exclusive, so that a second writer is refused and no memory
// is shared through the file system.
static const char safe_sql[] = "PRAGMA page_size = 8192; PRAGMA locking_mode = EXCLUSIVE;"
                               "PRAGMA journal_mode = TRUNCATE; PRAGMA synchronous = FULL;"
                               "PRAGMA temp_store = MEMORY; PRAGMA cache_size = -16384";
// Bulk: one transaction, good for nothing if it does not come to its end.
static const char bulk_sql[] = "PRAGMA page_size = 8192; PRAGMA locking_mode = EXCLUSIVE;"
                               "PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF;"
                               "PRAGMA temp_store = MEMORY; PRAGMA cache_size = -131072";

status planet_writer_check_free(const char *path)
{
    sqlite3 *db = NULL;
    int code = SQLITE_OK;
    if (access(path, F_OK) != 0) return OK;
    if (sqlite3_open_v2(path, &db, SQLITE_OPEN_READWRITE, NULL) == SQLITE_OK)
        code = sqlite3_exec(db, "BEGIN IMMEDIATE", NULL, NULL, NULL);
    sqlite3_close(db);
    if (code != SQLITE_BUSY && code != SQLITE_LOCKED) return OK; // other faults: of the use proper
    log_error("%s: is being written by another program", path);
    return ERR_IO;
}

static status open_database(struct planet_writer *w, const char *fingerprint, bool resume)
{
    status s = planet_writer_check_free(w->path);
    if (!s && !resume) s = remove_file(w->path);
    if (s) return s;
    int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX;
    if (sqlite3_open_v2(w->path, &w->db, flags, NULL) != SQLITE_OK)
        return store_error(w->db, w->path);
    int pages = 0;
    s = store_query_int(w->db, w->path, "PRAGMA page_count", &pages);
    if (!s) s = store_exec(w->db, w->path, w->bulk ? bulk_sql : safe_sql);
    if (!s) s = pages == 0 ? write_schema(w, fingerprint) : check_fingerprint(w, fingerprint);
    for (int i = 0; !s && i < STATEMENT_COUNT; i++)
        s = store_prepare(w->db, w->path, statements[i], &w->stmt[i]);
    return s ? s : store_exec(w->db, w->path, "BEGIN IMMEDIATE");
}

static void discard(struct planet_writer **writer)
{
    struct planet_writer *w = *writer;
    for (int i = 0; i < STATEMENT_COUNT; i++) sqlite3_finalize(w->stmt[i]);
    sqlite3_close(w->db);
    free(w->path);
    free(w);
    *writer = NULL;
}

static status open_writer(const char *path, const char *fingerprint, bool resume, bool bulk,
                          struct planet_writer **out)
{
    struct planet_writer *w = NEW(struct planet_writer);
    w->path = NEW_ARRAY(char, strlen(path) + 1);
    w->bulk = bulk;
    strcpy(w->path, path);
    status s = open_database(w, fingerprint, resume);
    if (s) discard(&w);
    *out = w;
    return s;
}

status planet_writer_open(const char *path, const char *fingerprint, bool resume,
                          struct planet_writer **out)
{
    return open_writer(path, fingerprint, resume, false, out);
}

status planet_writer_open_bulk(const char *path, const char *fingerprint,
                               struct planet_writer **out)
{
    return open_writer(path, fingerprint, false, true, out);
}

void planet_writer_close(struct planet_writer **writer)
{
    if (!*writer) return;
    struct planet_writer *w = *writer;
    if (!sqlite3_get_autocommit(w->db)) store_exec(w->db, w->path, "COMMIT");
    discard(writer);
}

bool planet_writer_has(struct planet_writer *w, tile_id id)
{
    store_bind_tile(w->stmt[HAS], id);
    bool found = sqlite3_step(w->stmt[HAS]) == SQLITE_ROW;
    sqlite3_reset(w->stmt[HAS]);
    return found;
}

static status store_body(struct planet_writer *w, const codec_blob *body, sqlite3_int64 hash,
                         sqlite3_int64 *id)
{
    sqlite3_stmt *find = w->stmt[FIND_BODY], *add = w->stmt[ADD_BODY];
    sqlite3_bind_int64(find, 1, hash);
    sqlite3_bind_blob64(find, 2, body->data, body->size, SQLITE_STATIC);
    int found = sqlite3_step(find);
    if (found == SQLITE_ROW) *id = sqlite3_column_int64(find, 0);
    sqlite3_reset(find);
    sqlite3_clear_bindings(find);
    if (found == SQLITE_ROW) return OK;
    if (found != SQLITE_DONE) return store_error(w->db, w->path);
    sqlite3_bind_int64(add, 1, hash);
    sqlite3_bind_blob64(add, 2, body->data, body->size, SQLITE_STATIC);
    status s = sqlite3_step(add) == SQLITE_DONE ? OK : store_error(w->db, w->path);
    sqlite3_reset(add);
    sqlite3_clear_bindings(add);
    *id = sqlite3_last_insert_rowid(w->db);
    return s;
}

status planet_writer_put(struct planet_writer *w, tile_id id, const codec_blob *body, float min,
                         float max)
{
    return planet_writer_put_hashed(w, id, body, store_hash(body->data, body->size), min, max);
}

status planet_writer_put_hashed(struct planet_writer *w, tile_id id, const codec_blob *body,
                                int64_t hash, float min, float max)
{
    sqlite3_int64 body_id = 0;
    status s = store_body(w, body, hash, &body_id);
    if (s) return s;
    sqlite3_stmt *add = w->stmt[ADD_TILE];
    store_bind_tile(add, id);
    sqlite3_bind_int64(add, 5, body_id);
    sqlite3_bind_double(add, 6, (double)min); // NaN becomes NULL
    sqlite3_bind_double(add, 7, (double)max);
    s = sqlite3_step(add) == SQLITE_DONE ? OK : store_error(w->db, w->path);
    sqlite3_reset(add);
    return s;
}

status planet_writer_get(struct planet_writer *w, tile_id id, codec_blob *body, float *min,
                         float *max)
{
    return store_get_body(w->db, w->path, PLANET_SCHEMA_VERSION, w->stmt[GET], id, body, min, max);
}

status planet_writer_widen(struct planet_writer *w, tile_id id, double min, double max)
{
    sqlite3_stmt *stmt = w->stmt[WIDEN];
    store_bind_tile(stmt, id);
    sqlite3_bind_double(stmt, 5, min);
    sqlite3_bind_double(stmt, 6, max);
    status s = sqlite3_step(stmt) == SQLITE_DONE ? OK : store_error(w->db, w->path);
    sqlite3_reset(stmt);
    return s;
}

status planet_writer_commit(struct planet_writer *w)
{
    if (!sqlite3_get_autocommit(w->db)) {
        status s = store_exec(w->db, w->path, "COMMIT");
        if (s) return s;
    }
    return store_exec(w->db, w->path, "BEGIN IMMEDIATE");
}

status planet_writer_seal(struct planet_writer *w)
{
    status s = OK;
    if (!sqlite3_get_autocommit(w->db)) s = store_exec(w->db, w->path, "COMMIT");
    if (!s) s = store_exec(w->db, w->path, "PRAGMA wal_checkpoint(TRUNCATE)");
    return s ? s : store_exec(w->db, w->path, "BEGIN IMMEDIATE");
}

status planet_writer_keep_log(struct planet_writer *w, bool keep)
{
    status s = sqlite3_get_autocommit(w->db) ? OK : store_exec(w->db, w->path, "COMMIT");
    if (!s)
        s = store_exec(w->db, w->path,
                       keep ? "PRAGMA journal_mode = WAL; PRAGMA wal_autocheckpoint = 0"
                            : "PRAGMA journal_mode = TRUNCATE");
    return s ? s : store_exec(w->db, w->path, "BEGIN IMMEDIATE");
}

int planet_writer_max_zoom(struct planet_writer *w, enum tile_layer layer)
{
    char sql[96];
    int zoom = -1;
    snprintf(sql, sizeof sql, "SELECT ifnull(max(zoom), -1) FROM tile WHERE layer = %d", layer);
    return store_query_int(w->db, w->path, sql, &zoom) ? -1 : zoom;
}

status planet_writer_sample(struct planet_writer *w, enum tile_layer layer, int zoom, int limit,
                            tile_id *ids, int *count)
{
    *count = 0;
    char sql[128];
    int total = 0;
    snprintf(sql, sizeof sql, "SELECT count(*) FROM tile WHERE layer = %d AND zoom = %d", layer,
             zoom);
    status s = store_query_int(w->db, w->path, sql, &total);
    if (s) return s;
    sqlite3_stmt *stmt;
    snprintf(sql, sizeof sql, "SELECT row, col FROM tile WHERE layer = %d AND zoom = %d", layer,
             zoom);
    s = store_prepare(w->db, w->path, sql, &stmt);
    int every = (total + limit - 1) / limit, code = SQLITE_DONE;
    for (int i = 0; !s && (code = sqlite3_step(stmt)) == SQLITE_ROW; i++)
        if (i % every == every / 2)
            ids[(*count)++] =
                (tile_id){layer, zoom, sqlite3_column_int(stmt, 0), sqlite3_column_int(stmt, 1)};
    if (!s && code != SQLITE_DONE) s = store_error(w->db, w->path);
    sqlite3_finalize(stmt);
    return s;
}

// What the tiles themselves say: finest zoom of each layer, and the range of all heights.
static status measure_tiles(struct planet_writer *w, struct planet_meta *m)
{
    for (int layer = 0; layer < LAYER_COUNT; layer++)
        m->max_zoom[layer] = planet_writer_max_zoom(w, (enum tile_layer)layer);
    sqlite3_stmt *stmt;
    status s = store_prepare(w->db, w->path,
                             "SELECT ifnull(min(min), 0), ifnull(max(max), 0) FROM tile"
                             " WHERE layer = 0",
                             &stmt);
    if (!s && sqlite3_step(stmt) != SQLITE_ROW) s = store_error(w->db, w->path);
    if (!s) {
        m->height_min = sqlite3_column_double(stmt, 0);
        m->height_max = sqlite3_column_double(stmt, 1);
    }
    sqlite3_finalize(stmt);
    return s;
}

status planet_writer_finish(struct planet_writer *w, const struct planet_meta *meta)
{
    struct planet_meta m = *meta;
    m.complete = true;
    status s = measure_tiles(w, &m);
    if (!s) s = store_meta_write(w->db, w->path, &m);
    if (!s) s = store_exec(w->db, w->path, "COMMIT");
    // Without a log: it is folded in and removed.
    return s || w->bulk ? s : store_exec(w->db, w->path, "PRAGMA journal_mode = DELETE");
}
