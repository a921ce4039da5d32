// Geometry clipmaps measured as their papers do: bench_planar PLANET [sizes|levels|update|heights|
// forms|fleeting|residuals]
//
// sizes: the size of triangles on the screen against the formula, n = 63 .. 1023 (Losasso & Hoppe
// 2004, 4); levels: screen-space error by level (its Table 2); update: a whole level's update (its
// Table 1; Asirvatham & Hoppe 2005, Table 2-2); heights: packed against plain; forms: 2004, 2005
// and the rings; fleeting: levels below the data kept and not; residuals: heights sent as such and
// as what they add to the coarser level (2005, 2.4). Times are medians; ratios are within one run.
#include <epoxy/gl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "gpu/context.h"
#include "gpu/program.h"
#include "gpu/target.h"
#include "planet/planet_file.h"
#include "render/planar_parts.h"
#include "render/view.h"

enum { WIDTH = 640, HEIGHT = 480, PIXELS = WIDTH * HEIGHT, REPEATS = 15, N = 255 };

static const double RAD = M_PI / 180;
static gpu_target target;

static double now_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

// Of all threads, so also of what a driver does on the processor.
static double processor_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values, int n)
{
    qsort(values, (size_t)n, sizeof *values, ascending);
    return values[n / 2];
}

static void die(const char *what)
{
    fprintf(stderr, "bench_planar: %s failed: %s\n", what, perigee_last_error());
    exit(1);
}

// 90 degrees from left to right, as in the papers.
static perigee_camera camera_at(double lat, double lon, double alt, double pitch)
{
    return (perigee_camera){.lat_deg = lat,
                            .lon_deg = lon,
                            .alt_m = alt,
                            .heading_deg = 30,
                            .pitch_deg = pitch,
                            .fov_deg = 2 * atan((double)HEIGHT / WIDTH) / RAD};
}

static perigee_view *view_of(perigee_planet *planet, perigee_view_params params)
{
    perigee_view *view;
    params.identify = true;
    if (perigee_view_create(planet, &params, &view)) die("a view");
    return view;
}

static void render(perigee_view *view, const perigee_camera *c)
{
    glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
    if (perigee_view_set_camera(view, c) || perigee_view_wait(view, WIDTH, HEIGHT, 120) ||
        perigee_view_render(view, WIDTH, HEIGHT))
        die("a frame");
    glFinish();
}

// Turning on the spot, a degree a frame: everything is culled and drawn anew.
static double turning_ms(perigee_view *view, perigee_camera c)
{
    double ms[REPEATS];
    for (int i = 0; i < REPEATS + 2; i++) {
        c.heading_deg += 1;
        double start = now_ms();
        render(view, &c);
        if (i >= 2) ms[i - 2] = now_ms() - start;
    }
    return median(ms, REPEATS);
}

static perigee_stats stats_of(const perigee_view *view)
{
    perigee_stats s;
    perigee_view_get_stats(view, &s);
    return s;
}

// Screen size of a level's triangle at the mean depth of its ground: pixels weigh by the ground
// they cover on a plain, which grows with the cube of the depth.
static double triangle_size(perigee_view *view, int n, double *least, double *most)
{
    static float z[PIXELS];
    static int level[PIXELS];
    perigee_planes planes = {.z_m = z};
    perigee_triangles triangles = {.level = level};
    if (perigee_view_read_planes(view, &planes) || perigee_view_read_triangles(view, &triangles))
        die("reading back");
    perigee_stats s = stats_of(view);
    double sum = 0;
    int count = 0;
    *least = INFINITY;
    *most = 0;
    for (int l = (int)s.first_level + 3; l < (int)s.last_level; l++) {
        double weight = 0, depth = 0;
        for (int k = 0; k < PIXELS; k++) {
            if (level[k] != l) continue;
            double w = pow(z[k], 3);
            weight += w;
            depth += w * (double)z[k];
        }
        double step = 6378137 * 2 * M_PI / (n + 1) / (1 << l);
        double px = step * WIDTH / (2 * tan(45 * RAD) * depth / weight);
        *least = fmin(*least, px);
        *most = fmax(*most, px);
        sum += px;
        count++;
    }
    return sum / count;
}

static void bench_sizes(perigee_planet *planet)
{
    double base = 0;
    printf("n, 1.25 W / (n tan(fov/2)), measured mean (least .. most of the levels), triangles "
           "drawn, visible a ground pixel, GPU MiB, time to that of 255\n");
    for (int i = 0; i < 5; i++) {
        static const int sizes[] = {255, 63, 127, 511, 1023};
        int n = sizes[i];
        perigee_view *view =
            view_of(planet, (perigee_view_params){.mode = PERIGEE_MODE_PLANAR,
                                                  .planar_n = n,
                                                  .texels = n < 127 ? 128 : n + 1});
        perigee_camera c = camera_at(-10, -150, 60, 0);
        render(view, &c);
        double least, most, size = triangle_size(view, n, &least, &most);
        perigee_triangles t = {0};
        perigee_view_read_triangles(view, &t);
        perigee_stats s = stats_of(view);
        double ms = turning_ms(view, c);
        if (n == 255) base = ms;
        printf("%4d  %6.2f  %6.2f (%.2f .. %.2f)  %8llu  %.3f  %6.1f  %.2f\n", n, 1.25 * WIDTH / n,
               size, least, most, (unsigned long long)s.triangles_drawn,
               (double)t.visible / (double)t.ground_pixels, (double)s.gpu_bytes / 0x1p20,
               ms / base);
        fflush(stdout);
        perigee_view_destroy(&view);
    }
}

static double height_at(struct pyramid *p, int zoom, double lat, double lon)
{
    double h = 0;
    pyramid_height_at(p, zoom, lat, lon, &h);
    return h;
}

// Of the level's triangles at a place.
static double mesh_height(struct pyramid *p, int level, double lat, double lon)
{
    double step = 2 * M_PI / (N + 1) / (1 << level), r = (M_PI / 2 - lat) / step,
           c = (lon + M_PI) / step, r0 = floor(r), c0 = floor(c), fr = r - r0, fc = c - c0;
    double h[2][2];
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 2; k++)
            h[i][k] = height_at(p, level - 1, M_PI / 2 - (r0 + i) * step, (c0 + k) * step - M_PI);
    return fc >= fr ? h[0][0] + fc * (h[0][1] - h[0][0]) + fr * (h[1][1] - h[0][1])
                    : h[0][0] + fr * (h[1][0] - h[0][0]) + fc * (h[1][1] - h[1][0]);
}

static uint64_t next_random(uint64_t *state)
{
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    return *state * 0x2545F4914F6CDD1DULL;
}

static void bench_levels(const char *path)
{
    enum { POINTS = 40000, FINEST = 10 };
    static double e[POINTS];
    struct planet_file *file;
    struct pyramid *p;
    pyramid_params tiles = {.cache_bytes = (size_t)512 << 20};
    if (planet_file_open(path, &file) || pyramid_create(file, &tiles, &p)) die("the planet");
    printf(
        "level, spacing m, rms px, 99.9 %%, maximum, share above 1 px; n = %d, W = %d, s = %.2f\n",
        N, WIDTH, 1.25 * WIDTH / N);
    for (int level = 4; level <= 11; level++) {
        uint64_t state = 88172645463325252ULL;
        double step = 2 * M_PI / (N + 1) / (1 << level), sum = 0, size = 1.25 * WIDTH / N;
        int above = 0;
        for (int i = 0; i < POINTS; i++) {
            double lat = (36 + 2.9 * (double)(next_random(&state) >> 11) * 0x1p-53) * RAD,
                   lon = (127 + 2.4 * (double)(next_random(&state) >> 11) * 0x1p-53) * RAD;
            double off = mesh_height(p, level, lat, lon) - height_at(p, FINEST, lat, lon);
            e[i] = fabs(off) * size / (step * 6378137);
            sum += e[i] * e[i];
            above += e[i] > 1;
        }
        qsort(e, POINTS, sizeof *e, ascending);
        printf("%2d  %8.1f  %.3f  %.3f  %.3f  %.5f\n", level, step * 6378137, sqrt(sum / POINTS),
               e[(int)(0.999 * POINTS)], e[POINTS - 1], (double)above / POINTS);
        fflush(stdout);
    }
    pyramid_destroy(&p);
}

// A vertex's own height from its four samples, and the coarser one from two of its vertices.
static void elevation_on_cpu(const float *samples, const float *coarse, float *out)
{
    for (int i = 0; i < N; i++) {
        for (int k = 0; k < N; k++) {
            const float *s = samples + i * (N + 1) + k;
            out[2 * (i * N + k)] = 0.25f * (s[0] + s[1] + s[N + 1] + s[N + 2]);
            const float *c = coarse + (i / 2) * N + k / 2;
            out[2 * (i * N + k) + 1] = 0.5f * (c[0] + c[(i & 1) * N + (k & 1)]);
        }
    }
}

static double elevation_on_gpu(perigee_view *view, double (*clock_ms)(void))
{
    const struct planar *p = (const struct planar *)view->geometry;
    struct planar_elevation *e;
    planar_elevation_params params = {
        .n = N, .levels = p->levels, .kept = p->levels, .defines = "#define TRANSFORM 0\n"};
    if (planar_elevation_create(&params, &e)) die("elevation maps");
    double ms[REPEATS];
    nest_square squares[CLIPMAP_MAX_LEVELS];
    memcpy(squares, p->square, sizeof squares);
    for (int i = 0; i < REPEATS; i++) {
        for (int l = p->first; l <= p->last; l++) squares[l].column += i % 2 ? 2 : -2;
        frame_begin_geometry(&view->frame, view->windows);
        glFinish();
        double start = clock_ms();
        uint64_t vertices =
            planar_elevation_update(e, view->windows, squares, p->first, p->first, p->last);
        glFinish();
        ms[i] = (clock_ms() - start) * N * N / (double)vertices;
    }
    planar_elevation_destroy(&e);
    return median(ms, REPEATS);
}

static double normals_on_gpu(const perigee_view *view, double (*clock_ms)(void))
{
    GLuint program, normals, convexity;
    double ms[REPEATS];
    if (gpu_program_create_compute("normals/normals.comp", NULL, &program)) die("normals");
    glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &normals);
    glTextureStorage3D(normals, 1, GL_RG16_SNORM, 512, 288, 1);
    glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &convexity);
    glTextureStorage3D(convexity, 1, GL_R8_SNORM, 512, 288, 1);
    for (int i = 0; i < REPEATS; i++) {
        glFinish();
        double start = clock_ms(), step = 2 * M_PI / 256 / 1024;
        glUseProgram(program);
        glBindTextureUnit(0, windows_heights(view->windows));
        glBindImageTexture(0, normals, 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_RG16_SNORM);
        glBindImageTexture(1, convexity, 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R8_SNORM);
        glUniform4i(0, 10, N, 100, N);
        glUniform4i(1, 0, 0, 0, 0);
        glUniform4i(2, 0, 288, 0, 512);
        glUniform1i(3, 60000);
        glUniform2ui(5, 90000, 262144);
        glUniform2f(6, (float)step, (float)step);
        glUniform2f(4, 6378137.0f, 6356752.0f);
        glDispatchCompute((N + 15) / 16, (N + 3) / 4, 1);
        glFinish();
        ms[i] = clock_ms() - start;
    }
    const GLuint textures[2] = {normals, convexity};
    glDeleteTextures(2, textures);
    glDeleteProgram(program);
    return median(ms, REPEATS);
}

// From the stored tiles. The coarser level over the same ground has been filled before; the tiles
// of this one are at hand from the run before, or not.
static double fill_ms(const char *path, int level, bool synthesis, bool at_hand, float *samples)
{
    struct planet_file *file;
    struct pyramid *p = NULL;
    pyramid_params tiles = {.cache_bytes = (size_t)512 << 20, .synthesis = synthesis};
    window_shape shape = window_height_shape(N + 1);
    double ms[REPEATS];
    if (planet_file_open(path, &file)) die("the planet");
    for (int i = -1; i < REPEATS; i++) {
        if (!at_hand) pyramid_destroy(&p);
        if (!p && pyramid_create(file, &tiles, &p)) die("the pyramid");
        for (int l = at_hand ? level : level - 1; l <= level; l++) {
            window w = window_at(&shape, l, 37.5 * RAD, 128 * RAD, 1);
            window_rect rect = {w.rect.row0 + 16, w.rect.row0 + 16 + N + 1, w.rect.col0 + 128,
                                w.rect.col0 + 128 + N + 1};
            double start = processor_ms();
            if (clipmap_fill(p, LAYER_HEIGHT, &shape, &w, rect, samples)) die("filling");
            if (i >= 0) ms[i] = processor_ms() - start;
        }
    }
    pyramid_destroy(&p);
    planet_file_close(&file);
    return median(ms, REPEATS);
}

// Processor time, in shares of what filling from stored tiles takes.
static void bench_update(perigee_planet *planet, const char *path)
{
    enum { STORED = 10, MADE = 13 };
    static float samples[(N + 1) * (N + 1)], coarse[N * (N + 2)], out[2 * N * N];
    double cpu[REPEATS], upload[REPEATS], stored = fill_ms(path, STORED, false, false, samples);
    GLuint texture;
    glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &texture);
    glTextureStorage3D(texture, 1, GL_R32F, 512, 288, 1);
    for (int i = 0; i < REPEATS; i++) {
        double start = processor_ms();
        elevation_on_cpu(samples, coarse, out);
        cpu[i] = processor_ms() - start;
        coarse[i] = out[7 * i]; // so that the work is not left out
        start = processor_ms();
        glTextureSubImage3D(texture, 0, 0, 0, 0, N + 1, N + 1, 1, GL_RED, GL_FLOAT, samples);
        glFinish();
        upload[i] = processor_ms() - start;
    }
    glDeleteTextures(1, &texture);
    perigee_view *view = view_of(planet, (perigee_view_params){.mode = PERIGEE_MODE_PLANAR});
    perigee_camera c = camera_at(37.5, 128, 3000, -20);
    render(view, &c);
    printf(
        "a whole level, n = %d; filled from stored tiles on one core = 1, from tiles already "
        "decoded %.3f, below the data %.2f (synthesis); both heights on the CPU %.3f, on the GPU "
        "%.2f; upload %.3f; normals on the GPU %.2f\n",
        N, fill_ms(path, STORED, false, true, samples) / stored,
        fill_ms(path, MADE, true, false, samples) / stored, median(cpu, REPEATS) / stored,
        elevation_on_gpu(view, processor_ms) / stored, median(upload, REPEATS) / stored,
        normals_on_gpu(view, processor_ms) / stored);
    printf("by the clock, ms: both heights on the GPU %.3f, normals %.3f\n",
           elevation_on_gpu(view, now_ms), normals_on_gpu(view, now_ms));
    perigee_view_destroy(&view);
}

struct place {
    const char *name;
    double lat, lon, alt, pitch;
};

static const struct place PLACES[] = {{"orbit, 400 km", 37, 128, 4e5, -35},
                                      {"air, 5 km", 37.8, 128.2, 6000, -20},
                                      {"low, 300 m", 38.1, 128.3, 1900, -8}};

static void bench_heights(perigee_planet *planet)
{
    static float plain[PIXELS], packed[PIXELS], z[PIXELS];
    static double e[PIXELS];
    for (int i = 0; i < 3; i++) {
        const struct place *q = &PLACES[i];
        perigee_camera c = camera_at(q->lat, q->lon, q->alt, q->pitch);
        double ms[2], mib[2];
        for (int k = 0; k < 2; k++) {
            perigee_view *view = view_of(planet, (perigee_view_params){.mode = PERIGEE_MODE_PLANAR,
                                                                       .planar_packed = k == 1});
            render(view, &c);
            perigee_planes planes = {.z_m = z, .height_m = k ? packed : plain};
            if (perigee_view_read_planes(view, &planes)) die("reading back");
            mib[k] = (double)stats_of(view).gpu_bytes / 0x1p20;
            ms[k] = turning_ms(view, c);
            perigee_view_destroy(&view);
        }
        int n = 0;
        double sum = 0;
        for (int k = 0; k < PIXELS; k++) {
            if (isnan(plain[k]) || isnan(packed[k])) continue;
            e[n] = fabs((double)packed[k] - (double)plain[k]) * WIDTH / 2 / (double)z[k];
            sum += e[n] * e[n];
            n++;
        }
        qsort(e, (size_t)n, sizeof *e, ascending);
        printf("%-14s packed against plain: rms %.3f, 99.9 %% %.3f, max %.2f px; time %.2f; %.1f "
               "against %.1f MiB\n",
               q->name, sqrt(sum / n), e[(int)(0.999 * n)], e[n - 1], ms[1] / ms[0], mib[1],
               mib[0]);
        fflush(stdout);
    }
}

static void bench_forms(perigee_planet *planet)
{
    const struct {
        const char *name;
        perigee_view_params params;
    } forms[] = {{"rings", {0}},
                 {"2005", {.mode = PERIGEE_MODE_PLANAR}},
                 {"2004", {.mode = PERIGEE_MODE_PLANAR, .planar_form = PERIGEE_PLANAR_2004}},
                 {"2004, 50,000",
                  {.mode = PERIGEE_MODE_PLANAR,
                   .planar_form = PERIGEE_PLANAR_2004,
                   .planar_triangles = 50000}}};
    for (int i = 0; i < 3; i++) {
        const struct place *q = &PLACES[i];
        perigee_camera c = camera_at(q->lat, q->lon, q->alt, q->pitch);
        double base = 0;
        for (int k = 0; k < 4; k++) {
            perigee_view *view = view_of(planet, forms[k].params);
            render(view, &c);
            perigee_stats s = stats_of(view);
            double ms = turning_ms(view, c);
            if (!k) base = ms;
            printf(
                "%-14s %-13s levels %2u-%2u  triangles %8llu  drawn %7llu  draws %3llu  %.1f MiB  "
                "time %.2f\n",
                q->name, forms[k].name, s.first_level, s.last_level,
                (unsigned long long)s.triangles_total, (unsigned long long)s.triangles_drawn,
                (unsigned long long)s.draws, (double)s.gpu_bytes / 0x1p20, ms / base);
            fflush(stdout);
            perigee_view_destroy(&view);
        }
    }
}

// Levels below the data: as tiles, kept on the GPU, and made anew in each frame (2005, 2.6.3).
static void bench_fleeting(const char *path)
{
    static const char *const names[] = {"tiles", "kept", "memory-free"};
    static const double above[] = {20000, 1500, 50};
    perigee_planet *planet;
    if (perigee_planet_open(path, NULL, &planet)) die("the planet");
    for (int i = 0; i < 3; i++) {
        perigee_camera c = camera_at(45.4, 10.0, 150 + above[i], i ? -10 : -30);
        double base = 0;
        for (int k = 0; k < 3; k++) {
            perigee_view_params params = {
                .mode = PERIGEE_MODE_PLANAR, .gpu_synthesis = k > 0, .planar_memory_free = k > 1};
            perigee_view *view = view_of(planet, params);
            render(view, &c);
            perigee_stats s = stats_of(view);
            double ms = turning_ms(view, c);
            if (k < 2) base = ms;
            printf("%6.0f m  %-12s levels %2u-%2u  drawn %7llu  draws %3llu  %.1f MiB  time %.2f\n",
                   above[i], names[k], s.first_level, s.last_level,
                   (unsigned long long)s.triangles_drawn, (unsigned long long)s.draws,
                   (double)s.gpu_bytes / 0x1p20, ms / base);
            fflush(stdout);
            perigee_view_destroy(&view);
        }
    }
    perigee_planet_close(&planet);
}

// Bytes of heights and processor time, all threads: to fill the windows at a place, and of a flight
// of 60 frames from there that wait for their data, each a hundredth of the finest square on.
static void bench_residuals(perigee_planet *planet)
{
    enum { FRAMES = 60, RUNS = 5 };
    for (int i = 0; i < 3; i++) {
        const struct place *q = &PLACES[i];
        double ms[2][2][RUNS], mib[2][2] = {{0}};
        // The first round finds the tiles cold and is not kept.
        for (int k = -2; k < 2 * RUNS; k++) {
            struct windows_counters n[2];
            int form = k & 1, run = k / 2;
            perigee_view *view = view_of(planet, (perigee_view_params){.mode = PERIGEE_MODE_PLANAR,
                                                                       .planar_residuals = form});
            perigee_camera c = camera_at(q->lat, q->lon, q->alt, q->pitch);
            double start = processor_ms();
            render(view, &c);
            double filled = processor_ms();
            windows_count(view->windows, &n[0]);
            double step_deg = 3.6 / (1 << stats_of(view).last_level);
            for (int f = 0; f < FRAMES; f++, c.lat_deg += step_deg) render(view, &c);
            double flown = processor_ms();
            windows_count(view->windows, &n[1]);
            perigee_view_destroy(&view);
            if (k < 0) continue;
            ms[0][form][run] = filled - start;
            ms[1][form][run] = flown - filled;
            for (int j = 0; j < 2; j++)
                mib[j][form] = (double)(4 * n[j].heights - 2 * n[j].residuals) / 0x1p20;
            mib[1][form] -= mib[0][form];
        }
        printf(
            "%-14s fill: %.2f MiB, with residuals %.2f, processor time %.2f; flight: %.2f, %.2f, "
            "%.2f\n",
            q->name, mib[0][0], mib[0][1], median(ms[0][1], RUNS) / median(ms[0][0], RUNS),
            mib[1][0], mib[1][1], median(ms[1][1], RUNS) / median(ms[1][0], RUNS));
        fflush(stdout);
    }
}

int main(int argc, char **argv)
{
    if (argc < 2) return 2;
    const char *what = argc > 2 ? argv[2] : "";
    struct gpu_context *gpu;
    perigee_planet *planet;
    perigee_planet_params params = {.no_synthesis = true};
    const GLenum format[1] = {GL_RGBA8};
    if (gpu_context_create(&gpu) || gpu_target_init(&target, WIDTH, HEIGHT, format, 1, 0)) return 1;
    if (perigee_planet_open(argv[1], &params, &planet)) return 1;
    if (!*what || !strcmp(what, "sizes")) bench_sizes(planet);
    if (!*what || !strcmp(what, "levels")) bench_levels(argv[1]);
    if (!*what || !strcmp(what, "update")) bench_update(planet, argv[1]);
    if (!*what || !strcmp(what, "heights")) bench_heights(planet);
    if (!*what || !strcmp(what, "forms")) bench_forms(planet);
    if (!*what || !strcmp(what, "fleeting")) bench_fleeting(argv[1]);
    if (!*what || !strcmp(what, "residuals")) bench_residuals(planet);
    perigee_planet_close(&planet);
    return 0;
}
