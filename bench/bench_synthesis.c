// Detail below the data, judged by withheld data and by its cost: bench_synthesis PLANET
// [S,N,W,E]...
//
// Withheld: the planet without its finest zoom (or the two finest) is asked for the next zoom; what
// it makes and what the file holds there are both compared with the upsampled parent, by slope:
// rms of the two residuals, their ratio, how much steeper each is across the slope than along it,
// and how much of the error of plain upsampling is left. The gain is measured on coarser zooms.
// Cost: nanoseconds a sample of a tile made by four-point upsampling, with plain and with eroded
// synthesis. Fails when eroded costs more than four times what plain adds.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/memory.h"
#include "planet/pyramid.h"
#include "planet/synthesis.h"
#include "planet/upsample.h"

enum { SAMPLES = TILE_SIZE * TILE_SIZE, CLASSES = 6, KINDS = 3, MOST_TILES = 400 };

static const double class_top[CLASSES] = {0.03, 0.1, 0.2, 0.4, 0.8, HUGE_VAL};
static const char *const kind_name[KINDS] = {"none", "eroded", "plain"};

// A planet file without its finest zooms.
struct withheld {
    struct source source;
    struct source *whole;
};

static bool withheld_has(const struct source *source, tile_id id)
{
    return id.zoom <= source->meta.max_zoom[LAYER_HEIGHT] && id.layer == LAYER_HEIGHT &&
           source_has(((const struct withheld *)source)->whole, id);
}

static status withheld_read(struct source *source, tile_id id, struct want *want, void *samples,
                            double *until_s)
{
    if (!withheld_has(source, id)) return ERR_NOT_FOUND;
    return source_read(((struct withheld *)source)->whole, id, want, samples, until_s);
}

static void withheld_close(struct source *source)
{
    (void)source;
}

static const struct source_ops withheld_ops = {withheld_has, withheld_read, NULL, withheld_close};

struct box {
    double south, north, west, east;
};

struct sums {
    double n, relief2, tempered2, truth2, made2, error2, across[2], along[2];
};

enum { SLOTS = 16 };

struct judge {
    struct source *whole;
    struct want *want;
    struct slot {
        tile_id id;
        bool used;
        float *heights;
    } slots[SLOTS];
    int next;
    double radius;
    float *around, *relief, *tempered, *up, *slope, *share;
};

// A stored tile with its gaps; NULL when there is none. Stands until SLOTS others were asked for.
static const float *stored_tile(struct judge *j, tile_id id)
{
    for (int i = 0; i < SLOTS; i++)
        if (j->slots[i].used && !memcmp(&j->slots[i].id, &id, sizeof id))
            return j->slots[i].heights;
    if (!source_has(j->whole, id)) return NULL;
    struct slot *slot = &j->slots[j->next++ % SLOTS];
    double until;
    if (!slot->heights) slot->heights = NEW_ARRAY(float, SAMPLES);
    slot->id = id;
    slot->used = !source_read(j->whole, id, j->want, slot->heights, &until);
    return slot->used ? slot->heights : NULL;
}

// The samples around a child as they are stored at its parent's zoom; NaN where there is none.
static void fill_parent(struct judge *j, region *r)
{
    for (int y = 0; y < r->rows; y++)
        for (int x = 0, run; x < r->cols; x += run) {
            int64_t row = r->row + y, col = r->col + x;
            float *out = r->data + y * r->stride + x;
            tile_id id = {LAYER_HEIGHT, r->zoom, (int)(row / TILE_SIZE), (int)(col / TILE_SIZE)};
            run = TILE_SIZE - (int)(col % TILE_SIZE);
            if (run > r->cols - x) run = r->cols - x;
            const float *t = stored_tile(j, id);
            for (int i = 0; i < run; i++)
                out[i] = t ? t[row % TILE_SIZE * TILE_SIZE + col % TILE_SIZE + i] : NAN;
        }
}

// Steepness of a residual across and along the parent's slope, squared.
static void add_direction(const struct judge *j, const float *heights, int i, double shape,
                          double *across, double *along)
{
    double dy = (heights[i] - j->up[i]) - (heights[i + TILE_SIZE] - j->up[i + TILE_SIZE]);
    double dx = ((heights[i + 1] - j->up[i + 1]) - (heights[i] - j->up[i])) / shape;
    double gx = (j->up[i + 1] - j->up[i]) / shape, gy = j->up[i] - j->up[i + TILE_SIZE];
    double g = hypot(gx, gy);
    if (!(g > 0)) return;
    *along += pow((dx * gx + dy * gy) / g, 2);
    *across += pow((dy * gx - dx * gy) / g, 2);
}

// Upsamples the parent's ground to the child's samples; false where too little of it is stored.
static bool prepare(struct judge *j, region *child)
{
    region p = region_parent(child);
    p.data = j->around;
    fill_parent(j, &p);
    synthesis_relief(&p, j->relief);
    memcpy(j->tempered, j->relief, sizeof(float) * (size_t)(p.rows * p.cols));
    synthesis_temper(&p, j->radius, j->tempered);
    int whole = 0;
    for (int row = 0; row < TILE_SIZE; row++) {
        bool flat[TILE_SIZE];
        size_t at = (size_t)row * TILE_SIZE;
        upsample_child_row(&p, child, row, j->up + at, flat);
        upsample_linear_row(&p, j->relief, child, row, j->slope + at);
        upsample_linear_row(&p, j->tempered, child, row, j->share + at);
        for (int i = 0; i < TILE_SIZE; i++) {
            if (flat[i]) j->slope[at + (size_t)i] = 0;
            whole += isfinite(j->up[at + (size_t)i]) != 0;
        }
    }
    return whole > SAMPLES / 8;
}

static void add_tile(struct judge *j, tile_id id, const float *truth, const float *made,
                     struct sums *sums)
{
    double spacing = j->radius * grid_step_lat(id.zoom - 1);
    double shape = grid_coalesce(id.zoom, id.row) * cos(grid_lat(id.zoom, 256LL * id.row + 128));
    for (int i = 0; i < SAMPLES - TILE_SIZE; i++) {
        if (i % TILE_SIZE == TILE_SIZE - 1 || !(j->slope[i] > 0) || !isfinite(truth[i]) ||
            !isfinite(truth[i + 1]) || !isfinite(truth[i + TILE_SIZE]))
            continue;
        int c = 0;
        while (j->slope[i] / spacing > class_top[c]) c++;
        struct sums *s = &sums[c];
        s->n++;
        s->relief2 += j->slope[i] * j->slope[i];
        s->tempered2 += j->share[i] * j->share[i];
        s->truth2 += pow(truth[i] - j->up[i], 2);
        s->made2 += pow(made[i] - j->up[i], 2);
        s->error2 += pow(made[i] - truth[i], 2);
        add_direction(j, truth, i, shape, &s->across[0], &s->along[0]);
        add_direction(j, made, i, shape, &s->across[1], &s->along[1]);
    }
}

// Tiles of a zoom stored in a box, at most MOST_TILES, evenly spread.
static int list_tiles(const struct source *whole, const struct box *b, int zoom, tile_id *out)
{
    int count = 0;
    for (int pass = 0, all = 0; pass < 2; pass++) {
        int every = pass ? (all + MOST_TILES - 1) / MOST_TILES : 1, seen = 0;
        double step = 180.0 / grid_rows(zoom);
        for (int row = (int)fmax((90 - b->north) / step, 0); row < (90 - b->south) / step; row++) {
            double width = 360.0 / grid_cols(zoom, row);
            for (int col = (int)((b->west + 180) / width); col < (b->east + 180) / width; col++) {
                tile_id id = {LAYER_HEIGHT, zoom, row, col};
                if (!source_has(whole, id)) continue;
                if (pass && seen % every == 0) out[count++] = id;
                seen++;
            }
        }
        all = seen;
    }
    return count;
}

// made: NULL to measure what is stored alone.
static void judge_box(struct judge *j, struct pyramid *made, const struct box *b, int zoom,
                      struct sums sums[CLASSES])
{
    static tile_id ids[MOST_TILES * 2];
    static float truth[SAMPLES];
    int count = list_tiles(j->whole, b, zoom, ids);
    for (int k = 0; k < count; k++) {
        const float *stored = stored_tile(j, ids[k]);
        const pyramid_tile *t;
        region child = region_of_tile(ids[k], 1, NULL);
        if (!stored) continue;
        memcpy(truth, stored, sizeof truth);
        if (!prepare(j, &child)) continue;
        if (!made) add_tile(j, ids[k], truth, truth, sums);
        else if (!pyramid_acquire(made, ids[k], &t)) {
            add_tile(j, ids[k], truth, t->heights, sums);
            pyramid_release(made, &t);
        }
    }
}

static struct sums total(const struct sums sums[CLASSES])
{
    struct sums t = {0};
    for (int c = 0; c < CLASSES; c++)
        t.n += sums[c].n, t.tempered2 += sums[c].tempered2, t.truth2 += sums[c].truth2,
            t.made2 += sums[c].made2, t.error2 += sums[c].error2;
    return t;
}

// The gain that an import of the withheld planet would measure in the box.
static double measure_gain(struct judge *j, const struct box *b, int finest)
{
    struct sums all = {0};
    for (int zoom = finest; zoom > finest - 3 && zoom > 1; zoom--) {
        struct sums sums[CLASSES] = {0};
        judge_box(j, NULL, b, zoom, sums);
        struct sums t = total(sums);
        all.truth2 += t.truth2;
        all.tempered2 += t.tempered2;
    }
    double gain = all.tempered2 > 0 ? sqrt(all.truth2 / all.tempered2) : 0;
    return fmin(fmax(gain, SYNTHESIS_GAIN_MIN), SYNTHESIS_GAIN_MAX);
}

static void print_sums(const struct sums *s, const char *kind, int zoom, const char *name)
{
    if (s->n < 1000) return;
    printf("%-7s z%-2d %-6s %9.0f  %8.2f %8.2f  %5.2f  %5.2f", kind, zoom, name, s->n,
           sqrt(s->truth2 / s->n), sqrt(s->made2 / s->n), sqrt(s->made2 / s->truth2),
           sqrt(s->error2 / s->truth2));
    if (s->along[0] > 0)
        printf("  %5.2f %5.2f", sqrt(s->across[0] / s->along[0]), sqrt(s->across[1] / s->along[1]));
    puts("");
}

static struct pyramid *open_kind(struct source *source, int kind, double gain)
{
    source->meta.synthesis_gain = gain;
    pyramid_layer layer = {source, 1};
    pyramid_params params = {.cache_bytes = (size_t)192 << 20, .synthesis = (enum synthesis)kind};
    struct pyramid *p;
    return pyramid_create_stack(&layer, 1, &params, &p) ? NULL : p;
}

static void judge_withheld(struct judge *j, struct source *whole, const struct box *b, int held)
{
    int finest = whole->meta.max_zoom[LAYER_HEIGHT], zoom = finest + 1 - held;
    struct withheld w = {.source = *whole, .whole = whole};
    w.source.ops = &withheld_ops;
    w.source.meta.max_zoom[LAYER_HEIGHT] = zoom - 1;
    double gain = measure_gain(j, b, zoom - 1);
    printf("box %g,%g,%g,%g: gain of the coarser zooms %.3f\n", b->south, b->north, b->west,
           b->east, gain);
    puts("kind    zoom slope<    samples  true m   made m   ratio  error  across/along true, made");
    for (int kind = 1; kind < KINDS; kind++) {
        struct sums sums[CLASSES] = {0};
        struct pyramid *p = open_kind(&w.source, kind, gain);
        if (!p) exit(1);
        judge_box(j, p, b, zoom, sums);
        for (int c = 0; c < CLASSES; c++) {
            char name[16];
            snprintf(name, sizeof name, "%.2f", class_top[c]);
            print_sums(&sums[c], kind_name[kind], zoom, name);
        }
        struct sums t = total(sums);
        print_sums(&t, kind_name[kind], zoom, "all");
        pyramid_destroy(&p);
    }
}

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int ascending(const void *a, const void *b)
{
    double d = *(const double *)a - *(const double *)b;
    return (d > 0) - (d < 0);
}

// Median cost of a tile's samples from parents of rough ground, ns a sample.
static double cost_of(enum synthesis kind)
{
    enum { REPEATS = 31 };
    static float heights[SAMPLES];
    static synthesis_columns columns;
    tile_id id = {LAYER_HEIGHT, 14, 4500, 9000};
    region child = region_of_tile(id, 1, heights), parent = region_parent(&child);
    size_t samples = (size_t)parent.rows * (size_t)parent.cols;
    parent.data = NEW_ARRAY(float, samples);
    for (size_t i = 0; i < samples; i++)
        parent.data[i] = 300 * (float)sin((double)(i % (size_t)parent.cols) * 0.11) +
                         200 * (float)cos((double)(i / (size_t)parent.cols) * 0.23 + 1);
    double cost[REPEATS];
    for (int k = -3; k < REPEATS; k++) {
        double start = seconds();
        synthesis_ground ground = {0};
        if (kind && synthesis_ground_create(&parent, kind, 0.3, 12, GEO_WGS84.a, &ground)) exit(1);
        synthesis_columns_of(&child, &columns);
        for (int row = 0; row < TILE_SIZE; row++) {
            bool flat[TILE_SIZE];
            float *out = heights + row * TILE_SIZE;
            upsample_child_row(&parent, &child, row, out, flat);
            if (kind) synthesis_add_row(&ground, &columns, &parent, &child, row, flat, NULL, out);
        }
        synthesis_ground_destroy(&ground);
        if (k >= 0) cost[k] = (seconds() - start) * 1e9 / SAMPLES;
    }
    free(parent.data);
    qsort(cost, REPEATS, sizeof *cost, ascending);
    return cost[REPEATS / 2];
}

static int judge_cost(void)
{
    double none = cost_of(SYNTHESIS_NONE), plain = cost_of(SYNTHESIS_PLAIN),
           eroded = cost_of(SYNTHESIS_ERODED);
    double ratio = (eroded - none) / (plain - none);
    printf("ns a sample, one core: upsampling %.2f, with plain %.2f, with eroded %.2f; eroded adds "
           "%.2f times what plain adds\n",
           none, plain, eroded, ratio);
    if (ratio <= 4) return 0;
    puts("FAILED: more than four times");
    return 1;
}

int main(int argc, char **argv)
{
    struct planet_file *file;
    struct source *whole;
    if (argc < 2) return puts("usage: bench_synthesis PLANET [S,N,W,E]..."), 2;
    int failed = judge_cost();
    if (planet_file_open(argv[1], &file) || source_file_open_take(file, &whole)) return 1;
    struct judge j = {.whole = whole, .want = want_create(-1), .radius = whole->meta.ellipsoid.a};
    float **arrays[] = {&j.around, &j.relief, &j.tempered, &j.up, &j.slope, &j.share};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        *arrays[i] = NEW_ARRAY(float, SAMPLES * 2);
    for (int i = 2; i < argc; i++) {
        struct box b;
        if (sscanf(argv[i], "%lf,%lf,%lf,%lf", &b.south, &b.north, &b.west, &b.east) != 4)
            return printf("%s: not S,N,W,E\n", argv[i]), 2;
        for (int held = 1; held <= 2; held++) judge_withheld(&j, whole, &b, held);
    }
    want_release(&j.want);
    for (int i = 0; i < SLOTS; i++) free(j.slots[i].heights);
    source_close(&whole);
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++) free(*arrays[i]);
    return failed;
}
