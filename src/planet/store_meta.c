// The meta table as struct planet_meta. Values read are checked: a planet file may come from
// anywhere.
#include <math.h>
#include <sqlite3.h>
#include <stdio.h>
#include <string.h>

#include "base/log.h"
#include "planet/planet_file.h"
#include "planet/store.h"

// Heights beyond these are no terrain, of any body this program can show.
#define HEIGHT_LIMIT 1e7

static status absurd(const char *path, const char *key)
{
    log_error("%s: absent or impossible value of \"%s\" in the table meta", path, key);
    return ERR_FORMAT;
}

// Steps `stmt` onto the key's row. False when absent.
static bool find(sqlite3_stmt *stmt, const char *key)
{
    sqlite3_reset(stmt);
    sqlite3_bind_text(stmt, 1, key, -1, SQLITE_STATIC);
    return sqlite3_step(stmt) == SQLITE_ROW;
}

static status read_number(sqlite3_stmt *stmt, const char *path, const char *key, double low,
                          double high, double *out)
{
    if (!find(stmt, key)) return absurd(path, key);
    int type = sqlite3_column_type(stmt, 0);
    if (type != SQLITE_INTEGER && type != SQLITE_FLOAT) return absurd(path, key);
    double v = sqlite3_column_double(stmt, 0);
    if (!(v >= low && v <= high)) return absurd(path, key);
    *out = v;
    return OK;
}

// As read_number, of what files of earlier versions have not: 0 there.
static status read_later(sqlite3_stmt *stmt, const char *path, const char *key, double high,
                         double *out)
{
    *out = 0;
    return find(stmt, key) ? read_number(stmt, path, key, 0, high, out) : OK;
}

// Control characters become spaces; a text too long is cut at a character's start.
static status read_text(sqlite3_stmt *stmt, const char *path, const char *key, char *out,
                        size_t size)
{
    if (!find(stmt, key) || sqlite3_column_type(stmt, 0) != SQLITE_TEXT) return absurd(path, key);
    const unsigned char *text = sqlite3_column_text(stmt, 0);
    size_t n = text ? (size_t)sqlite3_column_bytes(stmt, 0) : 0;
    if (n > size - 1) {
        n = size - 1;
        while (n > 0 && (text[n] & 0xc0) == 0x80) n--;
    }
    for (size_t i = 0; i < n; i++) out[i] = text[i] < 0x20 || text[i] == 0x7f ? ' ' : (char)text[i];
    out[n] = '\0';
    return OK;
}

static void max_zoom_key(int layer, char key[32])
{
    snprintf(key, 32, "max_zoom_%s", tile_layer_name((enum tile_layer)layer));
}

static status read_all(sqlite3_stmt *stmt, const char *path, struct planet_meta *m)
{
    status s = read_text(stmt, path, "name", m->name, sizeof m->name);
    if (!s) s = read_text(stmt, path, "attribution", m->attribution, sizeof m->attribution);
    if (!s) s = read_number(stmt, path, "ellipsoid_a", 1.0, 1e12, &m->ellipsoid.a);
    if (!s) s = read_number(stmt, path, "ellipsoid_b", 1.0, 1e12, &m->ellipsoid.b);
    if (!s) s = read_number(stmt, path, "height_min", -HEIGHT_LIMIT, HEIGHT_LIMIT, &m->height_min);
    if (!s) s = read_number(stmt, path, "height_max", m->height_min, HEIGHT_LIMIT, &m->height_max);
    if (!s) s = read_number(stmt, path, "synthesis_gain", 0.0, 10.0, &m->synthesis_gain);
    if (!s) s = read_later(stmt, path, "height_quantum", HEIGHT_LIMIT, &m->quantum);
    if (!s) s = read_later(stmt, path, "height_quantum_finest", m->quantum, &m->quantum_finest);
    if (!s) s = read_later(stmt, path, "height_max_error", HEIGHT_LIMIT, &m->max_error);
    for (int layer = 0; !s && layer < LAYER_COUNT; layer++) {
        char key[32];
        double zoom = -1.0;
        max_zoom_key(layer, key);
        s = read_number(stmt, path, key, -1.0, GRID_MAX_ZOOM, &zoom);
        m->max_zoom[layer] = (int)zoom;
    }
    double complete = 0.0;
    if (!s) s = read_number(stmt, path, "complete", 0.0, 1.0, &complete);
    m->complete = complete != 0.0;
    return s;
}

status store_meta_read(sqlite3 *db, const char *path, struct planet_meta *out)
{
    *out = (struct planet_meta){0};
    sqlite3_stmt *stmt;
    status s = store_prepare(db, path, "SELECT value FROM meta WHERE key = ?1", &stmt);
    if (!s) s = read_all(stmt, path, out);
    sqlite3_finalize(stmt);
    return s;
}

static status write_row(sqlite3 *db, sqlite3_stmt *stmt, const char *path, const char *key)
{
    sqlite3_bind_text(stmt, 1, key, -1, SQLITE_STATIC);
    status s = sqlite3_step(stmt) == SQLITE_DONE ? OK : store_error(db, path);
    sqlite3_reset(stmt);
    return s;
}

status store_meta_write(sqlite3 *db, const char *path, const struct planet_meta *m)
{
    const struct {
        const char *key;
        double value;
    } numbers[] = {
        {"ellipsoid_a", m->ellipsoid.a},       {"ellipsoid_b", m->ellipsoid.b},
        {"height_min", m->height_min},         {"height_max", m->height_max},
        {"synthesis_gain", m->synthesis_gain}, {"complete", m->complete ? 1.0 : 0.0},
        {"height_quantum", m->quantum},        {"height_quantum_finest", m->quantum_finest},
        {"height_max_error", m->max_error}};
    sqlite3_stmt *stmt;
    status s =
        store_prepare(db, path, "INSERT OR REPLACE INTO meta(key, value) VALUES(?1, ?2)", &stmt);
    for (size_t i = 0; !s && i < sizeof numbers / sizeof numbers[0]; i++) {
        sqlite3_bind_double(stmt, 2, numbers[i].value);
        s = write_row(db, stmt, path, numbers[i].key);
    }
    for (int layer = 0; !s && layer < LAYER_COUNT; layer++) {
        char key[32];
        max_zoom_key(layer, key);
        sqlite3_bind_int(stmt, 2, m->max_zoom[layer]);
        s = write_row(db, stmt, path, key);
    }
    if (!s) {
        sqlite3_bind_text(stmt, 2, m->name, -1, SQLITE_STATIC);
        s = write_row(db, stmt, path, "name");
    }
    if (!s) {
        sqlite3_bind_text(stmt, 2, m->attribution, -1, SQLITE_STATIC);
        s = write_row(db, stmt, path, "attribution");
    }
    sqlite3_finalize(stmt);
    return s;
}
