#include "app/data_files.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/log.h"

enum { FOLDER_SIZE = 3072 };

static bool exists_in(const char *folder, const char *name, char *path, size_t size)
{
    if (!folder || !folder[0]) return false;
    int length = snprintf(path, size, "%s/%s", folder, name);
    return length > 0 && (size_t)length < size && access(path, F_OK) == 0;
}

// PREFIX/share/perigee when the program is PREFIX/bin/perigee; "" when that cannot be told.
static const char *beside_program(char folder[FOLDER_SIZE])
{
    static const char share[] = "/share/perigee";
    ssize_t length = readlink("/proc/self/exe", folder, FOLDER_SIZE - sizeof share);
    folder[length > 0 ? length : 0] = '\0';
    for (int up = 0; up < 2; up++) {
        char *slash = strrchr(folder, '/');
        if (!slash) return "";
        *slash = '\0';
    }
    return strcat(folder, share);
}

status data_file_find(const char *name, char *path, size_t size)
{
    char folder[FOLDER_SIZE];
    if (exists_in(getenv("PERIGEE_DATA_DIR"), name, path, size) ||
        exists_in(beside_program(folder), name, path, size) ||
        exists_in(PERIGEE_SOURCE_DATA, name, path, size) ||
        exists_in(PERIGEE_INSTALLED_DATA, name, path, size))
        return OK;
    log_error("%s: not in Perigee's data (installed in %s; PERIGEE_DATA_DIR names another folder)",
              name, PERIGEE_INSTALLED_DATA);
    return ERR_NOT_FOUND;
}

status data_earth_path(char *path, size_t size)
{
    const char *earth = getenv("PERIGEE_EARTH"), *data = getenv("XDG_DATA_HOME");
    const char *home = getenv("HOME");
    int length = -1;
    if (earth && earth[0]) length = snprintf(path, size, "%s", earth);
    else if (data && data[0] == '/') length = snprintf(path, size, "%s/perigee/earth.planet", data);
    else if (home && home[0])
        length = snprintf(path, size, "%s/.local/share/perigee/earth.planet", home);
    if (length > 0 && (size_t)length < size) return OK;
    log_error("no place for the default Earth: set HOME or PERIGEE_EARTH");
    return ERR_NOT_FOUND;
}
