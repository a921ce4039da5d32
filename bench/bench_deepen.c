// Levels below the data: made by the GPU from the level before, against made by the CPU as tiles
// and uploaded. bench_deepen PLANET LAT LON
//
// For each level that the GPU can make: processor time and wall time a sample of both ways, whole
// windows, the tile cache cold for the CPU's; bytes that go to the GPU; the largest difference, all
// levels chained on the GPU. Medians. Fails when a difference exceeds 2 cm and 1e-5 of the spacing.
#include <epoxy/gl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "clipmap/clipmap.h"
#include "gpu/context.h"
#include "render/deepen.h"

enum { ROWS = 288, COLS = 512, SAMPLES = ROWS * COLS, LEVELS = 20, REPEATS = 9 };

static const window_shape shape = {ROWS, COLS, 256};
static float samples[SAMPLES], texels[SAMPLES];

static double now(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int ascending(const void *a, const void *b)
{
    double d = *(const double *)a - *(const double *)b;
    return (d > 0) - (d < 0);
}

static double median(double *values)
{
    qsort(values, REPEATS, sizeof *values, ascending);
    return values[REPEATS / 2] * 1e9 / SAMPLES;
}

struct cost {
    double processor, wall; // ns a sample
};

static size_t texel_of(const window *w, int i)
{
    return (size_t)window_texel(w->rect.row0 + i / COLS, ROWS) * COLS +
           (size_t)window_texel(w->rect.col0 + i % COLS, COLS);
}

static status fill_by_cpu(struct planet_file *file, const window *w, struct cost *cost)
{
    double processor[REPEATS], wall[REPEATS];
    status s = OK;
    for (int k = 0; !s && k < REPEATS; k++) {
        struct pyramid *p;
        pyramid_params params = {.synthesis = SYNTHESIS_ERODED};
        s = pyramid_create(file, &params, &p);
        double a = now(CLOCK_PROCESS_CPUTIME_ID), b = now(CLOCK_MONOTONIC);
        if (!s) s = clipmap_fill(p, LAYER_HEIGHT, &shape, w, w->rect, samples);
        processor[k] = now(CLOCK_PROCESS_CPUTIME_ID) - a;
        wall[k] = now(CLOCK_MONOTONIC) - b;
        pyramid_destroy(&p);
    }
    *cost = (struct cost){median(processor), median(wall)};
    for (int i = 0; i < SAMPLES; i++) texels[texel_of(w, i)] = samples[i];
    return s;
}

// In the two parts that do not wrap in the texture.
static size_t run_window(struct deepen *d, GLuint texture, const window *w)
{
    window_rect left = w->rect, right = w->rect;
    left.col1 = right.col0 = left.col0 + COLS - window_texel(left.col0, COLS);
    clipmap_strip a = {.window = *w, .rect = left}, b = {.window = *w, .rect = right};
    size_t bytes = deepen_run(d, texture, &a);
    if (right.col0 < right.col1) bytes += deepen_run(d, texture, &b);
    return bytes;
}

static size_t fill_by_gpu(struct deepen *d, GLuint texture, const window *w, struct cost *cost)
{
    double processor[REPEATS], wall[REPEATS];
    size_t bytes = 0;
    for (int k = -2; k < REPEATS; k++) {
        glFinish();
        double a = now(CLOCK_PROCESS_CPUTIME_ID), b = now(CLOCK_MONOTONIC);
        size_t sent = run_window(d, texture, w);
        bytes = sent > bytes ? sent : bytes; // the first time all rows and columns are new
        glFinish();
        for (clipmap_strip s; deepen_finished(d, 60, &s);) deepen_release(d);
        if (k < 0) continue;
        processor[k] = now(CLOCK_PROCESS_CPUTIME_ID) - a;
        wall[k] = now(CLOCK_MONOTONIC) - b;
    }
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT);
    *cost = (struct cost){median(processor), median(wall)};
    return bytes;
}

static double largest_difference(GLuint texture, int level)
{
    double most = 0;
    glGetTextureSubImage(texture, 0, 0, 0, level, COLS, ROWS, 1, GL_RED, GL_FLOAT, sizeof samples,
                         samples);
    for (int i = 0; i < SAMPLES; i++) {
        double off = fabs((double)samples[i] - (double)texels[i]);
        most = off <= most ? most : off; // NaN stays
    }
    return most;
}

static int run(struct planet_file *file, struct pyramid *p, double lat, double lon)
{
    struct deepen *d;
    GLuint texture;
    int failed = 0;
    if (deepen_create(p, &shape, LEVELS, ROWS, NULL, &d)) return 1;
    glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &texture);
    glTextureStorage3D(texture, 1, GL_R32F, COLS, ROWS, LEVELS);
    window up = window_at(&shape, 0, lat, lon, 1.0034);
    printf("%s\nlevel zoom  CPU ns, wall   GPU ns, wall   CPU bytes  GPU bytes  difference m\n",
           (const char *)glGetString(GL_RENDERER));
    for (int level = 1; level < LEVELS; level++) {
        window w = window_at(&shape, level, lat, lon, 1.0034);
        struct cost cpu, gpu;
        if (fill_by_cpu(file, &w, &cpu)) return 1;
        if (deepen_can(d, &w, w.rect, &up)) {
            size_t bytes = fill_by_gpu(d, texture, &w, &gpu);
            double off = largest_difference(texture, level);
            printf("%5d %4d  %6.1f %6.1f  %6.1f %6.1f  %10d %10zu  %.3g\n", level, w.zoom,
                   cpu.processor, cpu.wall, gpu.processor, gpu.wall, SAMPLES * 4, bytes, off);
            if (!(off <= 0.02 + 1e-5 * GEO_WGS84.a * window_step_lat(&w))) failed = 1;
        } else
            glTextureSubImage3D(texture, 0, 0, 0, level, COLS, ROWS, 1, GL_RED, GL_FLOAT, texels);
        up = w;
    }
    glDeleteTextures(1, &texture);
    deepen_destroy(&d);
    if (failed) puts("FAILED: the two ways differ");
    return failed;
}

int main(int argc, char **argv)
{
    struct gpu_context *context;
    struct planet_file *file;
    struct pyramid *p;
    pyramid_params params = {.synthesis = SYNTHESIS_ERODED};
    if (argc != 4) return puts("usage: bench_deepen PLANET LAT LON"), 2;
    if (gpu_context_create(&context)) return 1;
    if (planet_file_open(argv[1], &file) || pyramid_create(file, &params, &p)) return 1;
    int rc = run(file, p, atof(argv[2]) * M_PI / 180, atof(argv[3]) * M_PI / 180);
    pyramid_destroy(&p);
    planet_file_close(&file);
    gpu_context_destroy(&context);
    return rc;
}
