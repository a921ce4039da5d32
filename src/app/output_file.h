// Files that are whole or not there: written as PATH.part and renamed when complete. Main only.
#ifndef PERIGEE_APP_OUTPUT_FILE_H
#define PERIGEE_APP_OUTPUT_FILE_H

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

enum { OUTPUT_PATH_SIZE = 4096 };

// Says early whether a file could be made at `path`: its folder is there and takes files, and no
// folder has its name. ERR_IO, logged with the path.
status output_check(const char *path);

// Makes the folder that `path` lies in, with its parents. ERR_IO, logged.
status output_make_folder(const char *path);

// "PATH.part". ERR_ARGUMENT, logged, when that is too long.
status output_part(const char *path, char part[OUTPUT_PATH_SIZE]);

// PATH.part becomes PATH. ERR_IO, logged.
status output_commit(const char *path);

// Removes PATH.part.
void output_discard(const char *path);

// Does the path end in this extension (".png"), whatever its case?
bool output_has_extension(const char *path, const char *extension);

#endif
