#include "app/progress.h"

#include <math.h>
#include <string.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

#include "app/interrupt.h"
#include "base/vec.h"

enum { BAR_MAX = 60, LINE_RESERVE = 24 };

#define REDRAW_S   0.1
#define ESTIMATE_S 1.0 // no time left is shown before this much has passed

static double now_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

void progress_start(struct progress *p, FILE *file, bool quiet)
{
    *p = (struct progress){.file = quiet ? NULL : file, .shown_s = -1};
    p->terminal = p->file && isatty(fileno(file));
}

void progress_format_time(double seconds, char *text, size_t size)
{
    if (!isfinite(seconds) || seconds < 0 || seconds > 1e7) {
        snprintf(text, size, "?");
        return;
    }
    long t = lround(seconds);
    if (t >= 3600) snprintf(text, size, "%ld:%02ld:%02ld", t / 3600, t / 60 % 60, t % 60);
    else snprintf(text, size, "%ld:%02ld", t / 60, t % 60);
}

static void begin_label(struct progress *p, const char *label, double done)
{
    snprintf(p->label, sizeof p->label, "%s", label);
    p->start_s = now_s();
    p->start_done = done;
    p->shown_s = -1;
    p->tenths = 0;
}

static double seconds_left(const struct progress *p, double done)
{
    double elapsed = now_s() - p->start_s, advanced = done - p->start_done;
    return elapsed < ESTIMATE_S || advanced <= 0 ? NAN : elapsed * (1 - done) / advanced;
}

static void draw_bar(struct progress *p, double done)
{
    struct winsize window = {0};
    ioctl(fileno(p->file), TIOCGWINSZ, &window);
    int columns = window.ws_col > 0 ? window.ws_col : 80;
    int room = columns - LINE_RESERVE - (int)strlen(p->label);
    int width = room < 0 ? 0 : room > BAR_MAX ? BAR_MAX : room;
    int full = (int)(done * width);
    char bar[BAR_MAX + 1], left[24];
    memset(bar, '.', (size_t)width);
    memset(bar, '#', (size_t)full);
    bar[width] = '\0';
    progress_format_time(seconds_left(p, done), left, sizeof left);
    fprintf(p->file, "\r%s [%s] %3.0f %% left %s\033[K", p->label, bar, floor(100 * done), left);
    fflush(p->file);
}

void progress_update(struct progress *p, const char *label, double done)
{
    if (!p->file) return;
    done = clamp_double(done, 0, 1);
    if (strncmp(label, p->label, sizeof p->label - 1) != 0) begin_label(p, label, done);
    if (p->terminal) {
        double now = now_s();
        if (p->shown_s >= 0 && now - p->shown_s < REDRAW_S && done < 1) return;
        p->shown_s = now;
        draw_bar(p, done);
        return;
    }
    int tenths = (int)floor(10 * done + 1e-9);
    if (tenths <= p->tenths) return;
    p->tenths = tenths;
    fprintf(p->file, "%s: %d %%\n", p->label, 10 * tenths);
}

void progress_finish(struct progress *p)
{
    if (p->file && p->terminal) fprintf(p->file, "\r\033[K");
    p->label[0] = '\0';
}

bool progress_import(void *user, const char *stage, double done)
{
    progress_update(user, stage, done);
    return interrupt_requested();
}

void progress_clear_line(void)
{
    if (isatty(STDERR_FILENO)) fputs("\r\033[K", stderr);
}
