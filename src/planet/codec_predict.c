#include "planet/codec_predict.h"

#include <endian.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "base/memory.h"
#include "planet/codec_grid.h"
#include "planet/upsample.h"

enum { SAMPLES = TILE_SIZE * TILE_SIZE };

// A gap takes the height before it, in the order of rows; the first ones that of the first there
// is.
static void fill_gaps(float *heights)
{
    float last = 0;
    for (int i = 0; i < SAMPLES; i++)
        if (isfinite(heights[i])) {
            last = heights[i];
            break;
        }
    for (int i = 0; i < SAMPLES; i++) {
        if (isfinite(heights[i])) last = heights[i];
        else heights[i] = last;
    }
}

// A sample of the parent tile; beyond its border on the straight line through the last two.
static float beyond(const float *parent, int64_t row, int64_t col)
{
    const int64_t last = TILE_SIZE - 1;
    int64_t y = row < 0 ? 0 : row > last ? last : row, x = col < 0 ? 0 : col > last ? last : col;
    float v = parent[y * TILE_SIZE + x], h = v;
    if (x != col) {
        int64_t inner = x == 0 ? 1 : last - 1;
        h += (float)(x > col ? x - col : col - x) * (v - parent[y * TILE_SIZE + inner]);
    }
    if (y != row) {
        int64_t inner = y == 0 ? 1 : last - 1;
        h += (float)(y > row ? y - row : row - y) * (v - parent[inner * TILE_SIZE + x]);
    }
    return h;
}

// The parent's samples in a region around it, from `row`, `col` of the parent on.
static void fill_around(const float *parent, const region *around, int64_t row, int64_t col)
{
    int left = col < 0 ? (int)-col : 0, cols = around->cols - left;
    if (cols > TILE_SIZE - (int)(col + left)) cols = TILE_SIZE - (int)(col + left);
    for (int y = 0; y < around->rows; y++) {
        float *to = around->data + y * around->stride;
        int64_t at = row + y;
        bool inside = at >= 0 && at < TILE_SIZE;
        if (inside)
            memcpy(to + left, parent + at * TILE_SIZE + col + left, (size_t)cols * sizeof *to);
        for (int x = 0; x < around->cols; x++)
            if (!inside || x < left || x >= left + cols) to[x] = beyond(parent, at, col + x);
    }
}

static bool has_gaps(const float *heights)
{
    int gaps = 0;
    for (int i = 0; i < SAMPLES; i++) gaps += !isfinite(heights[i]);
    return gaps > 0;
}

void predict_tile(tile_id id, const float *parent, float *predicted)
{
    memset(predicted, 0, SAMPLES * sizeof *predicted);
    if (!parent) return;
    float *whole = NULL;
    if (has_gaps(parent)) {
        whole = NEW_ARRAY(float, SAMPLES);
        memcpy(whole, parent, SAMPLES * sizeof *whole);
        fill_gaps(whole);
    }
    region child = region_of_tile(id, 1, predicted), around = region_parent(&child);
    around.data = NEW_ARRAY(float, (size_t)around.rows *(size_t)around.stride);
    tile_id above = tile_parent(id);
    fill_around(whole ? whole : parent, &around, around.row - (int64_t)TILE_SIZE * above.row,
                around.col - (int64_t)TILE_SIZE * above.col);
    bool flat[TILE_SIZE];
    for (int row = 0; row < TILE_SIZE; row++)
        upsample_child_row(&around, &child, row, predicted + (size_t)row * TILE_SIZE, flat);
    free(around.data);
    free(whole);
}

void predict_count(const float *predicted, int exponent, int32_t *counts)
{
    const float scale = ldexpf(1, -exponent), limit = GRID_COUNT_LIMIT - 1;
    for (int i = 0; i < SAMPLES; i++) {
        float v = predicted[i] * scale;
        v = v < limit ? v : limit; // NaN too
        counts[i] = grid_nearest(v > -limit ? v : -limit);
    }
}

uint32_t predict_checksum(const int32_t *counts)
{
    if (htole32(1) == 1) return XXH32(counts, SAMPLES * sizeof *counts, 0);
    uint32_t *bytes = NEW_ARRAY(uint32_t, SAMPLES);
    for (int i = 0; i < SAMPLES; i++) bytes[i] = htole32((uint32_t)counts[i]);
    uint32_t sum = XXH32(bytes, SAMPLES * sizeof *bytes, 0);
    free(bytes);
    return sum;
}
