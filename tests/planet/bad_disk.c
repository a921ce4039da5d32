// Files are wrapped without memory maps, so that every byte of them comes through here.
#include "bad_disk.h"

#include <sqlite3.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

struct wrapped {
    sqlite3_file base; // first
    sqlite3_file *real;
};

static sqlite3_vfs *usual, bad;
static atomic_bool reads_fail;
static atomic_llong room = -1, written;
static atomic_long reads;

static sqlite3_file *real_of(sqlite3_file *f)
{
    return ((struct wrapped *)f)->real;
}

static int bad_close(sqlite3_file *f)
{
    sqlite3_file *real = real_of(f);
    int code = real->pMethods ? real->pMethods->xClose(real) : SQLITE_OK;
    free(real);
    return code;
}

static int bad_read(sqlite3_file *f, void *to, int bytes, sqlite3_int64 at)
{
    reads++;
    if (reads_fail) return SQLITE_IOERR_READ;
    return real_of(f)->pMethods->xRead(real_of(f), to, bytes, at);
}

static int bad_write(sqlite3_file *f, const void *from, int bytes, sqlite3_int64 at)
{
    written += bytes;
    if (room >= 0 && (room -= bytes) < 0) {
        room = 0;
        return SQLITE_FULL;
    }
    return real_of(f)->pMethods->xWrite(real_of(f), from, bytes, at);
}

static int bad_truncate(sqlite3_file *f, sqlite3_int64 size)
{
    return real_of(f)->pMethods->xTruncate(real_of(f), size);
}

static int bad_sync(sqlite3_file *f, int flags)
{
    return real_of(f)->pMethods->xSync(real_of(f), flags);
}

static int bad_size(sqlite3_file *f, sqlite3_int64 *size)
{
    return real_of(f)->pMethods->xFileSize(real_of(f), size);
}

static int bad_lock(sqlite3_file *f, int level)
{
    return real_of(f)->pMethods->xLock(real_of(f), level);
}

static int bad_unlock(sqlite3_file *f, int level)
{
    return real_of(f)->pMethods->xUnlock(real_of(f), level);
}

static int bad_check_lock(sqlite3_file *f, int *held)
{
    return real_of(f)->pMethods->xCheckReservedLock(real_of(f), held);
}

static int bad_control(sqlite3_file *f, int what, void *arg)
{
    return real_of(f)->pMethods->xFileControl(real_of(f), what, arg);
}

static int bad_sector(sqlite3_file *f)
{
    return real_of(f)->pMethods->xSectorSize(real_of(f));
}

static int bad_device(sqlite3_file *f)
{
    return real_of(f)->pMethods->xDeviceCharacteristics(real_of(f));
}

static int bad_shm_map(sqlite3_file *f, int page, int size, int extend, void volatile **out)
{
    return real_of(f)->pMethods->xShmMap(real_of(f), page, size, extend, out);
}

static int bad_shm_lock(sqlite3_file *f, int offset, int n, int flags)
{
    return real_of(f)->pMethods->xShmLock(real_of(f), offset, n, flags);
}

static void bad_shm_barrier(sqlite3_file *f)
{
    real_of(f)->pMethods->xShmBarrier(real_of(f));
}

static int bad_shm_unmap(sqlite3_file *f, int delete_it)
{
    return real_of(f)->pMethods->xShmUnmap(real_of(f), delete_it);
}

static const sqlite3_io_methods methods = {
    .iVersion = 2,
    .xClose = bad_close,
    .xRead = bad_read,
    .xWrite = bad_write,
    .xTruncate = bad_truncate,
    .xSync = bad_sync,
    .xFileSize = bad_size,
    .xLock = bad_lock,
    .xUnlock = bad_unlock,
    .xCheckReservedLock = bad_check_lock,
    .xFileControl = bad_control,
    .xSectorSize = bad_sector,
    .xDeviceCharacteristics = bad_device,
    .xShmMap = bad_shm_map,
    .xShmLock = bad_shm_lock,
    .xShmBarrier = bad_shm_barrier,
    .xShmUnmap = bad_shm_unmap,
};

static int bad_open(sqlite3_vfs *vfs, const char *name, sqlite3_file *f, int flags, int *out)
{
    (void)vfs;
    struct wrapped *w = (struct wrapped *)f;
    w->base.pMethods = NULL;
    w->real = calloc(1, (size_t)usual->szOsFile);
    if (!w->real) return SQLITE_NOMEM;
    int code = usual->xOpen(usual, name, w->real, flags, out);
    if (code == SQLITE_OK || w->real->pMethods) w->base.pMethods = &methods;
    else free(w->real);
    return code;
}

void bad_disk_install(void)
{
    usual = sqlite3_vfs_find(NULL);
    bad = *usual;
    bad.zName = "bad";
    bad.szOsFile = sizeof(struct wrapped);
    bad.xOpen = bad_open;
    sqlite3_vfs_register(&bad, 1);
}

void bad_disk_fail_reads(bool fail)
{
    reads_fail = fail;
}

void bad_disk_room(long long bytes)
{
    room = bytes;
}

long bad_disk_reads(void)
{
    return reads;
}

long long bad_disk_written(void)
{
    return written;
}
