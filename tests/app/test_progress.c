// The bar of long work and its time left, on a terminal, by a clock of the test's own; and what is
// written where there is no terminal.
#include "check.h"

#include <pty.h>
#include <stdbool.h>
#include <time.h>
#include <unistd.h>

#include "app/progress.h"

static double clock_s;

// The linker has the program's own code call this one.
int __wrap_clock_gettime(clockid_t id, struct timespec *out);
int __wrap_clock_gettime(clockid_t id, struct timespec *out)
{
    (void)id;
    *out = (struct timespec){(time_t)clock_s, (long)(1e9 * (clock_s - floor(clock_s)))};
    return 0;
}

static int screen; // what the terminal shows is read here
static FILE *terminal;

static void open_terminal(int columns)
{
    int line;
    struct winsize size = {.ws_row = 24, .ws_col = (unsigned short)columns};
    assert_int_equal(openpty(&screen, &line, NULL, NULL, &size), 0);
    terminal = fdopen(line, "w");
    assert_non_null(terminal);
}

static void close_terminal(void)
{
    fclose(terminal);
    close(screen);
}

// All that was written since the last look.
static const char *shown(void)
{
    static char text[4096];
    assert_int_equal(fflush(terminal), 0);
    assert_true(write(fileno(terminal), "~", 1) == 1); // its end
    size_t n = 0;
    while (n == 0 || text[n - 1] != '~') {
        ssize_t got = read(screen, text + n, sizeof text - 1 - n);
        assert_true(got > 0);
        n += (size_t)got;
    }
    text[n - 1] = '\0';
    return text;
}

static void expect_shown(const char *words)
{
    const char *text = shown();
    if (!strstr(text, words)) fail_msg("'%s' is not in '%s'", words, text);
}

// A tenth in 7 s, then the rest: what is left is what it took, times what is left of the work.
static void time_left_on_a_terminal(void **state)
{
    (void)state;
    struct progress p;
    open_terminal(100);
    clock_s = 1000;
    progress_start(&p, terminal, false);
    progress_update(&p, "heights", 0);
    expect_shown("\rheights [............");
    clock_s += 0.5; // too early to tell
    progress_update(&p, "heights", 0.01);
    expect_shown("1 % left ?");
    clock_s = 1007;
    progress_update(&p, "heights", 0.1);
    expect_shown(" 10 % left 1:03");
    clock_s = 1080;
    progress_update(&p, "heights", 0.01); // slower than thought: 80 s a hundredth
    expect_shown(" 1 % left 2:12:00");
    clock_s = 1080.05; // not ten times a second
    progress_update(&p, "heights", 0.5);
    assert_string_equal(shown(), "");
    clock_s = 1100;
    progress_update(&p, "heights", 0.5);
    expect_shown(" 50 % left 1:40");
    progress_update(&p, "heights", 1); // the end is always shown
    expect_shown("##] 100 % left 0:00");
    progress_finish(&p);
    assert_string_equal(shown(), "\r\033[K");
    close_terminal();
}

// What was done before this run took none of its time; another label begins anew.
static void time_left_of_what_is_gone_on_with(void **state)
{
    (void)state;
    struct progress p;
    open_terminal(80);
    clock_s = 50;
    progress_start(&p, terminal, false);
    progress_update(&p, "colour", 0.8);
    clock_s = 60;
    progress_update(&p, "colour", 0.9);
    expect_shown("90 % left 0:10");
    progress_update(&p, "joining", 0);
    expect_shown("joining [");
    clock_s = 62;
    progress_update(&p, "joining", 0.25);
    expect_shown("25 % left 0:06");
    close_terminal();
}

// A bar is as long as its share, and never wider than the terminal.
static void fits_its_terminal(void **state)
{
    (void)state;
    for (int columns = 20; columns <= 200; columns += 9) {
        struct progress p;
        open_terminal(columns);
        clock_s = 0;
        progress_start(&p, terminal, false);
        progress_update(&p, "heights", 0);
        shown();
        clock_s = 3600;
        progress_update(&p, "heights", 0.5);
        const char *text = shown();
        int full = 0, empty = 0;
        for (const char *c = text; *c; c++) full += *c == '#', empty += *c == '.';
        assert_true(full == empty || full == empty - 1);
        const char *end = strstr(text, "\033[K");
        assert_non_null(end);
        int width = (int)(end - text) - 1; // less the return
        if (columns > 40 && width > columns) fail_msg("%d columns of %d", width, columns);
        if (columns > 40) assert_true(full + empty > 0);
        close_terminal();
    }
}

// In a file: a line each tenth, none twice, no bar; nothing when quiet.
static void a_line_each_tenth_elsewhere(void **state)
{
    (void)state;
    char *text = NULL;
    size_t size = 0;
    struct progress p;
    FILE *file = tmpfile();
    assert_non_null(file);
    progress_start(&p, file, true);
    progress_update(&p, "heights", 1);
    assert_int_equal(ftell(file), 0);
    progress_start(&p, file, false);
    for (int i = 0; i <= 100; i++) progress_update(&p, "heights", i / 100.0);
    progress_update(&p, "colour", 0.35);
    progress_finish(&p);
    rewind(file);
    assert_true(getdelim(&text, &size, '\0', file) > 0);
    assert_string_equal(text, "heights: 10 %\nheights: 20 %\nheights: 30 %\nheights: 40 %\n"
                              "heights: 50 %\nheights: 60 %\nheights: 70 %\nheights: 80 %\n"
                              "heights: 90 %\nheights: 100 %\ncolour: 30 %\n");
    free(text);
    fclose(file);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(time_left_on_a_terminal),
        cmocka_unit_test(time_left_of_what_is_gone_on_with),
        cmocka_unit_test(fits_its_terminal),
        cmocka_unit_test(a_line_each_tenth_elsewhere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
