// A patch is filled in bands: its rows that lie in one tile row, at most two of them. A band from a
// row of tiles of another width is fetched in that row's columns and then resampled by a four-point
// filter.
#include "planet/patch.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "planet/upsample.h"

// Columns that a band of another width may need: twice a patch's, and the filter's reach.
enum { BAND_MAX_COLS = 2 * PATCH_MAX_COLS + 2, BAND_MAX_CHANNELS = 4 };

// Rows [row, row + rows) of tile row `tile_row`, columns from `west` on (any integer; they wrap).
struct span {
    int zoom, tile_row, row, rows;
    int64_t west;
    int cols;
};

static int64_t wrap(int64_t x, int64_t period)
{
    int64_t r = x % period;
    return r < 0 ? r + period : r;
}

static status fetch_span(const struct patch *p, const struct span *s, patch_fetch fetch, void *user,
                         float *out, int stride)
{
    int64_t period = (int64_t)TILE_SIZE * grid_cols(s->zoom, s->tile_row);
    for (int done = 0; done < s->cols;) {
        int64_t x = wrap(s->west + done, period);
        int col = (int)(x % TILE_SIZE), left = s->cols - done;
        int n = TILE_SIZE - col < left ? TILE_SIZE - col : left;
        patch_block block = {{p->child.layer, s->zoom, s->tile_row, (int)(x / TILE_SIZE)},
                             s->row,
                             s->rows,
                             col,
                             n,
                             out + (size_t)done * p->channels,
                             stride};
        status st = fetch(user, &block);
        if (st) return st;
        done += n;
    }
    return OK;
}

// From columns half as wide: target column k lies midway between source columns 2k + 1 and 2k + 2.
static void shrink(const float *src, int channels, int cols, float *out)
{
    for (int k = 0; k < cols; k++)
        for (int c = 0; c < channels; c++) {
            const float *s = src + (size_t)2 * k * channels + c;
            float outer = s[0] + s[3 * channels], inner = s[channels] + s[2 * channels];
            out[k * channels + c] = (9.0f * inner - outer) * 0.0625f;
        }
}

// A band whose tiles have another width than the patch's. At most PATCH_MARGIN rows.
static status fetch_resampled(const struct patch *p, struct span s, bool narrow, patch_fetch fetch,
                              void *user, float *out)
{
    float band[PATCH_MARGIN * BAND_MAX_COLS * BAND_MAX_CHANNELS];
    assert(s.rows <= PATCH_MARGIN);
    int cols = s.cols, odd = (int)wrap(s.west, 2);
    s.west = narrow ? 2 * s.west - 1 : (s.west - odd) / 2 - 2;
    s.cols = narrow ? 2 * cols + 2 : cols / 2 + 5;
    int stride = s.cols * p->channels;
    status st = fetch_span(p, &s, fetch, user, band, stride);
    for (int r = 0; !st && r < s.rows; r++) {
        float *row = out + (size_t)r * p->cols * p->channels;
        if (narrow) shrink(band + r * stride, p->channels, cols, row);
        else upsample_row(band + r * stride, p->channels, odd, cols, row);
    }
    return st;
}

// Patch rows [first, first + rows), which lie in one tile row or all beyond one pole.
static status fill_band(struct patch *p, int first, int rows, patch_fetch fetch, void *user)
{
    int zoom = p->child.zoom - 1, half = TILE_SIZE / 2;
    int parent_row = p->child.row / 2;
    int64_t global = (int64_t)half * p->child.row - PATCH_MARGIN + first;
    int64_t last_row = (int64_t)TILE_SIZE * grid_rows(zoom) - 1;
    int stride = p->cols * p->channels;
    float *out = p->data + (size_t)first * stride;
    bool beyond = global < 0 || global > last_row;
    int64_t top = global < 0          ? -global - rows
                  : global > last_row ? 2 * last_row + 2 - global - rows
                                      : global;
    struct span s = {zoom, (int)(top / TILE_SIZE), (int)(top % TILE_SIZE), rows, 0, p->cols};
    s.west = (int64_t)TILE_SIZE / p->lon_factor * p->child.col - PATCH_MARGIN;
    int width = grid_coalesce(zoom, s.tile_row), parent_width = grid_coalesce(zoom, parent_row);
    if (beyond) s.west += (int64_t)TILE_SIZE * grid_cols(zoom, s.tile_row) / 2;
    status st = width == parent_width
                    ? fetch_span(p, &s, fetch, user, out, stride)
                    : fetch_resampled(p, s, width < parent_width, fetch, user, out);
    for (int r = 0; !st && beyond && r < rows / 2;
         r++) // fetched southwards, but beyond a pole rows run back
        for (int i = 0; i < stride; i++) {
            float *a = out + r * stride + i, *b = out + (rows - 1 - r) * stride + i, t = *a;
            *a = *b;
            *b = t;
        }
    return st;
}

status patch_init(struct patch *p, tile_id child, int channels, patch_fetch fetch, void *user)
{
    assert(child.zoom > 0 && (channels == 1 || channels == 4));
    int parent_width = grid_coalesce(child.zoom - 1, child.row / 2);
    *p = (struct patch){.child = child, .channels = channels};
    p->lon_factor = 2 * parent_width / grid_coalesce(child.zoom, child.row);
    assert(p->lon_factor == 1 || p->lon_factor == 2);
    p->cols = TILE_SIZE / p->lon_factor + 2 * PATCH_MARGIN;
    p->data = malloc(sizeof(float) * PATCH_ROWS * p->cols * channels);
    if (!p->data) return ERR_MEMORY;
    // The northern child's two first rows lie in the tile row before, the southern one's last two
    // in the tile row after.
    int split = child.row % 2 == 0 ? PATCH_MARGIN : PATCH_ROWS - PATCH_MARGIN;
    status s = fill_band(p, 0, split, fetch, user);
    if (!s) s = fill_band(p, split, PATCH_ROWS - split, fetch, user);
    if (s) patch_deinit(p);
    return s;
}

void patch_deinit(struct patch *p)
{
    free(p->data);
    *p = (struct patch){0};
}
