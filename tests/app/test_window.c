// The window under a display of its own (Xvfb): opens, draws, answers mouse and keyboard, takes a
// picture, closes; and says one line where there is no display or no OpenGL 4.5.
#include "check.h"

#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "app/image_png.h"
#include "app/window.h"
#include "perigee.h"
#include "planet/analytic_planet.h"

#define INSIDE "PERIGEE_TEST_INSIDE_XVFB"
#define PLANET "window.planet"
#define TITLE  "Perigee under test"

static perigee_planet *planet;

static struct window_params params(void)
{
    return (struct window_params){
        .planet = planet,
        .start = {.lat_deg = 30, .lon_deg = 10, .alt_m = 2e6, .pitch_deg = -70},
        .width = 400,
        .height = 300,
        .unix_time_s = NAN,
        .attribution = "An analytic planet",
        .title = TITLE};
}

// A child process, so that no driver has been loaded yet.
static int run_in_child(void)
{
    pid_t child = fork();
    if (child == 0) {
        struct window_params p = params();
        p.frames = 1;
        _exit(window_run(&p));
    }
    int state = -1;
    waitpid(child, &state, 0);
    return WIFEXITED(state) ? WEXITSTATUS(state) : -1;
}

static void no_display(void **state)
{
    (void)state;
    char *display = strdup(getenv("DISPLAY"));
    assert_true(window_display_available());
    unsetenv("DISPLAY");
    unsetenv("WAYLAND_DISPLAY");
    assert_false(window_display_available());
    assert_int_equal(run_in_child(), 1);
    setenv("DISPLAY", ":987", 1);
    assert_false(window_display_available());
    setenv("DISPLAY", display, 1);
    free(display);
}

static void no_opengl_45(void **state)
{
    (void)state;
    setenv("MESA_GL_VERSION_OVERRIDE", "3.3", 1);
    assert_int_equal(run_in_child(), 1);
    unsetenv("MESA_GL_VERSION_OVERRIDE");
}

static void draws_some_frames(void **state)
{
    (void)state;
    struct window_params p = params();
    p.frames = 10;
    p.unix_time_s = 1.7e9;
    assert_int_equal(window_run(&p), 0);
}

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

// Everything a hand can do, at least once; Esc twice leaves fly mode and then the window.
static const char script[] =
    "set -e; id=$(xdotool search --sync --onlyvisible --name '" TITLE "' | head -n 1)\n"
    "sleep 1; xdotool mousemove --window $id 200 150 mousedown 1\n"
    "for i in 1 2 3 4 5; do xdotool mousemove --window $id $((200 + 10 * i)) $((150 + 5 * i)); "
    "done\n"
    "xdotool mouseup 1 click 4 click 4 click 5 mousedown 3 mousemove --window $id 230 120 mouseup "
    "3\n"
    "xdotool keydown Up; sleep 0.2; xdotool keyup Up keydown shift keydown Left; sleep 0.2\n"
    "xdotool keyup Left keyup shift key plus key n key space key period key comma key c key F1 key "
    "F1\n"
    "xdotool click --repeat 2 --delay 50 1; sleep 0.3; xdotool key Home key F12; sleep 0.5\n"
    "xdotool key f keydown w; sleep 0.2; xdotool keyup w key Escape; sleep 0.2; xdotool key "
    "Escape\n";

static bool has_hand(void)
{
    return system("command -v xdotool >/dev/null") == 0;
}

static pid_t start_hand(const char *what)
{
    pid_t hand = fork();
    if (hand == 0) {
        execlp("sh", "sh", "-c", what, (char *)NULL);
        _exit(127);
    }
    return hand;
}

static bool hand_is_done(pid_t hand)
{
    int result = -1;
    waitpid(hand, &result, 0);
    return WIFEXITED(result) && WEXITSTATUS(result) == 0;
}

static void answers_mouse_and_keyboard(void **state)
{
    (void)state;
    if (!has_hand()) {
        print_message("xdotool is not there\n");
        skip();
    }
    remove("shots/perigee-0001.png");
    mkdir("shots", 0777);
    pid_t hand = start_hand(script);
    struct window_params p = params();
    p.screenshot_dir = "shots";
    p.run_s = 60;
    double begin = seconds();
    assert_int_equal(window_run(&p), 0);
    double took = seconds() - begin;
    assert_true(hand_is_done(hand));
    print_message("closed by Esc after %.1f s\n", took);
    assert_true(took < 55);
    struct stat shot;
    assert_int_equal(stat("shots/perigee-0001.png", &shot), 0);
    assert_true(shot.st_size > 1000);
}

// The keys, seen by the window's title, which names the modes; the pictures of the split and of a
// single mode by what F12 saves. (test_views.c looks at the pixels.)
static void keys_step_and_split(void **state)
{
    (void)state;
    if (!has_hand()) {
        print_message("xdotool is not there\n");
        skip();
    }
    enum { WIDTH = 400, HEIGHT = 300 };
    static uint8_t split[HEIGHT][WIDTH][3], single[HEIGHT][WIDTH][3];
    const char *first = perigee_mode_name(1), *second = perigee_mode_name(2);
    if (!second) second = perigee_mode_name(0);
    char keys[2048];
    snprintf(
        keys, sizeof keys,
        "set -e; see() { timeout 50 xdotool search --sync --onlyvisible --name \"^" TITLE
        ": $1\\$\" | head -n 1; }\n"
        "id=$(see %s); xdotool mousemove --window $id 200 150 key m; test -n \"$(see %s)\"\n"
        "xdotool key v; test -n \"$(see '%s . %s')\"; xdotool key x key x key x key F12 key m\n"
        "xdotool key v; test -n \"$(see %s)\"; xdotool key F12 key Escape\n",
        perigee_mode_name(0), first, first, second, first);
    mkdir("modes", 0777);
    remove("modes/perigee-0001.png");
    remove("modes/perigee-0002.png");
    pid_t hand = start_hand(keys);
    struct window_params p = params();
    p.screenshot_dir = "modes";
    p.run_s = 100;
    assert_int_equal(window_run(&p), 0);
    assert_true(hand_is_done(hand));
    assert_int_equal(image_png_read("modes/perigee-0001.png", WIDTH, HEIGHT, split[0][0]), OK);
    assert_int_equal(image_png_read("modes/perigee-0002.png", WIDTH, HEIGHT, single[0][0]), OK);
    int white[2] = {0};
    for (int y = 0; y < HEIGHT / 2; y++) {
        white[0] += memcmp(split[y][WIDTH / 2], "\xff\xff\xff", 3) == 0;
        white[1] += memcmp(single[y][WIDTH / 2], "\xff\xff\xff", 3) == 0;
    }
    assert_int_equal(white[0], HEIGHT / 2);
    assert_int_equal(white[1], 0);
}

static int open_planet(void **state)
{
    (void)state;
    if (access(PLANET, F_OK) != 0 && analytic_planet_make(PLANET, 3) != 0) return -1;
    return perigee_planet_open(PLANET, NULL, &planet);
}

static int close_planet(void **state)
{
    (void)state;
    perigee_planet_close(&planet);
    return 0;
}

int main(int argc, char **argv)
{
    (void)argc;
    if (!getenv(INSIDE)) {
        setenv(INSIDE, "1", 1);
        execlp("xvfb-run", "xvfb-run", "-a", "-s", "-screen 0 800x600x24", argv[0], (char *)NULL);
        printf("xvfb-run is not there\n");
        return 77;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_opengl_45),        cmocka_unit_test(no_display),
        cmocka_unit_test(draws_some_frames),   cmocka_unit_test(answers_mouse_and_keyboard),
        cmocka_unit_test(keys_step_and_split),
    };
    return cmocka_run_group_tests(tests, open_planet, close_planet);
}
