#include "app/command.h"

#include "app/default_earth.h"
#include "app/interrupt.h"
#include "app/output_file.h"
#include "app/progress.h"
#include "base/log.h"
#include "planet/export.h"

status command_export(const struct options *o)
{
    char earth[OUTPUT_PATH_SIZE];
    status s = o->planet ? OK : default_earth_find(o, earth, sizeof earth);
    if (s) return s;
    struct progress progress;
    export_result result;
    export_params params = {.input = o->planet ? o->planet : earth,
                            .output = o->output,
                            .threads = o->view_params.threads,
                            .force = o->force,
                            .progress = progress_import,
                            .user = &progress};
    interrupt_catch();
    progress_start(&progress, stderr, o->quiet);
    s = export_run(&params, &result);
    progress_finish(&progress);
    if (!s)
        log_info("%s/planet.json: %llu tiles, %.1f MB", o->output, (unsigned long long)result.tiles,
                 (double)result.bytes / 1e6);
    return s;
}
