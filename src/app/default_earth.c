#include "app/default_earth.h"

#include <stdio.h>
#include <unistd.h>

#include "app/data_files.h"
#include "app/interrupt.h"
#include "app/output_file.h"
#include "app/progress.h"
#include "base/log.h"

static status make(const struct options *o, const char *output, bool resume)
{
    char relief[OUTPUT_PATH_SIZE];
    status s = data_file_find("atlas-relief-metres.csv", relief, sizeof relief);
    if (s) return s;
    struct progress progress;
    import_earth_params params = {
        .atlas_dir = o->atlas_dir,
        .relief_csv = relief,
        .output = output,
        .threads = o->view_params.threads,
        .bathymetry = o->bathymetry,
        .force = o->force,
        .resume = resume,
        .progress = progress_import,
        .user = &progress,
    };
    interrupt_catch();
    progress_start(&progress, stderr, o->quiet);
    s = import_earth(&params);
    progress_finish(&progress);
    if (!s) log_info("%s: complete", output);
    return s;
}

status default_earth_make(const struct options *o)
{
    char path[OUTPUT_PATH_SIZE];
    if (o->output) return make(o, o->output, o->resume);
    status s = data_earth_path(path, sizeof path);
    if (!s) s = output_make_folder(path);
    return s ? s : make(o, path, o->resume);
}

status default_earth_find(const struct options *o, char *path, size_t size)
{
    status s = data_earth_path(path, size);
    if (s || access(path, F_OK) == 0) return s;
    s = output_make_folder(path);
    if (s) return s;
    if (!o->quiet) log_info("making the default Earth, once: %s", path);
    s = make(o, path, false);
    if (s == ERR_CANCELLED)
        log_error("%s: the default Earth was not finished; the next start makes it", path);
    return s;
}
