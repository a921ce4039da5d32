// What a slow server does to a flight: bench_stream FOLDER LAT LON [WIDTH HEIGHT [ROUNDS]]
//
// FOLDER is a planet made by `perigee export`; around LAT, LON it has fine data. A server of our
// own on loopback delays each tile by 0, 50, 100 and 200 ms. For each delay, with nothing in
// memory: the view is complete, then flies straight at 30 frames a second, jumps to twelve places
// for three frames each and to a last one; there it waits for the sharp view, frames going on. The
// flight is a function of the frame's number, so that all see the same. Delayed ones are flown a
// second time with requests in the order of asking, and none cancelled. One line of JSON a run:
// times of the frames, also against those without delay in the same round; seconds to the sharp
// view after the last jump; of all that was in flight in the frames from the second after the first
// jump on, the share that nobody wanted any more; transfers. A black frame, or a view that does not
// become sharp, fails the bench.
#include <epoxy/gl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "gpu/context.h"
#include "gpu/target.h"
#include "render/planet_handle.h"
#include "slow_server.h"

enum {
    FLIGHT = 90,
    JUMPS = 12,
    JUMP = 3,
    ASIDE = JUMPS * JUMP,
    MAX_REST = 3000,
    FRAMES = FLIGHT + ASIDE + MAX_REST
};

static const double FRAME_S = 1 / 30.0, STEP_DEG = 0.003, REST_S = 60;
static const int DELAYS_MS[] = {0, 50, 100, 200};

struct bench {
    const char *folder;
    double lat_deg, lon_deg;
    int port, width, height;
    double quick[3]; // percentiles without delay, ms
};

struct run {
    double ms[FRAMES];
    int frames;        // of the flight and the jump aside
    double sharp_s;    // after the last jump
    int stale, flying; // sums over frames
    struct fetch_counters net;
    int faults;
};

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static int is_black(const struct bench *b)
{
    unsigned char p[4] = {0};
    glReadPixels(b->width / 2, b->height / 2, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, p);
    return p[0] + p[1] + p[2] < 12;
}

static perigee_camera camera_at(const struct bench *b, int frame)
{
    perigee_camera c = {.lat_deg = b->lat_deg,
                        .lon_deg = b->lon_deg,
                        .alt_m = 4000,
                        .pitch_deg = -20,
                        .fov_deg = 50};
    if (frame < FLIGHT) c.lat_deg += STEP_DEG * frame;
    else if (frame < FLIGHT + ASIDE) {
        int jump = (frame - FLIGHT) / JUMP;
        c.lat_deg += 1.1 * (jump % 4) - 2.1;
        c.lon_deg += 1.1 * (int)(jump / 4) - 0.9;
    } else c.lat_deg += 1.7, c.lon_deg += 1.9;
    return c;
}

// One frame, and the rest of its 1/30 s.
static void fly_frame(const struct bench *b, perigee_view *view, struct fetcher *fetcher, int frame,
                      int after_jump, struct run *r)
{
    struct fetch_counters net;
    perigee_camera c = camera_at(b, frame);
    double start = clock_now_s();
    r->faults +=
        perigee_view_set_camera(view, &c) || perigee_view_render(view, b->width, b->height);
    glFinish();
    double s = clock_now_s() - start;
    if (frame < FLIGHT + ASIDE) r->ms[r->frames++] = s * 1e3;
    fetch_counters(fetcher, &net);
    if (after_jump > 0) r->stale += net.stale, r->flying += net.in_flight;
    if (s < FRAME_S) clock_sleep_s(FRAME_S - s);
}

static void fly(const struct bench *b, perigee_view *view, struct fetcher *fetcher, struct run *r)
{
    perigee_stats stats = {.needs_redraw = true};
    perigee_camera c = camera_at(b, 0);
    r->faults += perigee_view_set_camera(view, &c) ||
                 perigee_view_wait(view, b->width, b->height, REST_S * 2);
    for (int i = 0; i < FLIGHT + ASIDE; i++) fly_frame(b, view, fetcher, i, i - FLIGHT, r);
    double start = clock_now_s();
    for (int i = 0; stats.needs_redraw && clock_now_s() - start < REST_S; i++) {
        fly_frame(b, view, fetcher, FLIGHT + ASIDE + i, i, r);
        perigee_view_get_stats(view, &stats);
    }
    r->sharp_s = clock_now_s() - start;
    r->faults += stats.needs_redraw + is_black(b);
}

static int run_case(const struct bench *b, int delay_ms, bool first_come, struct run *r)
{
    char url[128];
    pyramid_params tiles = {.synthesis = true};
    source_set_params sources = {.fetch = {.first_come = first_come}};
    perigee_planet planet = {.sources = source_set_create(&sources)};
    perigee_view *view = NULL;
    *r = (struct run){0};
    snprintf(url, sizeof url, "http://127.0.0.1:%d/%d/planet.json", b->port, delay_ms);
    status s = source_set_add(planet.sources, url, LAYER_COUNT, 1);
    if (!s) s = source_set_pyramid(planet.sources, &tiles, &planet.pyramid);
    if (!s) s = (status)perigee_view_create(&planet, NULL, &view);
    if (!s) fly(b, view, source_set_fetcher(planet.sources), r);
    if (!s) fetch_counters(source_set_fetcher(planet.sources), &r->net);
    perigee_view_destroy(&view);
    pyramid_destroy(&planet.pyramid);
    source_set_destroy(&planet.sources);
    return s ? 1 : r->faults;
}

static void print_run(struct bench *b, int delay_ms, bool first_come, struct run *r)
{
    static const double share[3] = {0.5, 0.95, 0.99};
    double ms[3], load = 0;
    qsort(r->ms, (size_t)r->frames, sizeof *r->ms, ascending);
    for (int i = 0; i < 3; i++) ms[i] = r->ms[(int)(share[i] * (r->frames - 1))];
    if (delay_ms == 0) memcpy(b->quick, ms, sizeof ms);
    getloadavg(&load, 1);
    printf(
        "{\"version\": \"%s\", \"renderer\": \"%s\", \"load\": %.1f, \"delay_ms\": %d, "
        "\"order\": \"%s\", \"frames\": %d, \"p50_ms\": %.1f, \"p95_ms\": %.1f, \"p99_ms\": %.1f, "
        "\"p50_ratio\": %.2f, \"p95_ratio\": %.2f, \"p99_ratio\": %.2f, \"sharp_s\": %.2f, "
        "\"stale\": %.3f, \"started\": %llu, \"cancelled\": %llu, \"most_in_flight\": %d, "
        "\"faults\": %d}\n",
        perigee_version(), glGetString(GL_RENDERER), load, delay_ms,
        first_come ? "first come" : "most wanted", r->frames, ms[0], ms[1], ms[2],
        ms[0] / b->quick[0], ms[1] / b->quick[1], ms[2] / b->quick[2], r->sharp_s,
        r->flying ? (double)r->stale / r->flying : 0, (unsigned long long)r->net.started,
        (unsigned long long)r->net.cancelled, r->net.most_in_flight, r->faults);
    fflush(stdout);
}

static int run_rounds(struct bench *b, int rounds)
{
    static struct run r;
    int faults = 0;
    for (int k = 0; k < rounds; k++)
        for (size_t i = 0; i < sizeof DELAYS_MS / sizeof *DELAYS_MS; i++)
            for (int first_come = 0; first_come < (i ? 2 : 1); first_come++) {
                faults += run_case(b, DELAYS_MS[i], first_come, &r);
                print_run(b, DELAYS_MS[i], first_come, &r);
            }
    return faults;
}

int main(int argc, char **argv)
{
    struct bench b = {.width = argc > 5 ? atoi(argv[4]) : 640,
                      .height = argc > 5 ? atoi(argv[5]) : 480};
    int rounds = argc > 6 ? atoi(argv[6]) : 1;
    if (argc < 4 || rounds < 1) {
        fprintf(stderr, "usage: bench_stream FOLDER LAT LON [WIDTH HEIGHT [ROUNDS]]\n");
        return 1;
    }
    b.folder = argv[1];
    b.lat_deg = atof(argv[2]);
    b.lon_deg = atof(argv[3]);
    b.port = slow_server_start(b.folder);
    gpu_tune_allocator();
    struct gpu_context *context;
    gpu_target target;
    const GLenum format[1] = {GL_RGBA8};
    int faults = !b.port || gpu_context_create(&context) ||
                 gpu_target_init(&target, b.width, b.height, format, 1, 0);
    if (!faults) {
        glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
        faults = run_rounds(&b, rounds);
        gpu_target_deinit(&target);
        gpu_context_destroy(&context);
    }
    slow_server_stop();
    return faults != 0;
}
