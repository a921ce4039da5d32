// Makes the default Earth for the tests of this and other rooms: test_import_default EARTH.planet
// RELIEF.csv. What is there and newer than this program is kept. 77 where the atlas is not
// installed.
#include <stdio.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "planet/import.h"

int main(int argc, char **argv)
{
    struct stat made, program;
    if (argc != 3) return 2;
    if (access("/usr/share/marble/data/maps/earth/srtm/3", R_OK)) {
        printf("skipped: Debian's marble-qt-data is not installed\n");
        return 77;
    }
    if (!stat(argv[1], &made) && !stat("/proc/self/exe", &program) &&
        made.st_mtime > program.st_mtime)
        return 0;
    struct timespec begin, end;
    clock_gettime(CLOCK_MONOTONIC, &begin);
    status s = import_earth(
        &(import_earth_params){.output = argv[1], .relief_csv = argv[2], .force = true});
    clock_gettime(CLOCK_MONOTONIC, &end);
    printf("default Earth made in %.1f s\n",
           (double)(end.tv_sec - begin.tv_sec) + 1e-9 * (double)(end.tv_nsec - begin.tv_nsec));
    return s != OK;
}
