#include "app/output_file.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/log.h"

static status refuse(const char *path, int code)
{
    log_error("%s: cannot write: %s", path, strerror(code));
    return ERR_IO;
}

// The folder a path lies in, "." for a bare name.
static status folder_of(const char *path, char folder[OUTPUT_PATH_SIZE])
{
    const char *slash = strrchr(path, '/');
    size_t length = slash ? (size_t)(slash - path) + 1 : 0;
    if (strlen(path) + 16 > OUTPUT_PATH_SIZE) return refuse(path, ENAMETOOLONG);
    memcpy(folder, path, length);
    strcpy(folder + length, length ? "." : "./.");
    return OK;
}

status output_check(const char *path)
{
    char probe[OUTPUT_PATH_SIZE];
    status s = folder_of(path, probe);
    if (s) return s;
    struct stat info;
    if (stat(path, &info) == 0 && S_ISDIR(info.st_mode)) return refuse(path, EISDIR);
    const char *slash = strrchr(path, '/');
    if (path[0] == '\0' || (slash && slash[1] == '\0')) return refuse(path, EISDIR);
    strcat(probe, "check-XXXXXX");
    int file = mkstemp(probe);
    if (file < 0) return refuse(path, errno);
    close(file);
    unlink(probe);
    return OK;
}

status output_make_folder(const char *path)
{
    char folder[OUTPUT_PATH_SIZE];
    status s = folder_of(path, folder);
    if (s) return s;
    for (char *p = strchr(folder + 1, '/'); p; p = strchr(p + 1, '/')) {
        *p = '\0';
        if (mkdir(folder, 0777) != 0 && errno != EEXIST) {
            log_error("%s: cannot make the folder: %s", folder, strerror(errno));
            return ERR_IO;
        }
        *p = '/';
    }
    return OK;
}

status output_part(const char *path, char part[OUTPUT_PATH_SIZE])
{
    int length = snprintf(part, OUTPUT_PATH_SIZE, "%s.part", path);
    return length < OUTPUT_PATH_SIZE ? OK : refuse(path, ENAMETOOLONG);
}

status output_commit(const char *path)
{
    char part[OUTPUT_PATH_SIZE];
    status s = output_part(path, part);
    if (!s && rename(part, path) != 0) s = refuse(path, errno);
    return s;
}

void output_discard(const char *path)
{
    char part[OUTPUT_PATH_SIZE];
    if (!output_part(path, part)) unlink(part);
}

bool output_has_extension(const char *path, const char *extension)
{
    size_t length = strlen(path), end = strlen(extension);
    return length > end && strcasecmp(path + length - end, extension) == 0;
}
