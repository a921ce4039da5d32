// Frame times along fixed camera paths: bench_frame PLANET [WIDTH HEIGHT [REPEATS]]
//
// Three scenes (space 12,000 km straight down, aircraft 10 km, ground 50 m) in three variants
// (default; every sector drawn; the original paper's 512 x 20 rings), each still, turning, and
// moving. The tile cache is cold at the first scene only. One line of JSON a scene, variant and
// motion: median, 95th percentile and worst of wall and GPU time, the median's ratio to the default
// variant's, triangles, vertices placed, bytes uploaded, memory. A black frame, or a still one that
// uploads, fails the bench.
#include <epoxy/gl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

#include "gpu/context.h"
#include "gpu/target.h"
#include "perigee.h"

enum { MAX_REPEATS = 1000, WARM_UP = 3 };

struct motion {
    const char *name;
    double north_deg, heading_deg; // a frame
};

struct scene {
    const char *name;
    perigee_camera camera;
    double step_deg; // northward a frame when moving
};

static const struct scene SCENES[] = {
    {"space",
     {.lat_deg = 45.6, .lon_deg = 10.7, .alt_m = 1.2e7, .pitch_deg = -90, .fov_deg = 47},
     0.1},
    {"aircraft",
     {.lat_deg = 45.6, .lon_deg = 10.7, .alt_m = 1e4, .pitch_deg = -20, .fov_deg = 47},
     2e-3},
    {"ground",
     {.lat_deg = 45.6, .lon_deg = 10.7, .alt_m = 50, .pitch_deg = -3, .fov_deg = 47},
     3.75e-5},
};

struct variant {
    const char *name;
    perigee_view_params params;
};

static const struct variant VARIANTS[] = {
    {"default", {0}},
    {"no_cull", {.no_cull = true}},
    {"gpu_synthesis", {.gpu_synthesis = true}},
    {"paper_rings", {.azimuth_steps = 512, .rings_per_level = 20}},
};

enum { MOTIONS = 3, VARIANT_COUNT = sizeof VARIANTS / sizeof *VARIANTS };

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

static void print_times(const char *name, double *ms, int count)
{
    qsort(ms, (size_t)count, sizeof *ms, ascending);
    printf(", \"%s_p50\": %.2f, \"%s_p95\": %.2f, \"%s_max\": %.2f", name, ms[count / 2], name,
           ms[count * 95 / 100], name, ms[count - 1]);
}

static int picture_is_black(int width, int height)
{
    unsigned char pixel[4] = {0};
    glReadPixels(width / 2, height / 2, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, pixel);
    return pixel[0] + pixel[1] + pixel[2] == 0; // dark grass has 11
}

struct bench {
    perigee_planet *planet;
    int width, height, repeats;
    double default_ms[MOTIONS]; // median wall time of the scene's first variant
};

// Times `repeats` frames of a motion after a warm-up. Non-zero when a frame is wrong.
static int time_frames(const struct bench *b, perigee_view *view, perigee_camera c,
                       const struct motion *motion, double *wall, double *gpu)
{
    int faults = 0;
    for (int i = -WARM_UP; i < b->repeats; i++) {
        c.lat_deg += motion->north_deg;
        c.heading_deg += motion->heading_deg;
        double start = now_s();
        if (perigee_view_set_camera(view, &c) || perigee_view_render(view, b->width, b->height))
            return 1;
        glFinish();
        perigee_stats s;
        perigee_view_get_stats(view, &s);
        if (i < 0) continue;
        wall[i] = (now_s() - start) * 1e3;
        gpu[i] = s.gpu_ms;
        faults += motion->north_deg == 0 && s.bytes_uploaded > 0;
    }
    return faults + picture_is_black(b->width, b->height);
}

static void print_costs(const struct bench *b, const perigee_stats *s, const perigee_stats *first)
{
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    int frames = b->repeats + WARM_UP;
    printf(", \"levels\": \"%u-%u\", \"triangles\": %llu, \"triangles_total\": %llu",
           s->first_level, s->last_level, (unsigned long long)s->triangles_drawn,
           (unsigned long long)s->triangles_total);
    printf(", \"placed_a_frame\": %.0f, \"bytes_a_frame\": %.0f",
           (double)(s->total_vertices_placed - first->total_vertices_placed) / frames,
           (double)(s->total_bytes_uploaded - first->total_bytes_uploaded) / frames);
    printf(", \"gpu_mib\": %.1f, \"peak_mib\": %.0f", (double)s->gpu_bytes / 1048576,
           (double)usage.ru_maxrss / 1024);
}

static int run_motion(struct bench *b, perigee_view *view, const struct scene *scene,
                      const struct variant *variant, const struct motion *motions, int k)
{
    static double wall[MAX_REPEATS], gpu[MAX_REPEATS];
    perigee_stats s, first;
    perigee_view_get_stats(view, &first);
    int faults = time_frames(b, view, scene->camera, &motions[k], wall, gpu);
    perigee_view_get_stats(view, &s);
    printf(
        "{\"version\": \"%s\", \"renderer\": \"%s\", \"width\": %d, \"height\": %d, \"frames\": %d",
        perigee_version(), glGetString(GL_RENDERER), b->width, b->height, b->repeats);
    printf(", \"scene\": \"%s\", \"variant\": \"%s\", \"motion\": \"%s\"", scene->name,
           variant->name, motions[k].name);
    print_times("wall_ms", wall, b->repeats); // sorts
    print_times("gpu_ms", gpu, b->repeats);
    double median = wall[b->repeats / 2];
    if (variant == VARIANTS) b->default_ms[k] = median;
    printf(", \"ratio\": %.2f", median / b->default_ms[k]);
    print_costs(b, &s, &first);
    printf(", \"faults\": %d}\n", faults);
    return faults;
}

static int run_scene(struct bench *b, struct scene s, const struct variant *variant)
{
    perigee_view *view;
    double start = now_s(), ground = 0;
    if (s.camera.alt_m < 1000 &&
        !perigee_planet_height(b->planet, s.camera.lat_deg, s.camera.lon_deg, &ground))
        s.camera.alt_m += ground;
    if (perigee_view_create(b->planet, &variant->params, &view)) return 1;
    int faults = perigee_view_set_camera(view, &s.camera) ||
                 perigee_view_wait(view, b->width, b->height, 120) ||
                 perigee_view_render(view, b->width, b->height);
    glFinish();
    printf("{\"scene\": \"%s\", \"variant\": \"%s\", \"first_complete_frame_s\": %.2f}\n", s.name,
           variant->name, now_s() - start);
    const struct motion motions[MOTIONS] = {
        {"still", 0, 0}, {"turning", 0, 1}, {"moving", s.step_deg, 0}};
    for (int k = 0; k < MOTIONS && !faults; k++)
        faults += run_motion(b, view, &s, variant, motions, k);
    perigee_view_destroy(&view);
    return faults;
}

int main(int argc, char **argv)
{
    struct bench b = {.width = argc > 3 ? atoi(argv[2]) : 1280,
                      .height = argc > 3 ? atoi(argv[3]) : 960,
                      .repeats = argc > 4 ? atoi(argv[4]) : 40};
    if (argc < 2 || b.repeats < 1 || b.repeats > MAX_REPEATS) {
        fprintf(stderr, "usage: bench_frame PLANET [WIDTH HEIGHT [REPEATS]]   (up to %d repeats)\n",
                MAX_REPEATS);
        return 1;
    }
    gpu_tune_allocator();
    struct gpu_context *context;
    gpu_target target;
    const GLenum format[1] = {GL_RGBA8};
    if (gpu_context_create(&context)) return 1;
    int faults = perigee_planet_open(argv[1], NULL, &b.planet) ||
                 gpu_target_init(&target, b.width, b.height, format, 1, 0);
    if (!faults) glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
    for (size_t i = 0; i < sizeof SCENES / sizeof *SCENES; i++)
        for (int k = 0; k < VARIANT_COUNT && !faults; k++)
            faults += run_scene(&b, SCENES[i], &VARIANTS[k]);
    perigee_planet_close(&b.planet);
    gpu_context_destroy(&context);
    return faults != 0;
}
