#include "planet/import.h"

#include <cpl_vsi.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/pool.h"
#include "planet/import_blend.h"
#include "planet/import_inputs.h"
#include "planet/import_sources.h"
#include "planet/import_tile.h"
#include "planet/synthesis.h"

// Raise when the same sources and settings give other tiles, so that an import begun before is not
// gone on with.
enum { IMPORT_VERSION = 2, CACHE_BYTES = 192 << 20 };
#define COMMIT_SECONDS   1.0
#define PROGRESS_SECONDS 0.2

// One import under way. `lock` guards the writer and what stands below it.
struct import {
    const import_params *params;
    const import_input *inputs;
    raster_grid *grids;
    int count;
    plan_bounds bounds;
    geo_ellipsoid ellipsoid;
    struct pool *pool;
    struct workshop *workshop;
    const char *stage;
    uint64_t stage_tiles;
    double committed_s, reported_s;
    pthread_mutex_t lock;
    pthread_cond_t finished;
    struct planet_writer *writer;
    status failed;
    uint64_t done, stored;
    int running;
};

struct job {
    struct import *import;
    tile_id id;
};

static double now_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void run_job(void *arg, int worker)
{
    struct job *job = arg;
    struct import *im = job->import;
    codec_blob body = {0};
    float min = 0, max = 0;
    pthread_mutex_lock(&im->lock);
    status s = im->failed;
    pthread_mutex_unlock(&im->lock);
    if (!s) s = workshop_make(im->workshop, worker, job->id, &body, &min, &max);
    pthread_mutex_lock(&im->lock);
    if (!s && !im->failed && body.size) {
        s = planet_writer_put(im->writer, job->id, &body, min, max);
        im->stored++;
    }
    if (s && !im->failed) im->failed = s;
    im->done++;
    im->running--;
    pthread_cond_signal(&im->finished);
    pthread_mutex_unlock(&im->lock);
    codec_blob_deinit(&body);
    free(job);
}

// Lock held. Commits and reports when it is time; a request to stop becomes im->failed.
static void tend(struct import *im)
{
    double now = now_s();
    if (!im->failed && now - im->committed_s > COMMIT_SECONDS) {
        im->failed = planet_writer_commit(im->writer);
        im->committed_s = now_s();
    }
    if (im->failed || !im->params->progress || now - im->reported_s < PROGRESS_SECONDS) return;
    im->reported_s = now;
    double done = im->stage_tiles ? (double)im->done / (double)im->stage_tiles : 1;
    pthread_mutex_unlock(&im->lock);
    bool stop = im->params->progress(im->params->user, im->stage, done);
    pthread_mutex_lock(&im->lock);
    if (stop && !im->failed) im->failed = ERR_CANCELLED;
}

// Lock held. Waits until fewer than `limit` jobs are under way.
static void wait_below(struct import *im, int limit)
{
    tend(im);
    while (im->running >= limit) {
        struct timespec until;
        clock_gettime(CLOCK_REALTIME, &until);
        until.tv_nsec += 50 * 1000 * 1000;
        until.tv_sec += until.tv_nsec / 1000000000;
        until.tv_nsec %= 1000000000;
        pthread_cond_timedwait(&im->finished, &im->lock, &until);
        tend(im);
    }
}

static status make_zoom(struct import *im, enum tile_layer layer, int zoom,
                        const raster_grid *grids, int count)
{
    struct plan_walk *walk = plan_walk_begin(layer, zoom, grids, count, &im->bounds);
    int limit = 4 * pool_threads(im->pool);
    tile_id id;
    pthread_mutex_lock(&im->lock);
    while (!im->failed && plan_walk_next(walk, &id)) {
        if (planet_writer_has(im->writer, id)) {
            im->done++;
            im->stored++;
            tend(im);
            continue;
        }
        wait_below(im, limit);
        if (im->failed) break;
        im->running++;
        pthread_mutex_unlock(&im->lock);
        struct job *job = NEW(struct job);
        *job = (struct job){im, id};
        pool_submit(im->pool, run_job, job);
        pthread_mutex_lock(&im->lock);
    }
    wait_below(im, 1);
    status s = im->failed;
    pthread_mutex_unlock(&im->lock);
    plan_walk_end(&walk);
    return s;
}

static uint64_t count_tiles(struct import *im, enum tile_layer layer, int max_zoom,
                            const raster_grid *grids, int count)
{
    uint64_t n = 0;
    for (int zoom = 0; zoom <= max_zoom; zoom++) {
        struct plan_walk *walk = plan_walk_begin(layer, zoom, grids, count, &im->bounds);
        tile_id id;
        while (plan_walk_next(walk, &id)) n++;
        plan_walk_end(&walk);
    }
    return n;
}

static status make_layer(struct import *im, enum tile_layer layer)
{
    static const char *const stages[LAYER_COUNT] = {"heights", "colour", "night"};
    import_input *inputs = NEW_ARRAY(import_input, (size_t)im->count);
    raster_grid *grids = NEW_ARRAY(raster_grid, (size_t)im->count);
    int count = 0, max_zoom = -1;
    for (int i = 0; i < im->count; i++) {
        if (im->inputs[i].source.layer != layer) continue;
        inputs[count] = im->inputs[i];
        grids[count++] = im->grids[i];
        if (im->grids[i].zoom > max_zoom) max_zoom = im->grids[i].zoom;
    }
    status s = OK;
    if (count) {
        struct import_cache *cache = import_cache_create(im->writer, &im->lock, CACHE_BYTES);
        im->workshop = workshop_create(&(workshop_params){.inputs = inputs,
                                                          .grids = grids,
                                                          .count = count,
                                                          .workers = pool_threads(im->pool),
                                                          .ellipsoid = im->ellipsoid,
                                                          .bounds = im->bounds,
                                                          .feather = im->params->feather_rows,
                                                          .cache = cache});
        im->stage = stages[layer];
        im->done = 0;
        im->stage_tiles = count_tiles(im, layer, max_zoom, grids, count);
        for (int zoom = max_zoom; !s && zoom >= 0; zoom--)
            s = make_zoom(im, layer, zoom, grids, count);
        workshop_destroy(&im->workshop);
        import_cache_destroy(&cache);
    }
    free(inputs);
    free(grids);
    return s;
}

static status open_grids(struct import *im)
{
    for (int i = 0; i < im->count; i++) {
        struct raster *raster;
        status s = raster_open(&im->inputs[i], im->ellipsoid, &raster);
        if (s) return s;
        im->grids[i] = *raster_get_grid(raster);
        raster_close(&raster);
    }
    return OK;
}

static status read_bounds(const double deg[4], plan_bounds *b)
{
    const double rad = M_PI / 180;
    *b = (plan_bounds){-M_PI, -M_PI / 2, M_PI, M_PI / 2};
    if (deg[0] == 0 && deg[1] == 0 && deg[2] == 0 && deg[3] == 0) return OK;
    double width = deg[2] > deg[0] ? deg[2] - deg[0] : deg[2] - deg[0] + 360;
    bool good = deg[1] >= -90 && deg[3] <= 90 && deg[1] < deg[3] && fabs(deg[0]) <= 360 &&
                fabs(deg[2]) <= 360 && width > 0 && width <= 360;
    if (!good) {
        log_error("bounds %g,%g,%g,%g are not west,south,east,north in degrees", deg[0], deg[1],
                  deg[2], deg[3]);
        return ERR_ARGUMENT;
    }
    double west = geo_wrap_lon(deg[0] * rad);
    *b = (plan_bounds){west, deg[1] * rad, west + width * rad, deg[3] * rad};
    return OK;
}

// Names everything that the tiles depend on. Freed by the caller.
static char *make_fingerprint(const struct import *im, const char *made_from)
{
    char *text = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&text, &size);
    fprintf(f, "import %d, ellipsoid %.17g %.17g, bounds %.17g %.17g %.17g %.17g, feather %d\n",
            IMPORT_VERSION, im->ellipsoid.a, im->ellipsoid.b, im->bounds.west, im->bounds.south,
            im->bounds.east, im->bounds.north, im->params->feather_rows);
    for (int i = 0; i < im->count; i++) {
        const import_input *in = &im->inputs[i];
        VSIStatBufL st = {0};
        if (!in->memory && VSIStatL(in->source.path, &st))
            st.st_size = 0; // not a file: a name that GDAL knows
        fprintf(f, "%s %s, %lld bytes of %lld, priority %d, vertical %s\n",
                tile_layer_name(in->source.layer), in->source.path, (long long)st.st_size,
                (long long)st.st_mtime, in->source.priority,
                in->source.vertical ? in->source.vertical : "declared");
    }
    if (made_from) fprintf(f, "%s\n", made_from);
    fclose(f);
    return text;
}

// Leftovers of SQLite beside a planet file.
static void remove_journals(const char *path)
{
    static const char *const tails[] = {"-wal", "-shm", "-journal"};
    for (size_t i = 0; i < sizeof tails / sizeof *tails; i++) {
        char *name;
        if (asprintf(&name, "%s%s", path, tails[i]) < 0) abort();
        unlink(name);
        free(name);
    }
}

status import_check_output(const char *output, bool force)
{
    struct stat st;
    if (!stat(output, &st)) {
        if (S_ISREG(st.st_mode) && force) return OK;
        log_error(S_ISREG(st.st_mode) ? "%s: exists already; --force replaces it"
                                      : "%s: is not a file",
                  output);
        return ERR_ARGUMENT;
    }
    char *part;
    if (asprintf(&part, "%s.part", output) < 0) abort();
    bool existed = access(part, F_OK) == 0;
    int fd = open(part, O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
    int error = errno;
    if (fd >= 0) close(fd);
    if (fd >= 0 && !existed) unlink(part);
    free(part);
    if (fd >= 0) return OK;
    log_error("%s: cannot be written: %s", output, strerror(error));
    return ERR_IO;
}

static void fill_meta(const struct import *im, struct planet_meta *meta)
{
    const import_params *p = im->params;
    *meta = (struct planet_meta){.ellipsoid = im->ellipsoid, .complete = true};
    if (p->name) {
        snprintf(meta->name, sizeof meta->name, "%s", p->name);
    } else {
        const char *slash = strrchr(p->output, '/');
        const char *base = slash ? slash + 1 : p->output, *dot = strrchr(base, '.');
        int length = dot && dot > base ? (int)(dot - base) : (int)strlen(base);
        snprintf(meta->name, sizeof meta->name, "%.*s", length, base);
    }
    if (p->attribution) snprintf(meta->attribution, sizeof meta->attribution, "%s", p->attribution);
}

static status make_all(struct import *im)
{
    status s = OK;
    im->committed_s = im->reported_s = now_s();
    for (int layer = 0; !s && layer < LAYER_COUNT; layer++)
        s = make_layer(im, (enum tile_layer)layer);
    if (!s && !im->stored) {
        log_error("%s: the sources hold no data%s", im->params->output,
                  plan_bounds_are_global(&im->bounds) ? "" : " inside the bounds");
        s = ERR_ARGUMENT;
    }
    struct planet_meta meta;
    fill_meta(im, &meta);
    if (!s) s = planet_measure_gain(im->writer, &meta.synthesis_gain);
    return s ? s : planet_writer_finish(im->writer, &meta);
}

static status write_planet(struct import *im, const char *made_from)
{
    const import_params *p = im->params;
    char *part, *fingerprint = make_fingerprint(im, made_from);
    if (asprintf(&part, "%s.part", p->output) < 0) abort();
    bool resume = p->resume && access(part, F_OK) == 0;
    if (!resume) {
        unlink(part);
        remove_journals(part);
    }
    status s = planet_writer_open(part, fingerprint, resume, &im->writer);
    if (!s) s = make_all(im);
    if (im->writer && s && !im->failed) im->failed = s;
    planet_writer_close(&im->writer);
    if (!s) {
        remove_journals(p->output);
        if (rename(part, p->output)) {
            log_error("%s: cannot be renamed to %s: %s", part, p->output, strerror(errno));
            s = ERR_IO;
        }
    }
    free(part);
    free(fingerprint);
    return s;
}

status import_inputs(const import_params *p, const import_input *inputs, int count,
                     const char *made_from)
{
    struct import im = {.params = p, .inputs = inputs, .count = count};
    im.ellipsoid = p->ellipsoid.a > 0 ? p->ellipsoid : GEO_WGS84;
    if (count < 1) {
        log_error("%s: no raster to import", p->output);
        return ERR_ARGUMENT;
    }
    if (p->feather_rows < 0 || p->feather_rows > BLEND_MAX_ROWS) {
        log_error("a feather of %d rows is not in 0..%d", p->feather_rows, BLEND_MAX_ROWS);
        return ERR_ARGUMENT;
    }
    status s = import_check_output(p->output, p->force);
    if (!s) s = read_bounds(p->bounds_deg, &im.bounds);
    if (s) return s;
    im.grids = NEW_ARRAY(raster_grid, (size_t)count);
    pthread_mutex_init(&im.lock, NULL);
    pthread_cond_init(&im.finished, NULL);
    s = open_grids(&im);
    if (!s) {
        im.pool = pool_create(p->threads, 1024);
        s = write_planet(&im, made_from);
        pool_destroy(&im.pool);
    }
    pthread_cond_destroy(&im.finished);
    pthread_mutex_destroy(&im.lock);
    free(im.grids);
    return s;
}

status import_run(const import_params *params)
{
    import_list list;
    status s = import_list_init(params->sources, params->source_count, &list);
    if (!s) s = import_inputs(params, list.inputs, list.count, NULL);
    import_list_deinit(&list);
    return s;
}
