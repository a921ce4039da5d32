// Frames that do not wait for data. What a frame changes is bounded by what has come: a level that
// was not there fades in over 0.35 s, and one that grows does so at a bounded speed, so that in dt
// seconds a still picture changes by about dt / 0.35 of what all the missing data change.
#include "render/temporal.h"

#include <time.h>
#include <unistd.h>

static double clock_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static const char *earth = EARTH_PLANET;

enum { MAX_FRAMES = 400 };

static const double FRAME_S = 0.02, FADE_S = 0.35;

struct film {
    temporal_picture frame[MAX_FRAMES];
    double time_s[MAX_FRAMES];
    int frames;
};

// Frames of a still camera, starting with nothing, until nothing more comes.
static void shoot(const temporal_scene *s, const perigee_camera *c, struct film *film)
{
    perigee_stats stats = {.needs_redraw = true};
    for (film->frames = 0; stats.needs_redraw; film->frames++) {
        assert_true(film->frames < MAX_FRAMES);
        while (film->frames && clock_s() - film->time_s[film->frames - 1] < FRAME_S) usleep(500);
        film->time_s[film->frames] = clock_s();
        temporal_see_now(s, c, &film->frame[film->frames]);
        perigee_view_get_stats(s->view, &stats);
    }
}

static void widen(const temporal_picture *p, temporal_picture *low, temporal_picture *high)
{
    for (int i = 0; i < TEMPORAL_PIXELS; i++) {
        low->r[i] = fminf(low->r[i], p->r[i]);
        low->g[i] = fminf(low->g[i], p->g[i]);
        low->b[i] = fminf(low->b[i], p->b[i]);
        high->r[i] = fmaxf(high->r[i], p->r[i]);
        high->g[i] = fmaxf(high->g[i], p->g[i]);
        high->b[i] = fmaxf(high->b[i], p->b[i]);
    }
}

static void test_levels_fade_in(void **state)
{
    (void)state;
    perigee_view_params slow = {.upload_bytes_frame = 128 << 10};
    temporal_scene s = temporal_open(temporal_rough(), true, &slow);
    struct film *film = malloc(sizeof *film);
    assert_non_null(film);
    perigee_camera c = {
        .lat_deg = 31, .lon_deg = 12, .heading_deg = 40, .pitch_deg = -60, .fov_deg = 60};
    c.alt_m = temporal_ground(&s, c.lat_deg, c.lon_deg) + 20000;
    shoot(&s, &c, film);
    static temporal_picture low, high;
    low = high = film->frame[film->frames - 1];
    for (int i = 0; i < film->frames; i++) widen(&film->frame[i], &low, &high);
    temporal_change range = temporal_compare(&s, &c, &low, &high, NULL, NULL);
    double fastest = 0, largest = 0;
    for (int i = 1; i < film->frames; i++) {
        temporal_change t =
            temporal_compare(&s, &c, &film->frame[i - 1], &film->frame[i], NULL, NULL);
        double step = film->time_s[i] - film->time_s[i - 1];
        fastest = fmax(fastest, t.rms / (range.rms * step));
        largest = fmax(largest, t.rms);
    }
    print_message(
        "%d frames in %.2f s; all data change %.2f / 255, one frame %.2f at most, %.2f of "
        "all a second\n",
        film->frames, film->time_s[film->frames - 1] - film->time_s[0], range.rms, largest,
        fastest);
    assert_true(range.rms > 1);
    assert_true(fastest <= 1.5 / FADE_S);
    free(film);
    temporal_close(&s);
}

// How far frames that do not wait are from those that have all data, along FRAMES steps.
enum { FRAMES = 40 };

static temporal_change fly(const char *name, const temporal_scene *s, perigee_camera c,
                           double step_lat_deg, double step_lon_deg)
{
    static temporal_picture whole, seen[FRAMES];
    static perigee_camera at[FRAMES];
    temporal_change worst = {0};
    temporal_see(s, &c, &whole);
    for (int i = 0; i < FRAMES; i++) {
        c.lat_deg += step_lat_deg;
        c.lon_deg += step_lon_deg;
        temporal_see_now(s, &c, &seen[i]);
        at[i] = c;
    }
    for (int i = 0; i < FRAMES; i++) {
        temporal_see(s, &at[i], &whole);
        temporal_change t = temporal_compare(s, &at[i], &whole, &seen[i], NULL, NULL);
        worst.p999_px = fmax(worst.p999_px, t.p999_px);
        worst.rms = fmax(worst.rms, t.rms);
        worst.p999 = fmax(worst.p999, t.p999);
        if (i == 0) assert_true(t.rms <= 0.1);
    }
    print_message("%-30s: 99.9 %% %.3f px, colour rms %.3f, 99.9 %% %.2f / 255 at most\n", name,
                  worst.p999_px, worst.rms, worst.p999);
    return worst;
}

// Then the frames come to what has all data, to the bit.
static void settle(const temporal_scene *s, const perigee_camera *c)
{
    static temporal_picture whole, seen;
    perigee_stats stats = {.needs_redraw = true};
    for (double end = clock_s() + 20; stats.needs_redraw && clock_s() < end; usleep(5000)) {
        temporal_see_now(s, c, &seen);
        perigee_view_get_stats(s->view, &stats);
    }
    temporal_see(s, c, &whole);
    temporal_change left = temporal_compare(s, c, &whole, &seen, NULL, NULL);
    assert_true(left.worst <= 0.1);
}

// Over the latitude where the windows of all fine levels become twice or half as wide and are
// filled anew. So few bytes a frame that what shows is what the old windows are made into: neither
// workers nor the machine's load change anything.
static void test_share(void **state)
{
    (void)state;
    perigee_view_params few = {.upload_bytes_frame = 4 << 10};
    temporal_scene s = temporal_open(temporal_rough(), true, &few);
    perigee_camera c = {.lon_deg = 12, .pitch_deg = -25, .fov_deg = 60};
    c.alt_m = temporal_ground(&s, 57.85, c.lon_deg) + 3000;
    for (int way = -1; way <= 1; way += 2) {
        c.lat_deg = 57.852 - way * 0.012;
        c.heading_deg = way > 0 ? 0 : 180;
        temporal_change worst =
            fly(way > 0 ? "northwards over 57.85 N" : "southwards over it", &s, c, way * 0.0006, 0);
        assert_true(worst.p999_px <= 0.05);
        assert_true(worst.rms <= 0.5);
        assert_true(worst.p999 <= 4);
        c.lat_deg += way * 0.024;
        settle(&s, &c);
    }
    temporal_close(&s);
}

// The same for imagery of the default Earth from 300 km, level 4.
static void test_imagery_share(void **state)
{
    (void)state;
    if (access(earth, R_OK)) {
        print_message("%s: not there, nothing tested\n", earth);
        skip();
    }
    perigee_view_params few = {.upload_bytes_frame = 64 << 10};
    temporal_scene s = temporal_open(earth, true, &few);
    perigee_camera c = {.lon_deg = 10, .alt_m = 3e5, .pitch_deg = -60, .fov_deg = 60};
    for (int way = -1; way <= 1; way += 2) {
        c.lat_deg = 58.4 - way * 0.4;
        c.heading_deg = way > 0 ? 40 : 220;
        temporal_change worst =
            fly(way > 0 ? "imagery northwards over 58.4 N" : "imagery southwards over it", &s, c,
                way * 0.02, 0);
        assert_true(worst.rms <= 0.8);
        assert_true(worst.p999 <= 4);
    }
    temporal_close(&s);
}

static void test_antimeridian(void **state)
{
    (void)state;
    temporal_scene s = temporal_open(temporal_rough(), true, NULL);
    perigee_camera c = {
        .lat_deg = 31, .lon_deg = 179.99, .heading_deg = 90, .pitch_deg = -25, .fov_deg = 60};
    c.alt_m = temporal_ground(&s, c.lat_deg, 180) + 3000;
    temporal_change worst = fly("over 180 E", &s, c, 0, 0.0006);
    assert_true(worst.rms <= 0.5);
    temporal_close(&s);
}

// Over the latitude where a level comes to hold the whole circle. Its window begins at longitude
// 180, so that along that meridian the smaller part of what it has is lost and fades in anew.
static void test_whole_circle(void **state)
{
    (void)state;
    perigee_view_params few = {.upload_bytes_frame = 4 << 10};
    temporal_scene s = temporal_open(temporal_rough(), true, &few);
    for (int i = 0; i < 2; i++) {
        perigee_camera c = {
            .lat_deg = 89.814, .lon_deg = i ? 180 : 90, .pitch_deg = -25, .fov_deg = 60};
        c.alt_m = temporal_ground(&s, 89.8, c.lon_deg) + 3000;
        temporal_change worst =
            fly(i ? "to the pole along 180 E" : "to the pole along 90 E", &s, c, 0.0005, 0);
        assert_true(worst.p999_px <= 0.05);
        assert_true(worst.rms <= (i ? 1 : 0.1));
        assert_true(worst.p999 <= (i ? 10 : 1));
    }
    temporal_close(&s);
}

// With an argument: another planet with imagery.
int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_levels_fade_in), cmocka_unit_test(test_share),
        cmocka_unit_test(test_imagery_share), cmocka_unit_test(test_antimeridian),
        cmocka_unit_test(test_whole_circle)};
    if (argc > 1) earth = argv[1];
    int rc = scene_open();
    return rc ? rc : scene_close(cmocka_run_group_tests(tests, NULL, NULL));
}
