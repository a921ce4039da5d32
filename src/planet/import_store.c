#include "planet/import_store.h"

#include <errno.h>
#include <glob.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/log.h"
#include "base/memory.h"
#include "planet/codec_bounded.h"
#include "planet/import_border.h"
#include "planet/import_bounded.h"
#include "planet/import_cache.h"
#include "planet/synthesis.h"

// Invariant: `lock` guards the writer and every part.
struct import_store {
    char *part, *own, *fingerprint;
    pthread_mutex_t lock;
    struct planet_writer *writer;
    struct import_base *planet;
    struct planet_part *base; // the bodies of `planet`
    struct planet_part **others;
    int other_count;
};

static char *copy_text(const char *text)
{
    char *copy = text ? NEW_ARRAY(char, strlen(text) + 1) : NULL;
    if (copy) strcpy(copy, text);
    return copy;
}

// Calls `each` with every part that is there: `part` itself and part.1, part.2, ...
static status each_part(const char *part, status (*each)(void *user, const char *path), void *user)
{
    status s = access(part, F_OK) == 0 ? each(user, part) : OK;
    size_t size = 2 * strlen(part) + 16, n = 0;
    char *pattern = NEW_ARRAY(char, size);
    for (const char *c = part; *c; c++) {
        if (strchr("*?[\\", *c)) pattern[n++] = '\\';
        pattern[n++] = *c;
    }
    strcpy(pattern + n, ".[0-9]*");
    glob_t found;
    if (!s && glob(pattern, 0, NULL, &found) == 0) {
        for (size_t i = 0; !s && i < found.gl_pathc; i++) {
            const char *tail = strrchr(found.gl_pathv[i], '.') + 1;
            if (tail[strspn(tail, "0123456789")] == '\0') s = each(user, found.gl_pathv[i]);
        }
        globfree(&found);
    }
    free(pattern);
    return s;
}

static status remove_part(void *user, const char *path)
{
    static const char *const tails[] = {"", "-wal", "-shm", "-journal"};
    (void)user;
    for (size_t i = 0; i < sizeof tails / sizeof *tails; i++) {
        char *name;
        if (asprintf(&name, "%s%s", path, tails[i]) < 0) abort();
        unlink(name);
        free(name);
    }
    return OK;
}

void import_store_remove(const char *part)
{
    each_part(part, remove_part, NULL);
    remove_part(NULL, part);
}

// Folds in what a killed writer left in its log, and checks that it is of this import.
static status mend_part(void *user, const char *path)
{
    struct import_store *store = user;
    if (!strcmp(path, store->own)) return OK;
    struct planet_writer *w;
    status s = planet_writer_open(path, store->fingerprint, true, &w);
    if (!s) s = planet_writer_seal(w);
    planet_writer_close(&w);
    return s;
}

status import_store_open(const import_store_params *params, struct import_store **out)
{
    struct import_store *store = NEW(struct import_store);
    store->part = copy_text(params->part);
    store->fingerprint = copy_text(params->fingerprint);
    store->planet = params->base;
    if (params->rank == 0) store->own = copy_text(params->part);
    else if (asprintf(&store->own, "%s.%d", params->part, params->rank) < 0) abort();
    pthread_mutex_init(&store->lock, NULL);
    // Rank 0 mends what is left of ranks that may not be there any more.
    status s = OK;
    if (!params->resume && params->rank == 0) {
        s = planet_writer_check_free(params->part);
        if (!s) import_store_remove(params->part);
    }
    if (params->resume && params->rank == 0) s = each_part(store->part, mend_part, store);
    bool resume = params->resume && access(store->own, F_OK) == 0;
    if (!s) s = planet_writer_open(store->own, store->fingerprint, resume, &store->writer);
    if (!s) s = planet_writer_seal(store->writer);
    if (!s && params->base) s = planet_part_open(import_base_path(params->base), &store->base);
    if (s) import_store_close(&store);
    *out = store;
    return s;
}

static void close_others(struct import_store *store)
{
    for (int i = 0; i < store->other_count; i++) planet_part_close(&store->others[i]);
    free(store->others);
    store->others = NULL;
    store->other_count = 0;
}

void import_store_close(struct import_store **store)
{
    struct import_store *s = *store;
    if (!s) return;
    close_others(s);
    planet_part_close(&s->base);
    planet_writer_close(&s->writer);
    pthread_mutex_destroy(&s->lock);
    free(s->part);
    free(s->own);
    free(s->fingerprint);
    free(s);
    *store = NULL;
}

status import_store_seal(struct import_store *store)
{
    pthread_mutex_lock(&store->lock);
    close_others(store);
    status s = planet_writer_seal(store->writer);
    pthread_mutex_unlock(&store->lock);
    return s;
}

// A part without a tile is passed by, so that its writer needs no log.
static status look_at(void *user, const char *path)
{
    struct import_store *store = user;
    if (!strcmp(path, store->own)) return OK;
    struct planet_part *part = NULL;
    uint64_t tiles = 0;
    status s = planet_part_open(path, &part);
    if (!s) s = planet_part_count(part, &tiles);
    if (s || !tiles) {
        planet_part_close(&part);
        return s;
    }
    struct planet_part **others = NEW_ARRAY(struct planet_part *, (size_t)store->other_count + 1);
    if (store->other_count)
        memcpy(others, store->others, (size_t)store->other_count * sizeof *others);
    free(store->others);
    store->others = others;
    others[store->other_count++] = part;
    return OK;
}

static bool holds_tiles(const struct import_store *store)
{
    bool any = false;
    for (int layer = 0; layer < LAYER_COUNT; layer++)
        any |= planet_writer_max_zoom(store->writer, (enum tile_layer)layer) >= 0;
    return any;
}

status import_store_look(struct import_store *store, bool shared)
{
    pthread_mutex_lock(&store->lock);
    close_others(store);
    status s = each_part(store->part, look_at, store);
    if (!s) s = planet_writer_keep_log(store->writer, shared && holds_tiles(store));
    pthread_mutex_unlock(&store->lock);
    return s;
}

bool import_store_has(struct import_store *store, tile_id id)
{
    pthread_mutex_lock(&store->lock);
    bool has = planet_writer_has(store->writer, id);
    for (int i = 0; i < store->other_count && !has; i++)
        has = planet_part_has(store->others[i], id);
    pthread_mutex_unlock(&store->lock);
    return has;
}

status import_store_put(struct import_store *store, tile_id id, const codec_blob *body, float min,
                        float max)
{
    pthread_mutex_lock(&store->lock);
    status s = planet_writer_put(store->writer, id, body, min, max);
    pthread_mutex_unlock(&store->lock);
    return s;
}

status import_store_get(struct import_store *store, tile_id id, codec_blob *body, float *min,
                        float *max)
{
    pthread_mutex_lock(&store->lock);
    status s = planet_writer_get(store->writer, id, body, min, max);
    for (int i = 0; i < store->other_count && s == ERR_NOT_FOUND; i++)
        s = planet_part_get(store->others[i], id, body, min, max);
    if (s == ERR_NOT_FOUND && store->base) s = planet_part_get(store->base, id, body, min, max);
    pthread_mutex_unlock(&store->lock);
    return s;
}

status import_store_base_height(void *user, tile_id id, float *heights)
{
    struct import_store *store = user;
    return store->planet ? import_base_read(store->planet, id, heights) : ERR_NOT_FOUND;
}

status import_store_commit(struct import_store *store)
{
    pthread_mutex_lock(&store->lock);
    status s = planet_writer_commit(store->writer);
    pthread_mutex_unlock(&store->lock);
    return s;
}

// The join

struct heads {
    struct import_base *base;   // NULL: none
    struct planet_part **parts; // the base last
    planet_row *rows;           // the next of each; of a part that has no more: of LAYER_COUNT
    int count;
    uint64_t total;
};

static status add_head(void *user, const char *path)
{
    struct heads *h = user;
    struct planet_part **parts = NEW_ARRAY(struct planet_part *, (size_t)h->count + 1);
    if (h->count) memcpy(parts, h->parts, (size_t)h->count * sizeof *parts);
    free(h->parts);
    h->parts = parts;
    uint64_t tiles = 0;
    status s = planet_part_open(path, &parts[h->count]);
    if (!s) s = planet_part_count(parts[h->count++], &tiles);
    h->total += tiles;
    return s;
}

static status advance(struct heads *h, int i)
{
    status s = planet_part_next(h->parts[i], &h->rows[i]);
    if (s == ERR_NOT_FOUND) h->rows[i].id.layer = LAYER_COUNT;
    return s == ERR_NOT_FOUND ? OK : s;
}

static int compare_ids(tile_id a, tile_id b)
{
    if (a.layer != b.layer) return a.layer < b.layer ? -1 : 1;
    if (a.zoom != b.zoom) return a.zoom < b.zoom ? -1 : 1;
    if (a.row != b.row) return a.row < b.row ? -1 : 1;
    return (a.col > b.col) - (a.col < b.col);
}

// The first of the heads; of equal ones the earlier part's, the others being passed over. -1: none.
static status pick(struct heads *h, int *best)
{
    *best = -1;
    for (int i = 0; i < h->count; i++) {
        if (h->rows[i].id.layer == LAYER_COUNT) continue;
        int order = *best < 0 ? -1 : compare_ids(h->rows[i].id, h->rows[*best].id);
        if (order < 0) *best = i;
        status s = order == 0 ? advance(h, i) : OK;
        if (s) return s;
    }
    return OK;
}

static bool is_height_next(const struct heads *h)
{
    for (int i = 0; i < h->count; i++)
        if (h->rows[i].id.layer == LAYER_HEIGHT) return true;
    return false;
}

// Was the tile made anew, so that it is not the base's any more?
static bool is_made(const struct heads *h, tile_id id)
{
    for (int i = 0; i < h->count - 1; i++)
        if (planet_part_has(h->parts[i], id)) return true;
    return false;
}

// A tile of the base whose parent is another now, without loss.
static status put_recoded(const struct heads *h, const planet_row *row, double max_error,
                          struct bounder *bounder)
{
    planet_row coded = *row;
    float *samples = malloc((size_t)TILE_SIZE * TILE_SIZE * sizeof *samples);
    if (!samples) return ERR_MEMORY;
    status s = import_base_read(h->base, row->id, samples);
    if (!s) s = codec_height_encode_grid(samples, bounded_exponent(max_error), &coded.body);
    if (!s) s = bounder_keep(bounder, &coded);
    if (coded.body.data != row->body.data) codec_blob_deinit(&coded.body);
    free(samples);
    return s;
}

static status put_bounded(const struct heads *h, int from, double max_error,
                          struct bounder *bounder)
{
    planet_row row = h->rows[from];
    if (h->base && from == h->count - 1) {
        bool other = row.id.zoom > 0 && is_made(h, tile_parent(row.id));
        return other ? put_recoded(h, &row, max_error, bounder) : bounder_keep(bounder, &row);
    }
    if (!h->base || !import_base_has(h->base, row.id)) return bounder_put(bounder, &row);
    row.min -= (float)max_error; // of tiles below that are coded
    row.max += (float)max_error;
    return bounder_keep(bounder, &row);
}

// A border_gaps, of the tile as the join will find it.
static status find_gaps(void *user, tile_id id, unsigned char *mask)
{
    const struct heads *h = user;
    for (int i = 0; i < h->count - (h->base != NULL); i++) {
        codec_blob body;
        float min, max;
        status s = planet_part_get(h->parts[i], id, &body, &min, &max);
        if (s == ERR_NOT_FOUND) continue;
        if (!s) s = codec_height_gaps(body.data, body.size, mask);
        codec_blob_deinit(&body);
        return s;
    }
    return h->base ? import_base_gaps(h->base, id, mask) : ERR_NOT_FOUND;
}

struct joining {
    const import_join *join;
    struct heads heads;
    struct planet_writer *writer;
    struct bounder *bounder; // NULL: bodies stay as they are
    int zoom;                // of the heights before
};

// The next tile of heights, mended where borders and holes of finer data are in it.
static status put_height(struct joining *j, int from)
{
    struct heads *h = &j->heads;
    planet_row was = h->rows[from], *row = &h->rows[from];
    bool made = !h->base || from < h->count - 1, mended = false;
    double max_error = j->join->meta->max_error;
    status s = OK;
    if (j->bounder && row->id.zoom != j->zoom) s = bounder_flush(j->bounder);
    j->zoom = row->id.zoom;
    if (!s && made && j->join->border)
        s = border_mend(j->join->border, j->writer, max_error, row, &mended);
    if (!s && j->bounder) s = put_bounded(h, from, max_error, j->bounder);
    else if (!s)
        s = planet_writer_put_hashed(j->writer, row->id, &row->body, row->hash, row->min, row->max);
    if (mended) codec_blob_deinit(&row->body);
    if (mended && j->join->kept) import_cache_drop(j->join->kept, row->id);
    *row = was;
    return s;
}

static status join_rows(struct joining *j, uint64_t *tiles)
{
    const import_join *join = j->join;
    struct heads *h = &j->heads;
    status s = OK;
    h->rows = NEW_ARRAY(planet_row, (size_t)h->count + 1);
    for (int i = 0; !s && i < h->count; i++) s = advance(h, i);
    *tiles = 0;
    for (int best; !s && !(s = pick(h, &best)) && best >= 0; ++*tiles) {
        const planet_row *r = &h->rows[best];
        bool height = r->id.layer == LAYER_HEIGHT;
        if (height) s = put_height(j, best);
        else s = planet_writer_put_hashed(j->writer, r->id, &r->body, r->hash, r->min, r->max);
        if (!s) s = advance(h, best);
        // Heights come first; they are all written before another layer's tile is.
        if (!s && j->bounder && height && !is_height_next(h)) s = bounder_flush(j->bounder);
        if (!s && *tiles % 64 == 0 && join->progress &&
            join->progress(join->user, (double)*tiles / (double)(h->total + 1)))
            s = ERR_CANCELLED;
    }
    return s;
}

static bool copy_kept(void *cache, tile_id id, float *heights)
{
    return import_cache_copy(cache, id, heights);
}

status import_store_join(struct import_store *store, import_join *join)
{
    struct joining j = {.join = join, .heads = {.base = store->planet}};
    struct heads *h = &j.heads;
    double max_error = join->meta->max_error;
    status s = each_part(store->part, add_head, h);
    if (!s && store->planet) s = add_head(h, import_base_path(store->planet));
    if (join->border) border_reads(join->border, find_gaps, h);
    if (!s) s = planet_writer_open_bulk(join->path, store->fingerprint, &j.writer);
    if (!s && max_error > 0) j.bounder = bounder_create(j.writer, max_error, join->threads);
    if (!s) s = join_rows(&j, &join->tiles);
    bounder_destroy(&j.bounder);
    if (!s)
        s = planet_measure_gain(j.writer, join->meta->ellipsoid.a, join->threads,
                                join->kept && max_error == 0 ? copy_kept : NULL, join->kept,
                                &join->meta->synthesis_gain);
    if (!s) s = planet_writer_finish(j.writer, join->meta);
    planet_writer_close(&j.writer);
    for (int i = 0; i < h->count; i++) planet_part_close(&h->parts[i]);
    free(h->parts);
    free(h->rows);
    return s;
}
