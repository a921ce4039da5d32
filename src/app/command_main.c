#include "app/command.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/data_files.h"
#include "app/help.h"
#include "app/output_file.h"
#include "app/progress.h"
#include "app/window.h"
#include "base/log.h"
#include "gpu/context.h"

// The headless showcase that `perigee` alone renders where there is no display.
#define SHOWCASE_PATH "flights/orbit-to-garda.json"

static void print_line(void *user, enum log_level level, const char *line)
{
    int *errors = user;
    static const char *const prefix[] = {"error: ", "warning: ", "", ""};
    if (level == LOG_ERROR) ++*errors;
    progress_clear_line();
    fprintf(stderr, "perigee: %s%s\n", prefix[level], line);
}

static status run(const struct options *o)
{
    static status (*const commands[COMMAND_COUNT])(const struct options *) = {
        command_view, command_render,  command_fly,    command_import,
        command_info, command_compare, command_export,
    };
    if (o->help) {
        help_command(stdout, o->command);
        return OK;
    }
    if (o->quiet) log_set_level(LOG_WARN);
    if (o->verbose) log_set_level(LOG_DEBUG);
    gpu_tune_allocator();
    return commands[o->command](o);
}

static status run_command(enum command command, int argc, char **argv)
{
    struct options o;
    status s = options_parse(command, argc, argv, &o);
    if (s) return s;
    s = run(&o);
    options_deinit(&o);
    return s;
}

static status run_alone(void)
{
    char path[OUTPUT_PATH_SIZE];
    char *view[] = {"view", NULL};
    char *fly[] = {"fly",
                   "--path",
                   path,
                   "--fps",
                   "8",
                   "--size",
                   "960x540",
                   "-o",
                   "frames/%05d.png",
                   "--contact-sheet",
                   "frames/contact-sheet.png",
                   NULL};
    if (window_display_available()) return run_command(COMMAND_VIEW, 1, view);
    status s = data_file_find(SHOWCASE_PATH, path, sizeof path);
    return s ? s : run_command(COMMAND_FLY, (int)(sizeof fly / sizeof fly[0]) - 1, fly);
}

static status dispatch(int argc, char **argv)
{
    enum command command;
    const char *first = argc > 1 ? argv[1] : NULL;
    if (!first) return run_alone();
    if (command_find(first, &command)) return run_command(command, argc - 1, argv + 1);
    if (strcmp(first, "--help") == 0 || strcmp(first, "-h") == 0 || strcmp(first, "help") == 0) {
        help_program(stdout);
        return OK;
    }
    if (strcmp(first, "--version") == 0) {
        printf("perigee %s\n", perigee_version());
        return OK;
    }
    log_error("unknown command '%s' (view, render, fly, import, info, compare, export; see perigee "
              "--help)",
              first);
    return ERR_ARGUMENT;
}

int command_main(int argc, char **argv)
{
    int errors = 0;
    log_set_sink(print_line, &errors);
    status s = dispatch(argc, argv);
    if ((fflush(stdout) != 0 || ferror(stdout)) && !s) {
        log_error("standard output: cannot write: %s", strerror(errno));
        s = ERR_IO;
    }
    if (s && errors == 0) {
        const char *why = perigee_last_error();
        log_error("%s", why && why[0] ? why : status_text(s));
    }
    log_set_sink(NULL, NULL);
    return s == OK ? EXIT_SUCCESS : s == ERR_CANCELLED ? 130 : EXIT_FAILURE;
}
