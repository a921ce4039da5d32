#include "planet/planet_part.h"

#include <sqlite3.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/log.h"
#include "base/memory.h"
#include "planet/store.h"

enum statement { HAS, GET, WALK, STATEMENT_COUNT };

static const char *const statements[STATEMENT_COUNT] = {
    [HAS] = "SELECT 1 FROM tile WHERE layer = ?1 AND zoom = ?2 AND row = ?3 AND col = ?4",
    [GET] = "SELECT data, hash, min, max FROM tile JOIN body ON body.id = tile.body"
            " WHERE layer = ?1 AND zoom = ?2 AND row = ?3 AND col = ?4",
    [WALK] = "SELECT data, hash, min, max, layer, zoom, row, col FROM tile"
             " CROSS JOIN body ON body.id = tile.body ORDER BY layer, zoom, row, col",
};

struct planet_part {
    sqlite3 *db;
    char *path;
    int version;
    sqlite3_stmt *stmt[STATEMENT_COUNT];
};

static status open_database(struct planet_part *p)
{
    if (access(p->path, F_OK) != 0) {
        log_error("%s: is not there", p->path);
        return ERR_NOT_FOUND;
    }
    char *uri = store_uri(p->path, true);
    int flags = SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX;
    int code = sqlite3_open_v2(uri, &p->db, flags, NULL);
    free(uri);
    if (code != SQLITE_OK) return store_error(p->db, p->path);
    store_restrict(p->db);
    status s = store_check(p->db, p->path, &p->version);
    for (int i = 0; !s && i < STATEMENT_COUNT; i++)
        s = store_prepare(p->db, p->path, statements[i], &p->stmt[i]);
    return s;
}

status planet_part_open(const char *path, struct planet_part **out)
{
    struct planet_part *p = NEW(struct planet_part);
    p->path = NEW_ARRAY(char, strlen(path) + 1);
    strcpy(p->path, path);
    status s = open_database(p);
    if (s) planet_part_close(&p);
    *out = p;
    return s;
}

void planet_part_close(struct planet_part **part)
{
    struct planet_part *p = *part;
    if (!p) return;
    for (int i = 0; i < STATEMENT_COUNT; i++) sqlite3_finalize(p->stmt[i]);
    sqlite3_close(p->db);
    free(p->path);
    free(p);
    *part = NULL;
}

bool planet_part_has(struct planet_part *p, tile_id id)
{
    store_bind_tile(p->stmt[HAS], id);
    bool found = sqlite3_step(p->stmt[HAS]) == SQLITE_ROW;
    sqlite3_reset(p->stmt[HAS]);
    return found;
}

status planet_part_get(struct planet_part *p, tile_id id, codec_blob *body, float *min, float *max)
{
    return store_get_body(p->db, p->path, p->version, p->stmt[GET], id, body, min, max);
}

status planet_part_next(struct planet_part *p, planet_row *row)
{
    sqlite3_stmt *w = p->stmt[WALK];
    int code = sqlite3_step(w);
    if (code == SQLITE_DONE) return ERR_NOT_FOUND;
    if (code != SQLITE_ROW) return store_error(p->db, p->path);
    int layer = sqlite3_column_int(w, 4);
    *row = (planet_row){
        .id = {layer >= 0 && layer < LAYER_COUNT ? (enum tile_layer)layer : LAYER_HEIGHT,
               sqlite3_column_int(w, 5), sqlite3_column_int(w, 6), sqlite3_column_int(w, 7)},
        .body = {(unsigned char *)sqlite3_column_blob(w, 0), (size_t)sqlite3_column_bytes(w, 0)},
        .min = store_float(w, 2),
        .max = store_float(w, 3),
        .hash = sqlite3_column_int64(w, 1)};
    status s =
        store_check_body(p->path, p->version, row->id, row->body.data, row->body.size, row->hash);
    if (!s && p->version < PLANET_SCHEMA_VERSION)
        row->hash = store_hash(row->body.data, row->body.size);
    return s;
}

char *planet_part_fingerprint(struct planet_part *p)
{
    sqlite3_stmt *stmt;
    char *text = NULL;
    if (store_prepare(p->db, p->path, "SELECT value FROM meta WHERE key = 'fingerprint'", &stmt))
        return NULL;
    if (sqlite3_step(stmt) == SQLITE_ROW && sqlite3_column_type(stmt, 0) == SQLITE_TEXT) {
        text = NEW_ARRAY(char, (size_t)sqlite3_column_bytes(stmt, 0) + 1);
        strcpy(text, (const char *)sqlite3_column_text(stmt, 0));
    }
    sqlite3_finalize(stmt);
    return text;
}

status planet_part_count(struct planet_part *p, uint64_t *tiles)
{
    int count = 0;
    status s = store_query_int(p->db, p->path, "SELECT count(*) FROM tile", &count);
    *tiles = (uint64_t)count;
    return s;
}
