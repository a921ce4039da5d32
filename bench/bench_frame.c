// Frame times along fixed camera paths: bench_frame PLANET [WIDTH HEIGHT [REPEATS]]
//
// Three scenes (space 12,000 km straight down, aircraft 10 km, ground 50 m), each still, turning,
// and moving; the cache is cold at the first frame of each scene and warm afterwards. One line of
// JSON a scene and motion: median, 95th percentile and worst of wall and GPU time, triangles,
// vertices placed, bytes uploaded, memory. A frame whose picture is black, or a still frame that
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
    return pixel[0] + pixel[1] + pixel[2] < 12;
}

// Renders `repeats` frames of a motion and prints its line. Non-zero when a frame is wrong.
static int run(perigee_view *view, const struct scene *scene, const struct motion *motion,
               int width, int height, int repeats)
{
    static double wall[MAX_REPEATS], gpu[MAX_REPEATS];
    perigee_camera c = scene->camera;
    perigee_stats s, first;
    int faults = 0;
    perigee_view_get_stats(view, &first);
    for (int i = -WARM_UP; i < repeats; i++) {
        c.lat_deg += motion->north_deg;
        c.heading_deg += motion->heading_deg;
        double start = now_s();
        if (perigee_view_set_camera(view, &c) || perigee_view_render(view, width, height)) return 1;
        glFinish();
        perigee_view_get_stats(view, &s);
        if (i < 0) continue;
        wall[i] = (now_s() - start) * 1e3;
        gpu[i] = s.gpu_ms;
        faults += motion->north_deg == 0 && s.bytes_uploaded > 0;
    }
    faults += picture_is_black(width, height);
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    printf("{\"scene\": \"%s\", \"motion\": \"%s\", \"renderer\": \"%s\", \"width\": %d, "
           "\"height\": %d, \"frames\": %d",
           scene->name, motion->name, glGetString(GL_RENDERER), width, height, repeats);
    print_times("wall_ms", wall, repeats);
    print_times("gpu_ms", gpu, repeats);
    printf(", \"levels\": \"%u-%u\", \"triangles\": %llu, \"triangles_total\": %llu", s.first_level,
           s.last_level, (unsigned long long)s.triangles_drawn,
           (unsigned long long)s.triangles_total);
    printf(", \"placed_a_frame\": %.0f, \"bytes_a_frame\": %.0f",
           (double)(s.total_vertices_placed - first.total_vertices_placed) / (repeats + WARM_UP),
           (double)(s.total_bytes_uploaded - first.total_bytes_uploaded) / (repeats + WARM_UP));
    printf(", \"gpu_mib\": %.1f, \"peak_mib\": %.0f, \"faults\": %d}\n",
           (double)s.gpu_bytes / 1048576, (double)usage.ru_maxrss / 1024, faults);
    return faults;
}

static int run_scene(perigee_planet *planet, const struct scene *scene, int width, int height,
                     int repeats)
{
    perigee_view *view;
    double start = now_s();
    struct scene s = *scene;
    double ground = 0;
    if (s.camera.alt_m < 1000 &&
        !perigee_planet_height(planet, s.camera.lat_deg, s.camera.lon_deg, &ground))
        s.camera.alt_m += ground;
    if (perigee_view_create(planet, NULL, &view)) return 1;
    int faults = perigee_view_set_camera(view, &s.camera) ||
                 perigee_view_wait(view, width, height, 120) ||
                 perigee_view_render(view, width, height);
    glFinish();
    printf("{\"scene\": \"%s\", \"first_complete_frame_s\": %.2f}\n", s.name, now_s() - start);
    const struct motion motions[] = {{"still", 0, 0}, {"turning", 0, 1}, {"moving", s.step_deg, 0}};
    for (int i = 0; i < 3 && !faults; i++)
        faults += run(view, &s, &motions[i], width, height, repeats);
    perigee_view_destroy(&view);
    return faults;
}

int main(int argc, char **argv)
{
    int width = argc > 3 ? atoi(argv[2]) : 1280, height = argc > 3 ? atoi(argv[3]) : 960;
    int repeats = argc > 4 ? atoi(argv[4]) : 40;
    if (argc < 2 || repeats < 1 || repeats > MAX_REPEATS) {
        fprintf(stderr, "usage: bench_frame PLANET [WIDTH HEIGHT [REPEATS]]   (up to %d repeats)\n",
                MAX_REPEATS);
        return 1;
    }
    gpu_tune_allocator();
    struct gpu_context *context;
    perigee_planet *planet = NULL;
    gpu_target target;
    const GLenum format[1] = {GL_RGBA8};
    if (gpu_context_create(&context)) return 1;
    int faults = perigee_planet_open(argv[1], NULL, &planet) ||
                 gpu_target_init(&target, width, height, format, 1, 0);
    if (!faults) glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
    for (size_t i = 0; !faults && i < sizeof SCENES / sizeof *SCENES; i++)
        faults += run_scene(planet, &SCENES[i], width, height, repeats);
    perigee_planet_close(&planet);
    gpu_context_destroy(&context);
    return faults != 0;
}
