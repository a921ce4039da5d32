// The reader: a pool of read-only connections, each used by one call at a time. The lock guards the
// list of idle connections only; SQLite and the decoders run outside of it.
#include "planet/planet_file.h"

#include <assert.h>
#include <errno.h>
#include <math.h>
#include <pthread.h>
#include <sqlite3.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/log.h"
#include "base/memory.h"
#include "planet/cache.h"
#include "planet/codec.h"
#include "planet/codec_bounded.h"
#include "planet/store.h"

struct connection {
    sqlite3 *db;
    sqlite3_stmt *read, *range;
    int version;
    struct connection *next;
};

enum { BROKEN_TILES = 256 };

struct planet_file {
    char *path;
    int version;    // of the schema
    bool immutable; // left in WAL mode with an empty log: readable without writing beside it
    struct planet_meta meta;
    pthread_mutex_t lock;
    struct connection *idle;
    tile_id broken[BROKEN_TILES]; // some parents that could not be read, and were named
    int broken_count;
    struct cache *above; // decoded tiles whose children were read; NULL: no tile needs its parent
    atomic_bool failing; // the disk did not give the last tile; told once
};

// 63 tiles: a way from zoom 0 down, and the neighbours.
enum { ABOVE_BYTES = 16 << 20 };

static const char read_sql[] =
    "SELECT body.hash, body.data FROM tile LEFT JOIN body ON body.id = tile.body"
    " WHERE layer = ?1 AND zoom = ?2 AND row = ?3 AND col = ?4";
static const char range_sql[] = "SELECT min, max FROM tile"
                                " WHERE layer = ?1 AND zoom = ?2 AND row = ?3 AND col = ?4";
static const char list_sql[] =
    "SELECT zoom, row, col FROM tile WHERE layer = ?1 ORDER BY zoom, row, col";

static status tile_fault(const struct planet_file *file, tile_id id, const char *what)
{
    log_error("%s: tile %s/%d/%d/%d: %s", file->path, tile_layer_name(id.layer), id.zoom, id.row,
              id.col, what);
    return ERR_FORMAT;
}

// SQLite could not give a tile. A disk that fails may work again: ERR_IO, which is no fault of the
// tile.
static status read_fault(struct planet_file *file, tile_id id, sqlite3 *db)
{
    status s = store_status(db);
    if (s == ERR_FORMAT) return tile_fault(file, id, sqlite3_errmsg(db));
    if (s == ERR_IO && !atomic_exchange(&file->failing, true))
        log_error("%s: tile %s/%d/%d/%d: %s; going on without what cannot be read", file->path,
                  tile_layer_name(id.layer), id.zoom, id.row, id.col, sqlite3_errmsg(db));
    return s;
}

static void note_success(struct planet_file *file)
{
    if (atomic_exchange(&file->failing, false)) log_info("%s: can be read again", file->path);
}

static void connection_close(struct connection **connection)
{
    struct connection *c = *connection;
    if (!c) return;
    sqlite3_finalize(c->read);
    sqlite3_finalize(c->range);
    sqlite3_close(c->db);
    free(c);
    *connection = NULL;
}

static status connection_open(const struct planet_file *file, struct connection **out)
{
    struct connection *c = NEW(struct connection);
    char *uri = store_uri(file->path, file->immutable);
    int flags = SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX;
    status s = OK;
    if (sqlite3_open_v2(uri, &c->db, flags, NULL) != SQLITE_OK) s = store_error(c->db, file->path);
    free(uri);
    if (!s) store_restrict(c->db);
    if (!s) s = store_exec(c->db, file->path, "PRAGMA cell_size_check = ON");
    if (!s) s = store_exec(c->db, file->path, "PRAGMA cache_size = -1024");
    if (!s) s = store_check(c->db, file->path, &c->version);
    if (!s) s = store_prepare(c->db, file->path, read_sql, &c->read);
    if (!s) s = store_prepare(c->db, file->path, range_sql, &c->range);
    if (s) connection_close(&c);
    *out = c;
    return s;
}

static status checkout(struct planet_file *file, struct connection **out)
{
    pthread_mutex_lock(&file->lock);
    struct connection *c = file->idle;
    if (c) file->idle = c->next;
    pthread_mutex_unlock(&file->lock);
    *out = c;
    return c ? OK : connection_open(file, out);
}

static void checkin(struct planet_file *file, struct connection *c)
{
    pthread_mutex_lock(&file->lock);
    c->next = file->idle;
    file->idle = c;
    pthread_mutex_unlock(&file->lock);
}

static uint32_t big_endian(const unsigned char *p)
{
    return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3];
}

// Looks at the database header before SQLite does: SQLite finds a truncation only on reading what
// is missing. Finds whether the file is in WAL mode without a log.
//   source  sqlite.org/fileformat2.html, 1.3
static status check_header(struct planet_file *file, FILE *stream, int64_t size)
{
    unsigned char head[100];
    if (fread(head, 1, sizeof head, stream) != sizeof head || memcmp(head, "SQLite format 3", 16)) {
        log_error("%s: not a planet file", file->path);
        return ERR_FORMAT;
    }
    int64_t page = head[16] << 8 | head[17];
    if (page == 1) page = 65536;
    bool wal = head[18] == 2, counted = big_endian(head + 24) == big_endian(head + 92);
    char *log_path = sqlite3_mprintf("%s-wal", file->path);
    bool has_log = !log_path || access(log_path, F_OK) == 0;
    sqlite3_free(log_path);
    file->immutable = wal && !has_log;
    if (counted && !has_log && size < page * big_endian(head + 28)) {
        log_error("%s: truncated: %lld of %lld bytes", file->path, (long long)size,
                  (long long)page * big_endian(head + 28));
        return ERR_FORMAT;
    }
    return OK;
}

static status check_file(struct planet_file *file)
{
    struct stat info;
    FILE *stream = fopen(file->path, "rb");
    if (!stream || fstat(fileno(stream), &info) != 0) {
        int code = errno;
        if (stream) fclose(stream);
        log_error("%s: %s", file->path, strerror(code));
        return code == ENOENT || code == ENOTDIR ? ERR_NOT_FOUND : ERR_IO;
    }
    status s = OK;
    if (!S_ISREG(info.st_mode)) {
        log_error("%s: not a planet file: not a regular file", file->path);
        s = ERR_FORMAT;
    } else {
        s = check_header(file, stream, info.st_size);
    }
    fclose(stream);
    return s;
}

static bool is_broken(struct planet_file *file, tile_id id)
{
    bool found = false;
    pthread_mutex_lock(&file->lock);
    for (int i = 0; i < file->broken_count; i++) found |= tile_id_equal(file->broken[i], id);
    pthread_mutex_unlock(&file->lock);
    return found;
}

// Its children ask for it again and again; it is named once. Beyond the room for them, tiles are
// named each time.
static void note_broken(struct planet_file *file, tile_id id)
{
    pthread_mutex_lock(&file->lock);
    if (file->broken_count < BROKEN_TILES) file->broken[file->broken_count++] = id;
    pthread_mutex_unlock(&file->lock);
}

static status make_above(void *user, struct want *want, tile_id id, void *samples,
                         struct cache_made *made)
{
    (void)want;
    (void)made;
    struct planet_file *file = user;
    if (is_broken(file, id)) return ERR_FORMAT;
    status s = planet_file_read_height(file, id, samples);
    if (s == ERR_FORMAT) note_broken(file, id);
    return s;
}

status planet_file_open(const char *path, struct planet_file **out)
{
    struct planet_file *file = NEW(struct planet_file);
    file->path = NEW_ARRAY(char, strlen(path) + 1);
    strcpy(file->path, path);
    pthread_mutex_init(&file->lock, NULL);
    status s = check_file(file);
    if (!s) s = checkout(file, &file->idle);
    if (!s) file->version = file->idle->version;
    if (!s) s = store_meta_read(file->idle->db, path, &file->meta);
    if (!s && file->meta.max_error > 0) file->above = cache_create(ABOVE_BYTES, make_above, file);
    if (s) planet_file_close(&file);
    *out = file;
    return s;
}

void planet_file_close(struct planet_file **file)
{
    struct planet_file *f = *file;
    if (!f) return;
    cache_destroy(&f->above);
    while (f->idle) {
        struct connection *c = f->idle;
        f->idle = c->next;
        connection_close(&c);
    }
    pthread_mutex_destroy(&f->lock);
    free(f->path);
    free(f);
    *file = NULL;
}

const struct planet_meta *planet_file_meta(const struct planet_file *file)
{
    return &file->meta;
}

const char *planet_file_path(const struct planet_file *file)
{
    return file->path;
}

// The statement's row is a tile's body: check it.
static status check_row(const struct planet_file *file, tile_id id, sqlite3_stmt *stmt,
                        const void **data, size_t *size)
{
    *data = sqlite3_column_blob(stmt, 1);
    *size = *data ? (size_t)sqlite3_column_bytes(stmt, 1) : 0;
    if (sqlite3_column_type(stmt, 1) != SQLITE_BLOB || *size == 0)
        return tile_fault(file, id, "its body is missing");
    return store_check_body(file->path, file->version, id, *data, *size,
                            sqlite3_column_int64(stmt, 0));
}

// Heights, or the body of what they are made of with their parent's.
struct heights {
    struct planet_file *file;
    float *samples;
    codec_blob body;
    status above; // of reading the parent
};

static status copy_body(const void *data, size_t size, codec_blob *out)
{
    out->data = malloc(size);
    if (!out->data) return ERR_MEMORY;
    memcpy(out->data, data, size);
    out->size = size;
    return OK;
}

static status decode_heights(const struct planet_file *file, tile_id id, sqlite3_stmt *stmt,
                             void *out)
{
    struct heights *h = out;
    const void *data;
    size_t size;
    status s = check_row(file, id, stmt, &data, &size);
    if (s) return s;
    // The parent is read when this row is done with.
    if (file->above && bounded_is_body(data, size)) return copy_body(data, size, &h->body);
    s = codec_height_decode(data, size, h->samples);
    return s == ERR_FORMAT ? tile_fault(file, id, "corrupt: its body is no such image") : s;
}

static status read_above(void *user, tile_id id, float *samples)
{
    struct heights *h = user;
    const pyramid_tile *tile;
    h->above = cache_acquire(h->file->above, NULL, id, &tile);
    if (h->above) return h->above;
    memcpy(samples, tile->heights, CACHE_SAMPLE_BYTES);
    cache_release(h->file->above, &tile);
    return OK;
}

static status decode_pixels(const struct planet_file *file, tile_id id, sqlite3_stmt *stmt,
                            void *out)
{
    const void *data;
    size_t size;
    status s = check_row(file, id, stmt, &data, &size);
    if (s) return s;
    s = codec_pixels_decode(data, size, id.layer == LAYER_COLOR ? 3 : 1, out);
    return s == ERR_FORMAT ? tile_fault(file, id, "corrupt: its body is no such image") : s;
}

static status copy_row(const struct planet_file *file, tile_id id, sqlite3_stmt *stmt, void *out)
{
    const void *data;
    size_t size;
    status s = check_row(file, id, stmt, &data, &size);
    return s ? s : copy_body(data, size, out);
}

typedef status (*take_row)(const struct planet_file *, tile_id, sqlite3_stmt *, void *);

static status read_tile(struct planet_file *file, tile_id id, take_row take, void *out)
{
    struct connection *c;
    status s = checkout(file, &c);
    if (s) return s;
    store_bind_tile(c->read, id);
    int code = sqlite3_step(c->read);
    if (code == SQLITE_ROW) s = take(file, id, c->read, out);
    else if (code == SQLITE_DONE) s = ERR_NOT_FOUND;
    else s = read_fault(file, id, c->db);
    if (!s) note_success(file);
    sqlite3_reset(c->read);
    checkin(file, c);
    return s;
}

status planet_file_read_body(struct planet_file *file, tile_id id, struct codec_blob *out)
{
    assert(id.layer == LAYER_COLOR || id.layer == LAYER_NIGHT);
    *out = (codec_blob){0};
    return read_tile(file, id, copy_row, out);
}

status planet_file_read_height(struct planet_file *file, tile_id id, float *heights)
{
    assert(id.layer == LAYER_HEIGHT);
    struct heights h = {.file = file, .samples = heights};
    status s = read_tile(file, id, decode_heights, &h);
    if (!s && h.body.size) {
        s = codec_height_decode_tile(id, h.body.data, h.body.size, read_above, &h, heights);
        // A parent that cannot be read has been named.
        if (s == ERR_FORMAT && h.above != ERR_FORMAT)
            tile_fault(file, id, "corrupt: its body is no such image");
    }
    codec_blob_deinit(&h.body);
    return s;
}

status planet_file_read_pixels(struct planet_file *file, tile_id id, unsigned char *pixels)
{
    assert(id.layer == LAYER_COLOR || id.layer == LAYER_NIGHT);
    return read_tile(file, id, decode_pixels, pixels);
}

status planet_file_read_range(struct planet_file *file, tile_id id, float *min, float *max)
{
    *min = *max = 0.0f;
    struct connection *c;
    status s = checkout(file, &c);
    if (s) return s;
    store_bind_tile(c->range, id);
    int code = sqlite3_step(c->range);
    if (code != SQLITE_ROW) {
        s = code == SQLITE_DONE ? ERR_NOT_FOUND : read_fault(file, id, c->db);
    } else if (sqlite3_column_type(c->range, 0) == SQLITE_NULL) {
        s = ERR_NOT_FOUND;
    } else {
        *min = (float)sqlite3_column_double(c->range, 0);
        *max = (float)sqlite3_column_double(c->range, 1);
        if (!isfinite(*min) || !isfinite(*max) || *min > *max)
            s = tile_fault(file, id, "corrupt: impossible range of heights");
    }
    sqlite3_reset(c->range);
    checkin(file, c);
    return s;
}

static const char size_sql[] =
    "SELECT (SELECT count(*) FROM tile WHERE layer = ?1), (SELECT ifnull(sum(length(data)), 0)"
    " FROM body WHERE id IN (SELECT body FROM tile WHERE layer = ?1))";

status planet_file_size(struct planet_file *file, enum tile_layer layer, uint64_t *tiles,
                        uint64_t *bytes)
{
    *tiles = *bytes = 0;
    struct connection *c;
    sqlite3_stmt *stmt = NULL;
    status s = checkout(file, &c);
    if (s) return s;
    s = store_prepare(c->db, file->path, size_sql, &stmt);
    if (!s) {
        sqlite3_bind_int(stmt, 1, layer);
        if (sqlite3_step(stmt) != SQLITE_ROW) s = store_error(c->db, file->path);
    }
    if (!s) {
        *tiles = (uint64_t)sqlite3_column_int64(stmt, 0);
        *bytes = (uint64_t)sqlite3_column_int64(stmt, 1);
    }
    sqlite3_finalize(stmt);
    checkin(file, c);
    return s;
}

// A row of the table as a tile of the grid; false when it is none.
static bool tile_of_row(sqlite3_stmt *stmt, enum tile_layer layer, tile_id *id)
{
    sqlite3_int64 zoom = sqlite3_column_int64(stmt, 0), row = sqlite3_column_int64(stmt, 1),
                  col = sqlite3_column_int64(stmt, 2);
    if (zoom < 0 || zoom > GRID_MAX_ZOOM || row < 0 || row >= grid_rows((int)zoom)) return false;
    if (col < 0 || col >= grid_cols((int)zoom, (int)row)) return false;
    *id = (tile_id){layer, (int)zoom, (int)row, (int)col};
    return true;
}

status planet_file_list(struct planet_file *file, enum tile_layer layer,
                        void (*each)(void *user, tile_id id), void *user)
{
    struct connection *c;
    status s = checkout(file, &c);
    if (s) return s;
    sqlite3_stmt *stmt;
    s = store_prepare(c->db, file->path, list_sql, &stmt);
    if (!s) {
        int code;
        tile_id id;
        sqlite3_bind_int(stmt, 1, layer);
        while ((code = sqlite3_step(stmt)) == SQLITE_ROW)
            if (tile_of_row(stmt, layer, &id)) each(user, id);
        if (code != SQLITE_DONE) s = store_error(c->db, file->path);
    }
    sqlite3_finalize(stmt);
    checkin(file, c);
    return s;
}
