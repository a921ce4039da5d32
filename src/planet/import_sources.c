#include "planet/import_sources.h"

#include <cpl_vsi.h>
#include <glob.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"

static void add(import_list *list, const import_source *source, const char *path)
{
    if (list->count == list->capacity) {
        list->capacity = 2 * list->capacity + 16;
        import_input *inputs = NEW_ARRAY(import_input, (size_t)list->capacity);
        if (list->count) memcpy(inputs, list->inputs, (size_t)list->count * sizeof *inputs);
        free(list->inputs);
        list->inputs = inputs;
    }
    import_input *input = &list->inputs[list->count++];
    *input = (import_input){.source = *source};
    input->source.path = path;
}

static const char *keep_name(import_list *list, const char *name)
{
    if (list->name_count == list->name_capacity) {
        list->name_capacity = 2 * list->name_capacity + 16;
        char **names = NEW_ARRAY(char *, (size_t)list->name_capacity);
        if (list->name_count) memcpy(names, list->names, (size_t)list->name_count * sizeof *names);
        free(list->names);
        list->names = names;
    }
    char *copy = NEW_ARRAY(char, strlen(name) + 1);
    strcpy(copy, name);
    return list->names[list->name_count++] = copy;
}

// GDAL's own names (NETCDF:..., /vsicurl/..., <VRTDataset>) may hold the same characters.
static bool is_pattern(const char *path)
{
    VSIStatBufL st;
    if (strncmp(path, "/vsi", 4) == 0 || strpbrk(path, ":<")) return false;
    return strpbrk(path, "*?[") && VSIStatL(path, &st) != 0;
}

static int compare_names(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

static status add_matches(import_list *list, const import_source *source)
{
    glob_t found;
    int code = glob(source->path, GLOB_ERR | GLOB_NOSORT, NULL, &found);
    if (code) {
        log_error("%s: %s", source->path,
                  code == GLOB_NOMATCH ? "matches no file" : "a folder of it cannot be read");
        return code == GLOB_NOMATCH ? ERR_NOT_FOUND : ERR_IO;
    }
    // Not in glob's own order, which is the locale's.
    qsort(found.gl_pathv, found.gl_pathc, sizeof *found.gl_pathv, compare_names);
    for (size_t i = 0; i < found.gl_pathc; i++)
        add(list, source, keep_name(list, found.gl_pathv[i]));
    globfree(&found);
    return OK;
}

status import_list_init(const import_source *sources, int count, import_list *out)
{
    *out = (import_list){0};
    status s = OK;
    for (int i = 0; !s && i < count; i++) {
        if (is_pattern(sources[i].path)) s = add_matches(out, &sources[i]);
        else add(out, &sources[i], sources[i].path);
    }
    return s;
}

void import_list_deinit(import_list *list)
{
    for (int i = 0; i < list->name_count; i++) free(list->names[i]);
    free(list->names);
    free(list->inputs);
    *list = (import_list){0};
}
