// A database that is ours and corrupt is thrown away and made anew: it holds nothing that the
// servers do not.
#include "planet/disk_cache_db.h"

#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/memory.h"
#include "planet/store.h"

enum { APPLICATION_ID = 0x50524743, VERSION = 1, KEY_BYTES = 256, BUSY_MS = 2000 };

enum statement { GET, PUT, RENEW, FORGET, USE, TOTAL, EVICT, STATEMENTS };

struct disk_db {
    sqlite3 *db;
    sqlite3_stmt *stmt[STATEMENTS];
};

static const char *const sqls[STATEMENTS] = {
    [GET] = "SELECT data, hash, etag, modified, fetched, expires FROM item WHERE url = ?1",
    [PUT] = "INSERT OR REPLACE INTO item(url, used, fetched, expires, etag, modified, hash, size,"
            " data) VALUES(?1, (SELECT uses FROM state), ?2, ?3, ?4, ?5, ?6, ?7, ?8)",
    [RENEW] = "UPDATE item SET fetched = ?2, expires = ?3, used = (SELECT uses FROM state)"
              " WHERE url = ?1",
    [FORGET] = "DELETE FROM item WHERE url = ?1",
    [USE] = "UPDATE item SET used = (SELECT uses FROM state) WHERE url = ?1",
    [TOTAL] = "SELECT total FROM state",
    [EVICT] = "DELETE FROM item WHERE url IN (SELECT url FROM item ORDER BY used LIMIT 16)",
};

static const char schema[] =
    "BEGIN IMMEDIATE;"
    "CREATE TABLE IF NOT EXISTS item(url TEXT PRIMARY KEY, used INTEGER NOT NULL, fetched INTEGER,"
    " expires INTEGER, etag TEXT, modified TEXT, hash INTEGER, size INTEGER NOT NULL, data BLOB);"
    "CREATE INDEX IF NOT EXISTS item_used ON item(used);"
    "CREATE TABLE IF NOT EXISTS state(id INTEGER PRIMARY KEY CHECK (id = 1), total INTEGER, uses"
    " INTEGER);"
    "INSERT OR IGNORE INTO state VALUES(1, 0, 0);"
    "CREATE TRIGGER IF NOT EXISTS item_in AFTER INSERT ON item BEGIN"
    " UPDATE state SET total = total + new.size; END;"
    "CREATE TRIGGER IF NOT EXISTS item_out AFTER DELETE ON item BEGIN"
    " UPDATE state SET total = total - old.size; END;"
    "PRAGMA application_id = 1347569475; PRAGMA user_version = 1;"
    "COMMIT";

static int query_int(sqlite3 *db, const char *sql)
{
    sqlite3_stmt *stmt = NULL;
    int value = -1;
    if (sqlite3_prepare_v2(db, sql, -1, &stmt, NULL) == SQLITE_OK &&
        sqlite3_step(stmt) == SQLITE_ROW)
        value = sqlite3_column_int(stmt, 0);
    sqlite3_finalize(stmt);
    return value;
}

// Is it a database, and not ours? Somebody may be making it meanwhile, in one
// transaction: what is asked last is there when its tables are.
static bool is_foreign(sqlite3 *db)
{
    if (query_int(db, "SELECT count(*) FROM sqlite_schema") <= 0) return false; // < 0: unreadable
    return query_int(db, "PRAGMA application_id") != APPLICATION_ID ||
           query_int(db, "PRAGMA user_version") != VERSION;
}

static int prepare(struct disk_db *d, const char *path, bool read_only)
{
    char *uri = sqlite3_mprintf("file:%s%s", path, read_only ? "?immutable=1" : "");
    int flags = SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX;
    flags |= read_only ? SQLITE_OPEN_READONLY : SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
    int code = sqlite3_open_v2(read_only ? uri : path, &d->db, flags, NULL);
    sqlite3_free(uri);
    if (code) return code;
    sqlite3_busy_timeout(d->db, BUSY_MS);
    if (is_foreign(d->db)) return -1;
    // Each database holds triggers of its own: recursive_triggers lets REPLACE fire the one of
    // DELETE.
    if (!read_only)
        code = sqlite3_exec(d->db,
                            "PRAGMA auto_vacuum = INCREMENTAL; PRAGMA journal_mode = WAL;"
                            "PRAGMA synchronous = NORMAL; PRAGMA recursive_triggers = ON",
                            NULL, NULL, NULL);
    if (!code && !read_only) code = sqlite3_exec(d->db, schema, NULL, NULL, NULL);
    for (int i = 0; !code && i < STATEMENTS; i++)
        code = sqlite3_prepare_v3(d->db, sqls[i], -1, SQLITE_PREPARE_PERSISTENT, &d->stmt[i], NULL);
    return code;
}

static void close_all(struct disk_db *d)
{
    for (int i = 0; i < STATEMENTS; i++) {
        sqlite3_finalize(d->stmt[i]);
        d->stmt[i] = NULL;
    }
    sqlite3_close(d->db);
    d->db = NULL;
}

// Two that make the file at once may get in each other's way without SQLite waiting for it.
static int prepare_patiently(struct disk_db *d, const char *path, bool read_only)
{
    const double step_s = 0.02, longest_s = 4;
    for (double waited = 0;; waited += step_s) {
        int code = prepare(d, path, read_only);
        if ((code & 0xff) != SQLITE_BUSY || waited >= longest_s) return code;
        close_all(d);
        clock_sleep_s(step_s);
    }
}

// Does the header of the file say that it is ours?
static bool header_is_ours(const char *path)
{
    unsigned char head[72] = {0};
    FILE *f = fopen(path, "rb");
    bool ours = f && fread(head, 1, sizeof head, f) == sizeof head &&
                memcmp(head, "SQLite format 3", 16) == 0 && head[68] == 0x50 && head[69] == 0x52 &&
                head[70] == 0x47 && head[71] == 0x43;
    if (f) fclose(f);
    return ours;
}

static void throw_away(const char *path)
{
    static const char *const suffixes[] = {"", "-wal", "-shm"};
    for (int i = 0; i < 3; i++) {
        char *name = sqlite3_mprintf("%s%s", path, suffixes[i]);
        if (name) unlink(name);
        sqlite3_free(name);
    }
}

status disk_db_open(const char *path, bool read_only, char *why, struct disk_db **out)
{
    struct disk_db *d = NEW(struct disk_db);
    *out = NULL;
    int code = prepare_patiently(d, path, read_only);
    if ((code & 0xff) == SQLITE_CORRUPT && !read_only && header_is_ours(path)) {
        close_all(d);
        throw_away(path);
        code = prepare(d, path, read_only);
    }
    if (!code) {
        *out = d;
        return OK;
    }
    snprintf(why, 256, "%s", code < 0 ? "not a tile cache" : sqlite3_errmsg(d->db));
    close_all(d);
    free(d);
    return code < 0 || code == SQLITE_NOTADB ? ERR_FORMAT : ERR_IO;
}

void disk_db_close(struct disk_db **db)
{
    if (!*db) return;
    close_all(*db);
    free(*db);
    *db = NULL;
}

const char *disk_db_message(struct disk_db *d)
{
    return sqlite3_errmsg(d->db);
}

static void copy_text(sqlite3_stmt *stmt, int col, char out[DISK_TAG_SIZE])
{
    const char *text = (const char *)sqlite3_column_text(stmt, col);
    snprintf(out, DISK_TAG_SIZE, "%s", text ? text : "");
}

// The row of GET. A body that is not what was written is none.
static status read_row(sqlite3_stmt *stmt, disk_item *out)
{
    const void *data = sqlite3_column_blob(stmt, 0);
    size_t size = (size_t)sqlite3_column_bytes(stmt, 0);
    int64_t now = (int64_t)time(NULL), fetched = sqlite3_column_int64(stmt, 4);
    if (data && sqlite3_column_int64(stmt, 1) != store_hash(data, size)) return ERR_NOT_FOUND;
    if (data) {
        out->data = malloc(size);
        if (!out->data) return ERR_MEMORY;
        memcpy(out->data, data, size);
        out->size = size;
    }
    copy_text(stmt, 2, out->etag);
    copy_text(stmt, 3, out->modified);
    int64_t left = sqlite3_column_int64(stmt, 5) - now;
    out->max_age_s = now >= fetched && left > 0 ? (double)left : 0;
    return OK;
}

status disk_db_get(struct disk_db *d, const char *url, disk_item *out)
{
    *out = (disk_item){0};
    sqlite3_stmt *stmt = d->stmt[GET];
    sqlite3_bind_text(stmt, 1, url, -1, SQLITE_STATIC);
    int code = sqlite3_step(stmt);
    status s = code == SQLITE_ROW    ? read_row(stmt, out)
               : code == SQLITE_DONE ? ERR_NOT_FOUND
                                     : ERR_IO;
    sqlite3_reset(stmt);
    return s;
}

status disk_db_begin(struct disk_db *d)
{
    return sqlite3_exec(d->db, "BEGIN IMMEDIATE; UPDATE state SET uses = uses + 1", NULL, NULL,
                        NULL) == SQLITE_OK
               ? OK
               : ERR_IO;
}

static void bind_put(sqlite3_stmt *stmt, const char *url, const disk_item *item)
{
    sqlite3_bind_text(stmt, 4, item->etag, -1, SQLITE_STATIC);
    sqlite3_bind_text(stmt, 5, item->modified, -1, SQLITE_STATIC);
    sqlite3_bind_int64(stmt, 6, item->data ? store_hash(item->data, item->size) : 0);
    sqlite3_bind_int64(stmt, 7, (int64_t)(item->size + strlen(url) + KEY_BYTES));
    if (item->data) sqlite3_bind_blob64(stmt, 8, item->data, item->size, SQLITE_STATIC);
    else sqlite3_bind_null(stmt, 8);
}

status disk_db_apply(struct disk_db *d, enum disk_op op, const char *url, const disk_item *item)
{
    static const enum statement of[] = {PUT, RENEW, FORGET, USE};
    sqlite3_stmt *stmt = d->stmt[of[op]];
    sqlite3_bind_text(stmt, 1, url, -1, SQLITE_STATIC);
    if (op == DISK_PUT || op == DISK_RENEW) {
        int64_t now = (int64_t)time(NULL);
        sqlite3_bind_int64(stmt, 2, now);
        sqlite3_bind_int64(stmt, 3, now + (int64_t)item->max_age_s);
    }
    if (op == DISK_PUT) bind_put(stmt, url, item);
    int code = sqlite3_step(stmt);
    sqlite3_reset(stmt);
    sqlite3_clear_bindings(stmt);
    return code == SQLITE_DONE ? OK : ERR_IO;
}

static int64_t total_of(struct disk_db *d)
{
    sqlite3_stmt *stmt = d->stmt[TOTAL];
    int64_t total = sqlite3_step(stmt) == SQLITE_ROW ? sqlite3_column_int64(stmt, 0) : 0;
    sqlite3_reset(stmt);
    return total;
}

status disk_db_end(struct disk_db *d, uint64_t max_bytes, uint64_t *total, uint64_t *evicted)
{
    int64_t bytes = total_of(d), bound = (int64_t)max_bytes;
    bool shrunk = bytes > bound;
    if (shrunk) bound -= bound / 10;
    while (shrunk && bytes > bound) {
        int code = sqlite3_step(d->stmt[EVICT]);
        sqlite3_reset(d->stmt[EVICT]);
        int gone = sqlite3_changes(d->db);
        if (code != SQLITE_DONE || !gone) break;
        *evicted += (uint64_t)gone;
        bytes = total_of(d);
    }
    if (sqlite3_exec(d->db, "COMMIT", NULL, NULL, NULL) != SQLITE_OK) return ERR_IO;
    *total = (uint64_t)(bytes > 0 ? bytes : 0);
    if (shrunk) sqlite3_exec(d->db, "PRAGMA incremental_vacuum", NULL, NULL, NULL);
    return OK;
}

void disk_db_undo(struct disk_db *d)
{
    if (!sqlite3_get_autocommit(d->db)) sqlite3_exec(d->db, "ROLLBACK", NULL, NULL, NULL);
}
