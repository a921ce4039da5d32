#include "app/command.h"

#include <stdio.h>

#include "app/default_earth.h"
#include "app/interrupt.h"
#include "app/progress.h"
#include "base/log.h"

static status import_rasters(const struct options *o)
{
    struct progress progress;
    import_params params = {
        .sources = o->sources,
        .source_count = o->source_count,
        .output = o->output,
        .name = o->name ? o->name : o->body_name,
        .attribution = o->attribution,
        .ellipsoid = o->ellipsoid,
        .threads = o->view_params.threads,
        .feather_rows = o->feather_rows,
        .resume = o->resume,
        .force = o->force,
        .progress = progress_import,
        .user = &progress,
    };
    for (int i = 0; i < 4; i++) params.bounds_deg[i] = o->bounds_deg[i];
    interrupt_catch();
    progress_start(&progress, stderr, o->quiet);
    status s = import_run(&params);
    progress_finish(&progress);
    if (!s) log_info("%s: complete", o->output);
    return s;
}

status command_import(const struct options *o)
{
    status s = o->earth ? default_earth_make(o) : import_rasters(o);
    if (s == ERR_CANCELLED)
        log_error("import interrupted: the same command with --resume goes on with what is done");
    return s;
}
