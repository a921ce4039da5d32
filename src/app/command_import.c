#include "app/command.h"

#include <math.h>
#include <stdio.h>
#include <unistd.h>

#include "app/default_earth.h"
#include "app/interrupt.h"
#include "app/progress.h"
#include "app/team.h"
#include "base/log.h"

static import_params raster_params(const struct options *o)
{
    import_params params = {
        .sources = o->sources,
        .source_count = o->source_count,
        .output = o->output ? o->output : "(estimate)",
        .name = o->name ? o->name : o->body_name,
        .attribution = o->attribution,
        .ellipsoid = o->ellipsoid,
        .threads = o->view_params.threads,
        .feather_rows = o->feather_rows,
        .feather_m = o->feather_m,
        .quantum = o->codec == CODEC_EXACT ? 0
                   : isnan(o->quantum)     ? QUANTUM_AUTO
                                           : o->quantum,
        .max_error = o->codec == CODEC_BOUNDED ? o->max_error : 0,
        .resume = o->resume,
        .force = o->force,
        .add = o->add,
    };
    for (int i = 0; i < 4; i++) params.bounds_deg[i] = o->bounds_deg[i];
    return params;
}

// "1.2 GB" and the like, in the powers of ten.
static const char *format_bytes(double bytes, char *text, size_t size)
{
    static const char *const units[] = {"bytes", "kB", "MB", "GB", "TB", "PB"};
    int unit = 0;
    for (; bytes >= 999.5 && unit < 5; unit++) bytes /= 1000;
    snprintf(text, size, unit ? "%.3g %s" : "%.0f %s", bytes, units[unit]);
    return text;
}

static status estimate(const struct options *o)
{
    import_params params = raster_params(o);
    import_estimate e;
    status s = import_estimate_run(&params, &e);
    if (s) return s;
    long processors =
        o->view_params.threads > 0 ? o->view_params.threads : sysconf(_SC_NPROCESSORS_ONLN);
    char bytes[32], left[24];
    progress_format_time(e.core_seconds / (double)processors, left, sizeof left);
    printf("tiles        %llu\n", (unsigned long long)e.tiles);
    printf("samples      %llu\n", (unsigned long long)e.samples);
    printf("file         about %s, while it is made twice as much\n",
           format_bytes(e.bytes, bytes, sizeof bytes));
    printf("time         about %.0f core-seconds, %s with %ld threads\n", e.core_seconds, left,
           processors);
    return OK;
}

static void print_report(const char *output, const import_report *r)
{
    char bytes[32], took[24];
    progress_format_time(r->seconds, took, sizeof took);
    double rate = r->seconds > 0 ? (double)r->samples / r->seconds / r->threads : 0;
    log_info(
        "%s: complete: %llu tiles (%llu made now, %llu of one value), %s, in %s, %.3g M samples "
        "a second and thread",
        output, (unsigned long long)r->tiles, (unsigned long long)r->made,
        (unsigned long long)r->uniform, format_bytes((double)r->bytes, bytes, sizeof bytes), took,
        1e-6 * rate);
}

static status import_together(const struct options *o, import_team *team, int threads)
{
    struct progress progress;
    import_report report;
    bool first = !team || team->rank == 0;
    import_params params = raster_params(o);
    if (params.threads == 0) params.threads = threads;
    params.team = team;
    params.progress = progress_import;
    params.user = &progress;
    params.report = &report;
    interrupt_catch();
    progress_start(&progress, stderr, o->quiet || !first);
    status s = import_run(&params);
    progress_finish(&progress);
    if (!s && first) print_report(o->output, &report);
    return s;
}

static status import_rasters(const struct options *o)
{
    import_team *team;
    int threads;
    status s = team_begin(&team, &threads);
    if (!s) s = import_together(o, team, threads);
    team_end(&team);
    return s;
}

status command_import(const struct options *o)
{
    if (o->estimate) return estimate(o);
    status s = o->earth ? default_earth_make(o) : import_rasters(o);
    if (s == ERR_CANCELLED)
        log_error("import interrupted: the same command with --resume goes on with what is done");
    return s;
}
