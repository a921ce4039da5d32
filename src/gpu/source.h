// The text of one shader put together from files: #version, defines, and the entry file with its
// includes. Private to the room. Main only.
#ifndef PERIGEE_GPU_SOURCE_H
#define PERIGEE_GPU_SOURCE_H

#include <stddef.h>

#include "base/status.h"

enum { SOURCE_MAX_FILES = 64 };

struct source {
    char *text; // zero-terminated
    size_t size, capacity;
    char *names[SOURCE_MAX_FILES]; // by file number; 0 is the defines
    int name_count;
};

// `dir` NULL: the embedded files. On failure (logged with the missing file and who wanted it) `out`
// is empty.
status source_assemble(const char *dir, const char *entry, const char *defines, struct source *out);
void source_deinit(struct source *s);

// Writes the first error line of a compiler's log into `line`, its file number replaced by the
// file's name.
void source_map_message(const struct source *s, const char *log, char *line, size_t line_size);

#endif
