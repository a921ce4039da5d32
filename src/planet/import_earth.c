// The default Earth: the atlas's relief made into a grid of heights in memory, its pictures as they
// are.
#include "planet/import.h"

#include <math.h>
#include <pthread.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/pool.h"
#include "planet/atlas.h"
#include "planet/import_inputs.h"

#define ATLAS_DIR "/usr/share/marble/data/maps"

// Well under what the atlas's grey levels say, and fine enough that gentle slopes are no steps.
#define HEIGHT_QUANTUM_M 0x1p-6

// Raise when the same atlas gives other heights.
enum { EARTH_VERSION = 1 };

static const char attribution[] =
    "Relief: SRTM30, NASA Jet Propulsion Laboratory, as in KDE Marble's atlas; heights above mean "
    "sea level, de-banded. "
    "Imagery: Blue Marble, NASA Goddard Space Flight Center, Earth Observatory. "
    "City lights: Marc Imhoff (NASA GSFC), Christopher Elvidge (NOAA NGDC), Craig Mayhew and "
    "Robert Simmon (NASA GSFC). "
    "Public domain; from Debian's marble-qt-data.";

struct earth {
    const import_earth_params *params;
    const char *dir, *csv;
    unsigned char *greys;
    float *heights;
    uint64_t hash; // of everything the heights are made from
    pthread_mutex_t lock;
    status failed;
};

struct tile_job {
    struct earth *earth;
    int row, col;
};

static bool report(void *user, double done)
{
    const import_earth_params *p = ((struct earth *)user)->params;
    return p->progress && p->progress(p->user, "relief", done);
}

static void read_tile(void *arg, int worker)
{
    (void)worker;
    struct tile_job *job = arg;
    struct earth *e = job->earth;
    pthread_mutex_lock(&e->lock);
    status s = e->failed;
    pthread_mutex_unlock(&e->lock);
    if (s) return;
    s = atlas_read_tile(e->dir, job->row, job->col, e->greys);
    pthread_mutex_lock(&e->lock);
    if (s && !e->failed) e->failed = s;
    pthread_mutex_unlock(&e->lock);
}

static status read_greys(struct earth *e)
{
    struct tile_job jobs[ATLAS_ROWS * ATLAS_COLS];
    struct pool *pool = pool_create(e->params->threads, ATLAS_ROWS * ATLAS_COLS);
    for (int i = 0; i < ATLAS_ROWS * ATLAS_COLS; i++) {
        jobs[i] = (struct tile_job){e, i / ATLAS_COLS, i % ATLAS_COLS};
        pool_submit(pool, read_tile, &jobs[i]);
    }
    pool_destroy(&pool);
    return e->failed;
}

static void add_hash(struct earth *e, const void *data, size_t size)
{
    const unsigned char *p = data;
    for (size_t i = 0; i < size; i++) e->hash = (e->hash ^ p[i]) * 0x100000001b3u; // FNV-1a
}

static void add_file(struct earth *e, const char *path)
{
    struct stat st;
    long long facts[2] = {0};
    if (!stat(path, &st)) {
        facts[0] = (long long)st.st_size;
        facts[1] = (long long)st.st_mtime;
    }
    add_hash(e, path, strlen(path));
    add_hash(e, facts, sizeof facts);
}

static void hash_sources(struct earth *e, const atlas_table *table)
{
    int settings[] = {EARTH_VERSION, e->params->bathymetry};
    e->hash = 0xcbf29ce484222325u;
    add_hash(e, settings, sizeof settings);
    add_hash(e, table->metres, sizeof table->metres);
    for (int i = 0; i < ATLAS_ROWS * ATLAS_COLS; i++) {
        char *path = atlas_tile_path(e->dir, i / ATLAS_COLS, i % ATLAS_COLS);
        add_file(e, path);
        free(path);
    }
}

// The shore of the Dead Sea.
#define LOWEST_LAND_M (-430.0f)

static status make_heights(struct earth *e, const atlas_table *table)
{
    size_t count = (size_t)ATLAS_WIDTH * ATLAS_HEIGHT;
    unsigned char *sea = NULL;
    e->greys = malloc(count);
    e->heights = malloc(count * sizeof *e->heights);
    status s = e->greys && e->heights ? read_greys(e) : ERR_MEMORY;
    if (!s && !e->params->bathymetry) {
        sea = malloc(count);
        s = sea ? atlas_find_sea(e->greys, ATLAS_WIDTH, ATLAS_HEIGHT, ATLAS_DEEP_GREY, ATLAS_STRAIT,
                                 sea)
                : ERR_MEMORY;
    }
    if (!s)
        s = atlas_make_heights(&(atlas_params){.greys = e->greys,
                                               .sea = sea,
                                               .width = ATLAS_WIDTH,
                                               .height = ATLAS_HEIGHT,
                                               .table = table,
                                               .threads = e->params->threads,
                                               .progress = report,
                                               .user = e},
                               e->heights);
    // JPEG rings beside steep greys, far below any dry land: what the ocean does not reach is land.
    for (size_t i = 0; !s && sea && i < count; i++)
        e->heights[i] = fmaxf(e->heights[i], LOWEST_LAND_M);
    if (s == ERR_MEMORY) log_error("out of memory for the relief of the default Earth");
    free(sea);
    free(e->greys);
    return s;
}

static status import_layers(struct earth *e)
{
    char *color, *night, made_from[64];
    if (asprintf(&color, "%s/earth/bluemarble/bluemarble.jpg", e->dir) < 0) abort();
    if (asprintf(&night, "%s/earth/citylights/citylights.jpg", e->dir) < 0) abort();
    snprintf(made_from, sizeof made_from, "relief of the atlas, %016llx",
             (unsigned long long)e->hash);
    import_input inputs[] = {
        {.source = {.layer = LAYER_HEIGHT, .path = "relief"},
         .memory = e->heights,
         .width = ATLAS_WIDTH,
         .height = ATLAS_HEIGHT},
        {.source = {.layer = LAYER_COLOR, .path = color}, .global = true},
        {.source = {.layer = LAYER_NIGHT, .path = night}, .global = true},
    };
    const import_earth_params *p = e->params;
    import_params params = {.output = p->output,
                            .name = "Earth",
                            .attribution = attribution,
                            .quantum = HEIGHT_QUANTUM_M,
                            .threads = p->threads,
                            .resume = p->resume,
                            .force = p->force,
                            .progress = p->progress,
                            .user = p->user};
    status s = import_inputs(&params, inputs, sizeof inputs / sizeof *inputs, made_from);
    free(color);
    free(night);
    return s;
}

status import_earth(const import_earth_params *params)
{
    struct earth e = {.params = params,
                      .dir = params->atlas_dir ? params->atlas_dir : ATLAS_DIR,
                      .csv = params->relief_csv ? params->relief_csv : PERIGEE_RELIEF_CSV};
    char *first = atlas_tile_path(e.dir, 0, 0);
    status s = OK;
    if (access(first, R_OK)) {
        log_error("%s: is not there; Debian's package marble-qt-data has the relief", first);
        s = ERR_NOT_FOUND;
    }
    free(first);
    atlas_table table;
    if (!s) s = import_check_output(params->output, params->force);
    if (!s) s = atlas_read_table(e.csv, &table);
    if (s) return s;
    pthread_mutex_init(&e.lock, NULL);
    hash_sources(&e, &table);
    s = make_heights(&e, &table);
    if (!s) s = import_layers(&e);
    free(e.heights);
    pthread_mutex_destroy(&e.lock);
    return s;
}
