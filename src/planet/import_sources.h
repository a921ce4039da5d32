// The sources of an import as files: patterns expanded. Main only.
#ifndef PERIGEE_PLANET_IMPORT_SOURCES_H
#define PERIGEE_PLANET_IMPORT_SOURCES_H

#include "planet/import_raster.h"

// The inputs that the sources name, for import_inputs; `list` holds the names that patterns gave.
typedef struct import_list {
    import_input *inputs;
    int count, capacity;
    char **names;
    int name_count, name_capacity;
} import_list;

// ERR_NOT_FOUND, logged, when a pattern matches nothing. Deinit also after a failure.
status import_list_init(const import_source *sources, int count, import_list *out);
void import_list_deinit(import_list *list);

#endif
