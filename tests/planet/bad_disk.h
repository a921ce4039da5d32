// A disk that fails as told, for everything that SQLite does in this process: a VFS around the
// usual one. Any thread.
#ifndef PERIGEE_TESTS_BAD_DISK_H
#define PERIGEE_TESTS_BAD_DISK_H

#include <stdbool.h>

// Before any file is opened.
void bad_disk_install(void);

// Reads answer that the medium failed.
void bad_disk_fail_reads(bool fail);

// After so many more bytes written the disk is full; < 0: never.
void bad_disk_room(long long bytes);

// Reads and bytes written so far.
long bad_disk_reads(void);
long long bad_disk_written(void);

#endif
