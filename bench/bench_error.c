// Screen-space geometric error against triangles and time, as CSV:
// at the views of data/views/accuracy.json:
//   bench_error PLANET [SETTING [PART-OF-A-VIEW'S-NAME]]
//       a row a view: error, triangles drawn and visible for each pixel of ground
//   bench_error --levels PLANET [...]   and a row for each level of rings
//   bench_error --time PLANET [...]     and the time of a frame of a turning camera, default = 1,
//   ms
// SETTING: the name of one, or `all`. Errors are in pixels of 1280 x 960 (error_judge.h).
#include <epoxy/gl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "bench/error_judge.h"
#include "gpu/context.h"
#include "gpu/target.h"

struct setting {
    const char *name;
    perigee_view_params params;
};

// From coarse to fine, and the paper's.
static const struct setting SETTINGS[] = {
    {"512x32", {.azimuth_steps = 512, .rings_per_level = 32, .ring_spacing_px = 12}},
    {"low", {.quality = PERIGEE_QUALITY_LOW}},
    {"default", {0}},
    {"bilinear", {.filter = PERIGEE_FILTER_EMULATED}},
    {"768x64", {.azimuth_steps = 768, .rings_per_level = 64, .texels = 512, .ring_spacing_px = 7}},
    {"1024x80",
     {.azimuth_steps = 1024, .rings_per_level = 80, .texels = 512, .ring_spacing_px = 5}},
    {"1024x96",
     {.azimuth_steps = 1024, .rings_per_level = 96, .texels = 1024, .ring_spacing_px = 5}},
    {"high", {.quality = PERIGEE_QUALITY_HIGH}},
    {"1536x144",
     {.azimuth_steps = 1536, .rings_per_level = 144, .texels = 1024, .ring_spacing_px = 3}},
    {"paper", {.quality = PERIGEE_QUALITY_PAPER}},
};

enum { SETTING_COUNT = sizeof SETTINGS / sizeof *SETTINGS, TURNS = 15 };

struct bench {
    perigee_planet *planet;
    struct error_judge judge;
    struct views_file views;
    gpu_target target;
    bool levels, time;
    const char *setting, *part;
};

static double now_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static bool frame(const struct bench *b, perigee_view *view, const perigee_camera *c)
{
    glBindFramebuffer(GL_FRAMEBUFFER, b->target.framebuffer);
    return !perigee_view_set_camera(view, c) &&
           !perigee_view_wait(view, ERROR_WIDTH, ERROR_HEIGHT, 120) &&
           !perigee_view_render(view, ERROR_WIDTH, ERROR_HEIGHT);
}

// Seconds of a frame after a turn of the head.
static double turn(const struct bench *b, perigee_view *view, perigee_camera c, int i)
{
    c.heading_deg += 0.1 * i;
    double start = now_s();
    if (!frame(b, view, &c)) exit(1);
    glFinish();
    return now_s() - start;
}

// Median time of a frame over that of the default's, turn by turn in exchange, so that what else
// the machine does falls on both; then the median time itself.
static void print_time(const struct bench *b, const perigee_view_params *params,
                       const perigee_camera *c)
{
    perigee_view *one, *other;
    double ratio[TURNS], ms[TURNS];
    if (perigee_view_create(b->planet, params, &one) ||
        perigee_view_create(b->planet, NULL, &other))
        exit(1);
    for (int i = -2; i < TURNS; i++) {
        double mine = turn(b, one, *c, i), base = turn(b, other, *c, i);
        if (i < 0) continue;
        ratio[i] = mine / base;
        ms[i] = 1e3 * mine;
    }
    perigee_view_destroy(&one);
    perigee_view_destroy(&other);
    qsort(ratio, TURNS, sizeof *ratio, ascending);
    qsort(ms, TURNS, sizeof *ms, ascending);
    printf(",%.2f,%.3f", ratio[TURNS / 2], ms[TURNS / 2]);
}

static void print_stat(const char *setting, const char *view, const char *level,
                       const struct error_stat *s)
{
    printf("%s,\"%s\",%s,%zu,%.3f,%.3f,%.2f,%.4f", setting, view, level, s->count, s->rms, s->p999,
           s->max, s->above);
}

static void measure(const struct bench *b, const struct setting *setting, perigee_view *view,
                    const named_view *v)
{
    struct error_result r;
    perigee_stats stats;
    perigee_triangles seen = {0};
    perigee_camera c = error_camera(&b->judge, v);
    if (!frame(b, view, &c) || !error_judge_frame(&b->judge, view, &c, error_zoom(v), &r)) exit(1);
    perigee_view_get_stats(view, &stats);
    if (perigee_view_read_triangles(view, &seen)) exit(1);
    double pixels = (double)r.ground;
    print_stat(setting->name, v->name, "all", &r.all);
    printf(",%llu,%.3f,%.3f,%.1f", (unsigned long long)stats.triangles_drawn,
           (double)stats.triangles_drawn / pixels, (double)seen.visible / pixels,
           (double)stats.gpu_bytes / 1048576);
    if (b->time) print_time(b, &setting->params, &c);
    printf("\n");
    for (int l = 0; b->levels && l < ERROR_LEVELS; l++) {
        char name[8];
        snprintf(name, sizeof name, "%d", l);
        if (!r.level[l].count) continue;
        print_stat(setting->name, v->name, name, &r.level[l]);
        printf("\n");
    }
    fflush(stdout);
}

static void measure_all(const struct bench *b)
{
    printf("setting,view,level,pixels,rms_px,rank_999_px,max_px,above_1px,triangles,drawn_px,"
           "visible_px,gpu_mib%s\n",
           b->time ? ",time,time_ms" : "");
    for (int s = 0; s < SETTING_COUNT; s++) {
        perigee_view *view;
        perigee_view_params params = SETTINGS[s].params;
        if (strcmp(b->setting, "all") && strcmp(b->setting, SETTINGS[s].name)) continue;
        params.identify = true;
        if (perigee_view_create(b->planet, &params, &view)) exit(1);
        for (int i = 0; i < b->views.count; i++)
            if (strstr(b->views.views[i].name, b->part))
                measure(b, &SETTINGS[s], view, &b->views.views[i]);
        perigee_view_destroy(&view);
    }
}

int main(int argc, char **argv)
{
    struct bench b = {0};
    struct gpu_context *gpu;
    struct planet_file *file;
    pyramid_params tiles = {.cache_bytes = (size_t)512 << 20};
    perigee_planet_params no_synthesis = {.no_synthesis = true};
    const GLenum format[1] = {GL_RGBA8};
    int first = 1;
    for (; first < argc && !strncmp(argv[first], "--", 2); first++) {
        b.levels |= !strcmp(argv[first], "--levels");
        b.time |= !strcmp(argv[first], "--time");
    }
    if (first >= argc) return fprintf(stderr, "usage: see the head of bench_error.c\n"), 2;
    b.setting = first + 1 < argc ? argv[first + 1] : "default";
    b.part = first + 2 < argc ? argv[first + 2] : "";
    if (views_file_load(VIEWS_FILE, &b.views)) return 1;
    if (gpu_context_create(&gpu) ||
        gpu_target_init(&b.target, ERROR_WIDTH, ERROR_HEIGHT, format, 1, 0))
        return 1;
    if (planet_file_open(argv[first], &file) || pyramid_create(file, &tiles, &b.judge.pyramid))
        return 1;
    b.judge.e = planet_file_meta(file)->ellipsoid;
    if (perigee_planet_open(argv[first], &no_synthesis, &b.planet)) return 1;
    measure_all(&b);
    perigee_planet_close(&b.planet);
    views_file_deinit(&b.views);
    return 0;
}
