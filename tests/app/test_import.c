// perigee import on a terminal and under signals: a bar with the time left, and Ctrl-C in each
// stage, which leaves what is committed, says so, and lets --resume make the same file, byte by
// byte.
#include "app/compare_run.h"

#include <pty.h>
#include <signal.h>
#include <stdbool.h>
#include <sys/wait.h>
#include <unistd.h>

static size_t shown; // bytes of err[] that the terminal has shown

// Raw samples of 16 bits of the whole globe, and as colour: some seconds' work of one thread.
static void write_large(void)
{
    enum { WIDTH = 2600, HEIGHT = 1300 };
    static uint16_t line[WIDTH];
    FILE *f = fopen("large.bil", "wb");
    assert_non_null(f);
    for (int row = 0; row < HEIGHT; row++) {
        for (int col = 0; col < WIDTH; col++)
            line[col] = (uint16_t)(2000 + 900 * sin(row * 0.11) * cos(col * 0.07) +
                                   100 * sin(row * 0.9 + col * 1.3));
        assert_int_equal(fwrite(line, sizeof line, 1, f), 1);
    }
    assert_int_equal(fclose(f), 0);
    char header[512];
    snprintf(header, sizeof header,
             "BYTEORDER I\nLAYOUT BIL\nNROWS %d\nNCOLS %d\nNBANDS 1\nNBITS 16\nULXMAP %.12f\n"
             "ULYMAP %.12f\nXDIM %.12f\nYDIM %.12f\n",
             HEIGHT, WIDTH, -180 + 180.0 / WIDTH, 90 - 90.0 / HEIGHT, 360.0 / WIDTH,
             180.0 / HEIGHT);
    write_text("large.hdr", header);
    static char prj[TEXT_SIZE];
    read_text("globe.prj", prj);
    write_text("large.prj", prj);
}

static int set_up(void **state)
{
    if (run_begin(state)) return -1;
    write_large();
    expect_good("import -q --threads 1 --codec exact --height large.bil --color large.bil "
                "--name Large -o whole.planet");
    return 0;
}

// Starts the import on a terminal of its own, `screen`; gone on with when there is a part.
static pid_t start(const char *output, int *screen)
{
    char part[64];
    snprintf(part, sizeof part, "%s.part", output);
    bool resume = access(part, F_OK) == 0;
    shown = 0;
    err[0] = '\0';
    pid_t child = forkpty(screen, NULL, NULL, &(struct winsize){.ws_row = 24, .ws_col = 90});
    if (child) return child;
    execl(PERIGEE_PROGRAM, PERIGEE_PROGRAM, "import", "--threads", "1", "--codec", "exact",
          "--height", "large.bil", "--color", "large.bil", "--name", "Large", "-o", output,
          resume ? "--resume" : (char *)NULL, (char *)NULL);
    _exit(127);
}

// Waits for more on the terminal and adds it to err[]; false when there is no more.
static bool look(int screen)
{
    ssize_t got = read(screen, err + shown, TEXT_SIZE - 1 - shown);
    if (got > 0) shown += (size_t)got;
    err[shown] = '\0';
    return got > 0;
}

// Reads to the end. The state of waitpid.
static int finish(pid_t child, int screen)
{
    int state;
    while (look(screen)) {
    }
    close(screen);
    assert_int_equal(waitpid(child, &state, 0), child);
    return state;
}

static bool is_done(int state)
{
    return WIFEXITED(state) && WEXITSTATUS(state) == 0;
}

static void press_ctrl_c(int screen)
{
    assert_int_equal(write(screen, "\003", 1), 1);
}

// Status 130 after one line that says how to go on, in place of the bar; no finished file, and what
// is committed is there.
static void expect_interrupted(int state, const char *output)
{
    char path[64];
    if (!WIFEXITED(state) || WEXITSTATUS(state) != 130) fail_msg("%x: %s", (unsigned)state, err);
    const char *said = strstr(err, "import interrupted: the same command with --resume goes on");
    if (!said || count_lines(said) != 1 || strchr(said, '[')) fail_msg("said: %s", err);
    assert_int_equal(access(output, F_OK), -1);
    snprintf(path, sizeof path, "%s.joining", output);
    assert_int_equal(access(path, F_OK), -1);
    snprintf(path, sizeof path, "%s.part", output);
    assert_int_equal(access(path, F_OK), 0);
}

// Runs it to its end: a bar for each stage, the last of them taken away, and the file as in one go.
static void expect_whole(const char *output)
{
    int screen;
    pid_t child = start(output, &screen);
    int state = finish(child, screen);
    if (!is_done(state)) fail_msg("%x: %s", (unsigned)state, err);
    static const char *const bars[] = {"\rheights [", "\rcolour [", "\rjoining [", "] ",
                                       " % left "};
    for (size_t i = 0; i < sizeof bars / sizeof *bars; i++)
        if (!strstr(err, bars[i])) fail_msg("no '%s' in: %s", bars[i], err);
    const char *end = strstr(err, "\r\033[K");
    assert_non_null(end);
    if (!strstr(end, " complete: ") || strstr(end, "] ")) fail_msg("the bar stays: %s", err);
    check_same_files("whole.planet", output);
}

// As a stage begins, by the key or by a request to end.
static void test_interrupted_in_each_stage(void **state)
{
    (void)state;
    static const char *const bars[] = {"\rheights [", "\rcolour [", "\rjoining ["};
    int interrupted = 0;
    for (int i = 0; i < 3 && access("stages.planet", F_OK); i++) {
        int screen;
        pid_t child = start("stages.planet", &screen);
        while (!strstr(err, bars[i]) && look(screen)) {
        }
        if (i == 1) kill(child, SIGTERM);
        else press_ctrl_c(screen);
        int ended = finish(child, screen);
        if (is_done(ended)) break; // it was too quick for this test
        expect_interrupted(ended, "stages.planet");
        interrupted++;
    }
    print_message("interrupted %d times\n", interrupted);
    assert_true(interrupted > 0);
    if (access("stages.planet", F_OK)) expect_whole("stages.planet");
    else check_same_files("whole.planet", "stages.planet");
}

// At times that no stage chose, from before the program is up on.
static void test_interrupted_anywhere(void **state)
{
    (void)state;
    int interrupted = 0;
    for (int ms = 0; ms < 600 && access("any.planet", F_OK); ms += 120) {
        int screen;
        pid_t child = start("any.planet", &screen);
        usleep((useconds_t)(1000 * ms));
        kill(child, SIGINT);
        int ended = finish(child, screen);
        bool early = WIFSIGNALED(ended) && WTERMSIG(ended) == SIGINT; // nobody caught it yet
        interrupted += !is_done(ended);
        if (!early && !is_done(ended)) expect_interrupted(ended, "any.planet");
    }
    print_message("interrupted %d times\n", interrupted);
    assert_true(interrupted > 0);
    if (access("any.planet", F_OK)) expect_whole("any.planet");
    else check_same_files("whole.planet", "any.planet");
}

// Pressed twice it ends at once, as by kill; nothing committed is lost by that either.
static void test_pressed_twice(void **state)
{
    (void)state;
    int screen;
    pid_t child = start("twice.planet", &screen);
    while (!strstr(err, "\rcolour [") && look(screen)) {
    }
    press_ctrl_c(screen);
    press_ctrl_c(screen);
    int ended = finish(child, screen);
    assert_false(is_done(ended));
    expect_whole("twice.planet");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_interrupted_in_each_stage),
        cmocka_unit_test(test_interrupted_anywhere),
        cmocka_unit_test(test_pressed_twice),
    };
    return cmocka_run_group_tests(tests, set_up, run_end);
}
