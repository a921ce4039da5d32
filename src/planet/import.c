#include "planet/import_under_way.h"

#include <cpl_vsi.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "base/log.h"
#include "base/memory.h"
#include "planet/codec_bounded.h"
#include "planet/codec_grid.h"
#include "planet/import_blend.h"
#include "planet/import_border.h"
#include "planet/import_sources.h"
#include "planet/quantum.h"

// Raise when the same sources and settings give other tiles, so that an import begun before is not
// gone on with.
enum { IMPORT_VERSION = 6, KEPT_BYTES = 512 << 20 };

// So many tiles take less time than it takes the processes to wait for each other at every zoom.
enum { ALONE_TILES = 16 };

// The filter carries what a sample says by FILTER_REACH rows at a zoom, and half of what it was at
// the zoom before: by less than twice that at any.
enum { CARRIED_ROWS = 3 };

static double now_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static bool is_first(const struct import *im)
{
    return !im->params->team || im->params->team->rank == 0;
}

static status agree(const struct import *im, status s)
{
    const import_team *team = im->params->team;
    return team ? team->agree(team->user, s) : s;
}

static uint64_t sum(const struct import *im, uint64_t mine)
{
    const import_team *team = im->params->team;
    return team ? team->sum(team->user, mine) : mine;
}

void layer_init(const struct import *im, enum tile_layer layer, struct layer *out)
{
    *out = (struct layer){.layer = layer,
                          .inputs = NEW_ARRAY(import_input, (size_t)im->count),
                          .grids = NEW_ARRAY(raster_grid, (size_t)im->count),
                          .max_zoom = -1};
    for (int i = 0; i < im->count; i++) {
        if (im->inputs[i].source.layer != layer) continue;
        out->inputs[out->count] = im->inputs[i];
        out->grids[out->count++] = im->grids[i];
        if (im->grids[i].zoom > out->max_zoom) out->max_zoom = im->grids[i].zoom;
    }
}

void layer_deinit(struct layer *l)
{
    free(l->inputs);
    free(l->grids);
}

struct plan_walk *layer_walk(const struct import *im, const struct layer *l, int zoom)
{
    return plan_walk_begin(l->layer, zoom, l->grids, l->count, &im->bounds,
                           im->base ? CARRIED_ROWS : 0);
}

uint64_t layer_count(const struct import *im, const struct layer *l, int zoom)
{
    struct plan_walk *walk = layer_walk(im, l, zoom);
    uint64_t n = plan_walk_left(walk);
    plan_walk_end(&walk);
    return n;
}

static uint64_t count_tiles(const struct import *im, const struct layer *l)
{
    uint64_t n = 0;
    for (int zoom = 0; zoom <= l->max_zoom; zoom++) n += layer_count(im, l, zoom);
    return n;
}

struct workshop *layer_workshop(const struct import *im, const struct layer *l, int workers,
                                struct import_cache *cache)
{
    return workshop_create(&(workshop_params){.inputs = l->inputs,
                                              .grids = l->grids,
                                              .count = l->count,
                                              .workers = workers,
                                              .ellipsoid = im->ellipsoid,
                                              .bounds = im->bounds,
                                              .feather = im->params->feather_rows,
                                              .feather_m = im->params->feather_m,
                                              .quantum = im->quantum,
                                              .cache = cache,
                                              .base = im->base});
}

// Zooms from the finest on, each shared among all; the coarsest, of few tiles together, are rank
// 0's, one after the other.
static status make_zooms(struct import *im, const struct layer *l, uint64_t tiles)
{
    for (int zoom = l->max_zoom; zoom >= 0;) {
        bool alone = !im->params->team || tiles <= ALONE_TILES;
        status s = crew_look(im->crew, alone);
        if (s) return s;
        do {
            struct plan_walk *walk = layer_walk(im, l, zoom);
            tiles -= plan_walk_left(walk);
            s = crew_make(im->crew, walk);
        } while (--zoom >= 0 && alone && !s);
        s = crew_seal(im->crew);
        if (s) return s;
    }
    return OK;
}

static status make_layer(struct import *im, enum tile_layer layer)
{
    static const char *const stages[LAYER_COUNT] = {"heights", "colour", "night"};
    struct layer l;
    layer_init(im, layer, &l);
    status s = OK;
    if (l.count) {
        uint64_t before = crew_count(im->crew).made, tiles = count_tiles(im, &l);
        size_t kept = im->params->kept_bytes ? im->params->kept_bytes : KEPT_BYTES;
        struct import_cache *cache = import_cache_create(im->store, kept);
        struct workshop *workshop = layer_workshop(im, &l, crew_threads(im->crew), cache);
        crew_begin(im->crew, stages[layer], tiles, workshop);
        s = make_zooms(im, &l, tiles);
        workshop_destroy(&workshop);
        // Only once so many bytes: not beside another layer's.
        if (layer == LAYER_HEIGHT && l.count == im->count) im->kept = cache;
        else import_cache_destroy(&cache);
        im->samples += (crew_count(im->crew).made - before) * TILE_SIZE * TILE_SIZE;
    }
    layer_deinit(&l);
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
    fprintf(f,
            "import %d, ellipsoid %.17g %.17g, bounds %.17g %.17g %.17g %.17g, "
            "feather %d %.17g, quantum %.17g\n",
            IMPORT_VERSION, im->ellipsoid.a, im->ellipsoid.b, im->bounds.west, im->bounds.south,
            im->bounds.east, im->bounds.north, im->params->feather_rows, im->params->feather_m,
            im->quantum);
    if (im->base) {
        struct stat st = {0};
        (void)stat(import_base_path(im->base), &st);
        fprintf(f, "added to %lld bytes of %lld\n", (long long)st.st_size, (long long)st.st_mtime);
    }
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

static double quantum_of(double quantum, int zoom, const struct planet_meta *m)
{
    return ldexp(1, quantum_exponent(quantum, zoom, m->ellipsoid.a));
}

static void fill_meta(const struct import *im, struct planet_meta *meta)
{
    const import_params *p = im->params;
    const struct planet_meta *base = im->base ? import_base_meta(im->base) : NULL;
    *meta = (struct planet_meta){.ellipsoid = im->ellipsoid, .complete = true};
    meta->max_error = im->max_error;
    if (im->quantum != 0 && im->max_error == 0) {
        int finest = base && base->max_zoom[LAYER_HEIGHT] > 0 ? base->max_zoom[LAYER_HEIGHT] : 0;
        for (int i = 0; i < im->count; i++)
            if (im->inputs[i].source.layer == LAYER_HEIGHT && im->grids[i].zoom > finest)
                finest = im->grids[i].zoom;
        meta->quantum = quantum_of(im->quantum, 0, meta);
        meta->quantum_finest = quantum_of(im->quantum, finest, meta);
    }
    if (p->name || base) {
        snprintf(meta->name, sizeof meta->name, "%s", p->name ? p->name : base->name);
    } else {
        const char *slash = strrchr(p->output, '/');
        const char *file = slash ? slash + 1 : p->output, *dot = strrchr(file, '.');
        int length = dot && dot > file ? (int)(dot - file) : (int)strlen(file);
        snprintf(meta->name, sizeof meta->name, "%.*s", length, file);
    }
    const char *attribution = p->attribution ? p->attribution : base ? base->attribution : "";
    snprintf(meta->attribution, sizeof meta->attribution, "%s", attribution);
}

static status make_all(struct import *im)
{
    status s = OK;
    for (int layer = 0; !s && layer < LAYER_COUNT; layer++)
        s = make_layer(im, (enum tile_layer)layer);
    struct crew_counters c = crew_count(im->crew);
    uint64_t stored = sum(im, c.made + c.kept);
    if (!s && !stored) {
        if (is_first(im))
            log_error("%s: the sources hold no data%s", im->params->output,
                      plan_bounds_are_global(&im->bounds) ? "" : " inside the bounds");
        s = ERR_ARGUMENT;
    }
    return s;
}

static bool report_join(void *user, double done)
{
    const import_params *p = ((struct import *)user)->params;
    return p->progress && p->progress(p->user, "joining", done);
}

// The file and its name are on the disk when this returns.
static status move_into_place(const char *from, const char *to)
{
    int fd = open(from, O_RDONLY | O_CLOEXEC);
    bool good = fd >= 0 && fsync(fd) == 0;
    if (fd >= 0) close(fd);
    if (good) good = rename(from, to) == 0;
    if (!good) {
        log_error("%s: cannot be renamed to %s: %s", from, to, strerror(errno));
        return ERR_IO;
    }
    char *folder = NEW_ARRAY(char, strlen(to) + 2);
    strcpy(folder, to);
    char *slash = strrchr(folder, '/');
    if (slash) slash[slash == folder] = '\0';
    fd = open(slash ? folder : ".", O_RDONLY | O_CLOEXEC);
    if (fd >= 0) {
        (void)fsync(fd);
        close(fd);
    }
    free(folder);
    return OK;
}

static status join(struct import *im, const char *joining)
{
    struct planet_meta meta;
    struct layer heights;
    const import_team *team = im->params->team;
    fill_meta(im, &meta);
    layer_init(im, LAYER_HEIGHT, &heights);
    struct workshop *workshop = heights.count ? layer_workshop(im, &heights, 1, NULL) : NULL;
    import_join j = {.path = joining,
                     .meta = &meta,
                     .border = workshop ? border_create(workshop) : NULL,
                     .kept = im->kept,
                     .threads = im->params->threads * (team ? team->here : 1),
                     .progress = report_join,
                     .user = im};
    status s = import_store_join(im->store, &j);
    im->tiles = j.tiles;
    border_destroy(&j.border);
    workshop_destroy(&workshop);
    layer_deinit(&heights);
    if (!s) s = move_into_place(joining, im->params->output);
    if (s) unlink(joining);
    return s;
}

static void write_report(const struct import *im)
{
    struct crew_counters c = crew_count(im->crew);
    const import_team *team = im->params->team;
    log_debug("process %d of %d made %llu tiles", team ? team->rank : 0, team ? team->size : 1,
              (unsigned long long)c.made);
    import_report r = {.tiles = im->tiles,
                       .made = sum(im, c.made),
                       .uniform = sum(im, c.uniform),
                       .samples = sum(im, im->samples),
                       .seconds = now_s() - im->began_s,
                       .threads = (int)sum(im, (uint64_t)crew_threads(im->crew))};
    struct stat st;
    if (!stat(im->params->output, &st)) r.bytes = (uint64_t)st.st_size;
    if (im->params->report) *im->params->report = r;
}

static status write_planet(struct import *im, const char *made_from)
{
    const import_params *p = im->params;
    char *part, *joining, *fingerprint = make_fingerprint(im, made_from);
    if (asprintf(&part, "%s.part", p->output) < 0) abort();
    if (asprintf(&joining, "%s.joining", p->output) < 0) abort();
    import_store_params sp = {.part = part,
                              .fingerprint = fingerprint,
                              .base = im->base,
                              .rank = p->team ? p->team->rank : 0,
                              .resume = p->resume};
    // Rank 0 clears away or mends what is there before the others open theirs.
    status s = is_first(im) ? import_store_open(&sp, &im->store) : OK;
    s = agree(im, s);
    if (!s && !is_first(im)) s = import_store_open(&sp, &im->store);
    s = agree(im, s);
    if (!s) {
        im->crew = crew_create(&(crew_params){.store = im->store,
                                              .team = p->team,
                                              .threads = p->threads,
                                              .progress = p->progress,
                                              .user = p->user});
        s = make_all(im);
        if (!s && is_first(im)) s = join(im, joining);
        s = agree(im, s);
        if (!s) write_report(im);
        import_cache_destroy(&im->kept);
        crew_destroy(&im->crew);
    }
    import_store_close(&im->store);
    s = agree(im, s);
    if (!s && is_first(im)) import_store_remove(part);
    free(part);
    free(joining);
    free(fingerprint);
    return s;
}

// The quantum that a planet was imported with: the same at all zooms, unless it may have been each
// zoom's own.
static double base_quantum(const struct planet_meta *m)
{
    int finest = m->max_zoom[LAYER_HEIGHT] > 0 ? m->max_zoom[LAYER_HEIGHT] : 0;
    bool own = m->quantum == quantum_of(QUANTUM_AUTO, 0, m) &&
               m->quantum_finest == quantum_of(QUANTUM_AUTO, finest, m);
    return own || m->max_zoom[LAYER_HEIGHT] < 0 ? QUANTUM_AUTO : m->quantum;
}

// The planet that is added to says how heights are stored.
static status open_base(struct import *im)
{
    status s = import_base_open(im->params->output, &im->base);
    if (s) return s;
    const struct planet_meta *m = import_base_meta(im->base);
    im->ellipsoid = m->ellipsoid;
    im->max_error = m->max_error;
    im->quantum = base_quantum(m);
    return OK;
}

status import_prepare(struct import *im)
{
    const import_params *p = im->params;
    im->began_s = now_s();
    im->ellipsoid = p->ellipsoid.a > 0 ? p->ellipsoid : GEO_WGS84;
    if (im->count < 1) {
        log_error("%s: no raster to import", p->output);
        return ERR_ARGUMENT;
    }
    if (p->feather_rows < 0 || p->feather_rows > BLEND_MAX_ROWS) {
        log_error("a feather of %d rows is not in 0..%d", p->feather_rows, BLEND_MAX_ROWS);
        return ERR_ARGUMENT;
    }
    if (p->feather_m != FEATHER_AUTO && !(p->feather_m >= 0 && p->feather_m <= FEATHER_MOST_M)) {
        log_error("a feather of %g m is not in 0..%g", p->feather_m, FEATHER_MOST_M);
        return ERR_ARGUMENT;
    }
    if (!quantum_is_good(p->quantum)) {
        log_error("a quantum of %g m is not in %g..%g", p->quantum, ldexp(1, GRID_EXPONENT_MIN),
                  ldexp(1, GRID_EXPONENT_MAX + 1));
        return ERR_ARGUMENT;
    }
    if (p->max_error != 0 &&
        !(p->max_error >= BOUNDED_MIN_ERROR && p->max_error <= BOUNDED_MAX_ERROR)) {
        log_error("a greatest error of %g m is not in %g..%g", p->max_error, BOUNDED_MIN_ERROR,
                  BOUNDED_MAX_ERROR);
        return ERR_ARGUMENT;
    }
    im->quantum = p->quantum;
    im->max_error = p->max_error;
    status s = read_bounds(p->bounds_deg, &im->bounds);
    if (!s && p->add) s = open_base(im);
    if (s) return s;
    if (im->max_error > 0) im->quantum = ldexp(1, bounded_exponent(im->max_error));
    im->grids = NEW_ARRAY(raster_grid, (size_t)im->count);
    return open_grids(im);
}

status import_inputs(const import_params *p, const import_input *inputs, int count,
                     const char *made_from)
{
    struct import im = {.params = p, .inputs = inputs, .count = count};
    bool checks = count > 0 && is_first(&im) && !p->add;
    status s = checks ? import_check_output(p->output, p->force) : OK;
    s = agree(&im, s);
    if (!s) s = import_prepare(&im);
    s = agree(&im, s);
    if (!s) s = write_planet(&im, made_from);
    import_base_close(&im.base);
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
