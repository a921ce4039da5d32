#include "planet/atlas.h"

#include <errno.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <turbojpeg.h>

#include "base/log.h"
#include "base/memory.h"

// The largest tile file read; the package's have some 60 kB.
enum { MAX_TILE_BYTES = 8 << 20 };

static void find_intervals(atlas_table *t)
{
    for (int g = 0; g < 256; g++) {
        float below = g ? t->metres[g - 1] : 2 * t->metres[0] - t->metres[1];
        float above = g < 255 ? t->metres[g + 1] : 2 * t->metres[255] - t->metres[254];
        t->low[g] = (below + t->metres[g]) / 2;
        t->high[g] = (t->metres[g] + above) / 2;
    }
    t->high[ATLAS_SEA_GREY] = t->low[ATLAS_SEA_GREY + 1] = 0;
}

static status check_table(const char *csv, const atlas_table *t)
{
    for (int g = 0; g < 256; g++) {
        if (isnan(t->metres[g])) {
            log_error("%s: has no row for grey %d", csv, g);
            return ERR_FORMAT;
        }
        if (g && t->metres[g] < t->metres[g - 1]) {
            log_error("%s: grey %d (%g m) is lower than grey %d (%g m)", csv, g,
                      (double)t->metres[g], g - 1, (double)t->metres[g - 1]);
            return ERR_FORMAT;
        }
    }
    if (t->metres[ATLAS_SEA_GREY] < 0 && t->metres[ATLAS_SEA_GREY + 1] > 0) return OK;
    log_error("%s: sea level does not lie between greys %d and %d", csv, ATLAS_SEA_GREY,
              ATLAS_SEA_GREY + 1);
    return ERR_FORMAT;
}

status atlas_read_table(const char *csv, atlas_table *out)
{
    FILE *f = fopen(csv, "r");
    if (!f) {
        log_error("%s: cannot be opened: %s", csv, strerror(errno));
        return ERR_NOT_FOUND;
    }
    for (int g = 0; g < 256; g++) out->metres[g] = NAN;
    char line[512];
    while (fgets(line, sizeof line, f)) {
        int grey;
        float metres;
        if (sscanf(line, "%d,%f", &grey, &metres) != 2) continue;
        if (grey >= 0 && grey < 256) out->metres[grey] = metres;
    }
    fclose(f);
    status s = check_table(csv, out);
    if (!s) find_intervals(out);
    return s;
}

char *atlas_tile_path(const char *dir, int row, int col)
{
    char *path;
    if (asprintf(&path, "%s/earth/srtm/3/%06d/%06d_%06d.jpg", dir, row, row, col) < 0) abort();
    return path;
}

static status read_file(const char *path, unsigned char **data, unsigned long *size)
{
    FILE *f = fopen(path, "rb");
    if (!f) {
        log_error("%s: cannot be opened: %s", path, strerror(errno));
        return ERR_NOT_FOUND;
    }
    *data = malloc(MAX_TILE_BYTES);
    *size = *data ? fread(*data, 1, MAX_TILE_BYTES, f) : 0;
    bool failed = ferror(f);
    fclose(f);
    if (!*data) return ERR_MEMORY;
    if (!failed && *size < MAX_TILE_BYTES) return OK;
    log_error("%s: cannot be read", path);
    return ERR_IO;
}

static status decode_tile(const char *path, const unsigned char *data, unsigned long size,
                          unsigned char *greys)
{
    tjhandle jpeg = tjInitDecompress();
    if (!jpeg) return ERR_MEMORY;
    int width = 0, height = 0, sampling, space;
    status s = OK;
    if (tjDecompressHeader3(jpeg, data, size, &width, &height, &sampling, &space)) {
        log_error("%s: is not a JPEG image: %s", path, tjGetErrorStr2(jpeg));
        s = ERR_FORMAT;
    } else if (width != ATLAS_TILE || height != ATLAS_TILE) {
        log_error("%s: has %d x %d samples, not %d x %d", path, width, height, ATLAS_TILE,
                  ATLAS_TILE);
        s = ERR_FORMAT;
    } else if (tjDecompress2(jpeg, data, size, greys, width, ATLAS_WIDTH, height, TJPF_GRAY,
                             TJFLAG_ACCURATEDCT)) {
        log_error("%s: is damaged: %s", path, tjGetErrorStr2(jpeg));
        s = ERR_FORMAT;
    }
    tjDestroy(jpeg);
    return s;
}

status atlas_read_tile(const char *dir, int row, int col, unsigned char *greys)
{
    char *path = atlas_tile_path(dir, row, col);
    unsigned char *data = NULL;
    unsigned long size = 0;
    status s = read_file(path, &data, &size);
    size_t first = (size_t)row * ATLAS_TILE * ATLAS_WIDTH + (size_t)col * ATLAS_TILE;
    if (!s) s = decode_tile(path, data, size, greys + first);
    free(data);
    free(path);
    return s;
}

// A stretch of one row at or below sea level. `root` links to an earlier or the same run; `deepest`
// holds for roots.
struct run {
    int row, first, last;
    uint32_t root;
    unsigned char deepest;
};

static uint32_t find_root(struct run *runs, uint32_t i)
{
    while (runs[i].root != i) i = runs[i].root = runs[runs[i].root].root;
    return i;
}

static void join(struct run *runs, uint32_t a, uint32_t b)
{
    a = find_root(runs, a);
    b = find_root(runs, b);
    if (a == b) return;
    if (b < a) {
        uint32_t swap = a;
        a = b;
        b = swap;
    }
    runs[b].root = a;
    if (runs[b].deepest < runs[a].deepest) runs[a].deepest = runs[b].deepest;
}

static struct run *find_runs(const unsigned char *greys, int width, int height, uint32_t *count)
{
    size_t room = 1 << 16, n = 0;
    struct run *runs = malloc(room * sizeof *runs);
    for (int y = 0; runs && y < height; y++) {
        const unsigned char *g = greys + (size_t)y * (size_t)width;
        for (int x = 0; x < width; x++) {
            if (g[x] > ATLAS_SEA_GREY) continue;
            if (n == room) {
                room *= 2;
                struct run *more = realloc(runs, room * sizeof *runs);
                if (!more) free(runs);
                runs = more;
                if (!runs) return NULL;
            }
            struct run r = {y, x, x, (uint32_t)n, g[x]};
            for (; x < width && g[x] <= ATLAS_SEA_GREY; x++)
                if (g[x] < r.deepest) r.deepest = g[x];
            r.last = x - 1;
            runs[n++] = r;
        }
    }
    *count = (uint32_t)n;
    return runs;
}

// Joins a run to those of an earlier row, `below[...]`, that come within `reach` columns; they
// stand in order.
static void join_row(struct run *runs, uint32_t first, uint32_t end, uint32_t i, int reach)
{
    uint32_t low = first, high = end;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (runs[middle].last + reach < runs[i].first) low = middle + 1;
        else high = middle;
    }
    for (uint32_t k = low; k < end && runs[k].first <= runs[i].last + reach; k++) join(runs, k, i);
}

// Joins runs that touch over an edge or lie at most `gap` samples apart, also across the left and
// right border.
static void join_runs(struct run *runs, uint32_t count, int width, int height, int gap)
{
    uint32_t *begin = NEW_ARRAY(uint32_t, (size_t)height + 1);
    uint32_t next = 0;
    for (int y = 0; y <= height; y++) {
        while (next < count && runs[next].row < y) next++;
        begin[y] = next;
    }
    for (uint32_t i = 0; i < count; i++) {
        int y = runs[i].row;
        if (i > begin[y] && runs[i].first - runs[i - 1].last - 1 <= gap) join(runs, i - 1, i);
        if (i + 1 == begin[y + 1] && width - 1 - runs[i].last + runs[begin[y]].first <= gap)
            join(runs, begin[y], i);
        for (int up = 1; up <= gap + 1 && up <= y; up++)
            join_row(runs, begin[y - up], begin[y - up + 1], i, gap);
    }
    free(begin);
}

status atlas_find_sea(const unsigned char *greys, int width, int height, int deep_grey, int gap,
                      unsigned char *sea)
{
    uint32_t count = 0;
    struct run *runs = find_runs(greys, width, height, &count);
    if (!runs) {
        log_error("out of memory for the sea of %d x %d samples", width, height);
        return ERR_MEMORY;
    }
    join_runs(runs, count, width, height, gap);
    memset(sea, 0, (size_t)width * (size_t)height);
    for (uint32_t i = 0; i < count; i++) {
        if (runs[find_root(runs, i)].deepest > deep_grey) continue;
        size_t at = (size_t)runs[i].row * (size_t)width + (size_t)runs[i].first;
        memset(sea + at, 1, (size_t)(runs[i].last - runs[i].first + 1));
    }
    free(runs);
    return OK;
}
