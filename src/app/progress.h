// A progress bar with the time left on a terminal; elsewhere a line each 10 %. Main only.
#ifndef PERIGEE_APP_PROGRESS_H
#define PERIGEE_APP_PROGRESS_H

#include <stdbool.h>
#include <stdio.h>

struct progress {
    FILE *file; // NULL: silent
    bool terminal;
    char label[48];
    double start_s, shown_s; // of the monotonic clock; shown < 0: not yet
    double start_done;       // share that was done at start_s
    int tenths;              // lines written off a terminal
};

// quiet: nothing is ever written.
void progress_start(struct progress *p, FILE *file, bool quiet);

// `done` in [0, 1]; another label begins the bar anew. Writes at most ten times a second.
void progress_update(struct progress *p, const char *label, double done);

// Takes the bar away.
void progress_finish(struct progress *p);

// The callback of imports: `user` is a struct progress. Returns true once Ctrl-C was pressed.
bool progress_import(void *user, const char *stage, double done);

// Takes any bar off standard error so that a message can stand there.
void progress_clear_line(void);

// "1:02:03", "2:03", "0:03"; "?" when seconds is not finite.
void progress_format_time(double seconds, char *text, size_t size);

#endif
