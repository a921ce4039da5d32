// A rectangle is split as little as possible, because what is split is made twice at every coarser
// zoom: only where tile rows of different widths meet. Beyond a pole the whole circle is made once,
// instead of two opposite pieces.
#include "planet/region.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "planet/upsample.h"

static int64_t wrap(int64_t x, int64_t period)
{
    int64_t r = x % period;
    return r < 0 ? r + period : r;
}

static int64_t half(int64_t x)
{
    return (x - wrap(x, 2)) / 2;
}

int64_t region_first_tap(int64_t x)
{
    return half(x) + wrap(x, 2) - 2;
}

static int64_t circle(const region *r)
{
    return 2 * (int64_t)TILE_SIZE * grid_rows(r->zoom) / r->coalesce;
}

static int tile_row_of(int64_t row)
{
    return (int)(row / TILE_SIZE);
}

// The rows [first, first + rows) of r, counted from r's first.
static region rows_of(const region *r, int first, int rows)
{
    region part = *r;
    part.row += first;
    part.rows = rows;
    part.data += (size_t)first * (size_t)r->stride;
    return part;
}

static status allocate(region *r)
{
    r->stride = r->cols * r->channels;
    r->data = malloc(sizeof *r->data * (size_t)r->stride * (size_t)r->rows);
    return r->data ? OK : ERR_MEMORY;
}

region region_of_tile(tile_id id, int channels, float *data)
{
    return (region){.layer = id.layer,
                    .channels = channels,
                    .zoom = id.zoom,
                    .row = (int64_t)TILE_SIZE * id.row,
                    .rows = TILE_SIZE,
                    .coalesce = grid_coalesce(id.zoom, id.row),
                    .col = (int64_t)TILE_SIZE * id.col,
                    .cols = TILE_SIZE,
                    .stride = TILE_SIZE * channels,
                    .data = data};
}

region region_parent(const region *r)
{
    region p = *r;
    int odd = (int)wrap(r->col, 2), tile_row = tile_row_of(r->row);
    p.zoom = r->zoom - 1;
    p.coalesce = grid_coalesce(p.zoom, tile_row / 2);
    p.row = region_first_tap(r->row);
    p.rows = (int)(region_first_tap(r->row + r->rows - 1) + 4 - p.row);
    if (2 * p.coalesce == r->coalesce) { // the same columns, and one beside for their relief
        p.col = r->col - 1;
        p.cols = r->cols + 2;
    } else {
        p.col = region_first_tap(r->col - odd);
        p.cols = (r->cols + odd + 1) / 2 + 4;
    }
    p.stride = p.cols * p.channels;
    p.data = NULL;
    return p;
}

status region_make(const region_source *source, const region *r)
{
    region parent = region_parent(r);
    assert(r->zoom > 0 && parent.cols <= REGION_MAX_COLS);
    status s = allocate(&parent);
    if (!s) s = region_fill(source, &parent);
    if (!s) s = source->make(source->user, &parent, r);
    free(parent.data);
    return s;
}

// Asks for every block of the rectangle; stops at the first that is not found, unless `stored`.
static status fetch_blocks(const region_source *source, const region *r, bool stored, bool *all)
{
    status pending = OK;
    *all = true;
    for (int y = 0; y < r->rows;) {
        int row = (int)((r->row + y) % TILE_SIZE);
        int rows = TILE_SIZE - row < r->rows - y ? TILE_SIZE - row : r->rows - y;
        for (int x = 0; x < r->cols;) {
            int64_t at = wrap(r->col + x, circle(r));
            int col = (int)(at % TILE_SIZE);
            int cols = TILE_SIZE - col < r->cols - x ? TILE_SIZE - col : r->cols - x;
            tile_id id = {r->layer, r->zoom, tile_row_of(r->row + y), (int)(at / TILE_SIZE)};
            region_block block = {
                id,       row,
                rows,     col,
                cols,     r->data + (size_t)y * (size_t)r->stride + (size_t)x * (size_t)r->channels,
                r->stride};
            bool found;
            status s = source->fetch(source->user, &block, stored, &found);
            if (s == ERR_PENDING) pending = s;
            else if (s) return s;
            else if (!found) {
                *all = false;
                if (!stored) return OK;
            }
            x += cols;
        }
        y += rows;
    }
    return pending;
}

// Tile rows of r's own width whose parents have one width.
static status fill_uniform(const region_source *source, const region *r)
{
    bool all;
    status s = fetch_blocks(source, r, false, &all);
    if (s || all) return s;
    s = region_make(source, r);
    return s ? s : fetch_blocks(source, r, true, &all);
}

// From columns half as wide: target column k lies midway between source columns 2k + 1 and 2k + 2.
static void shrink_row(const float *src, int channels, int cols, float *out)
{
    for (int k = 0; k < cols; k++)
        for (int c = 0; c < channels; c++) {
            const float *s = src + (size_t)2 * k * channels + c;
            float outer = s[0] + s[3 * channels], inner = s[channels] + s[2 * channels];
            out[k * channels + c] = (9.0f * inner - outer) * 0.0625f;
        }
}

// Beside a cliff the filter undershoots the four samples it weighs.
static void keep_floor(const float *src, bool narrow, int odd, int cols, float *out)
{
    for (int k = 0; k < cols; k++) {
        int fine = k + odd;
        const float *s = src + (narrow ? 2 * k : fine / 2 + fine % 2);
        float a = s[0] < s[1] ? s[0] : s[1], b = s[2] < s[3] ? s[2] : s[3], least = a < b ? a : b;
        out[k] = out[k] < least ? least : out[k];
    }
}

// Rows of one tile row whose width is not r's: half or double.
static status fill_resampled(const region_source *source, const region *r, int coalesce)
{
    region band = *r;
    bool narrow = coalesce < r->coalesce;
    int odd = (int)wrap(r->col, 2);
    assert(narrow ? 2 * coalesce == r->coalesce : coalesce == 2 * r->coalesce);
    band.coalesce = coalesce;
    band.col = narrow ? 2 * r->col - 1 : region_first_tap(r->col - odd);
    band.cols = narrow ? 2 * r->cols + 2 : (r->cols + odd + 1) / 2 + 4;
    status s = allocate(&band);
    if (!s) s = fill_uniform(source, &band);
    for (int y = 0; !s && y < r->rows; y++) {
        const float *in = band.data + (size_t)y * (size_t)band.stride;
        float *out = r->data + (size_t)y * (size_t)r->stride;
        if (narrow) shrink_row(in, r->channels, r->cols, out);
        else upsample_row(in, r->channels, odd, r->cols, out);
        if (source->floored) keep_floor(in, narrow, odd, r->cols, out);
    }
    free(band.data);
    return s;
}

// May tile rows a and b be made as one, in columns of r?
static bool alike(const region *r, int a, int b)
{
    int width = grid_coalesce(r->zoom, a);
    if (width != r->coalesce || width != grid_coalesce(r->zoom, b)) return false;
    return r->zoom == 0 || grid_coalesce(r->zoom - 1, a / 2) == grid_coalesce(r->zoom - 1, b / 2);
}

static status fill_band(const region_source *source, const region *r)
{
    int coalesce = grid_coalesce(r->zoom, tile_row_of(r->row));
    return coalesce == r->coalesce ? fill_uniform(source, r) : fill_resampled(source, r, coalesce);
}

// Rows that run over a pole: the circle of all rows this side of it that are needed, made once.
static status fill_over_pole(const region_source *source, const region *r)
{
    int64_t rows = (int64_t)TILE_SIZE * grid_rows(r->zoom), last = r->row + r->rows - 1;
    bool north = r->row < 0;
    int64_t nearest = north ? 0 : rows - 1; // to the pole
    int64_t beyond = north ? -r->row : last - rows + 1;
    int64_t inside = r->rows - beyond, deep = beyond > inside ? beyond : inside;
    region ring = *r;
    ring.row = north ? 0 : nearest - deep + 1;
    ring.rows = (int)deep;
    ring.col = 0;
    ring.cols = (int)circle(r);
    status s = allocate(&ring);
    if (!s) s = region_fill(source, &ring);
    size_t sample = sizeof(float) * (size_t)r->channels;
    for (int y = 0; !s && y < r->rows; y++) {
        int64_t row = r->row + y, shift = 0;
        if (row < 0 || row >= rows) {
            row = north ? -1 - row : 2 * rows - 1 - row;
            shift = ring.cols / 2;
        }
        const float *in = ring.data + (size_t)(row - ring.row) * (size_t)ring.stride;
        float *out = r->data + (size_t)y * (size_t)r->stride;
        for (int x = 0; x < r->cols; x++)
            memcpy(out + (size_t)x * (size_t)r->channels,
                   in + (size_t)wrap(r->col + shift + x, ring.cols) * (size_t)r->channels, sample);
    }
    free(ring.data);
    return s;
}

status region_fill(const region_source *source, const region *r)
{
    int64_t rows = (int64_t)TILE_SIZE * grid_rows(r->zoom), last = r->row + r->rows - 1;
    if (r->row < 0 || last >= rows) return fill_over_pole(source, r);
    int a = tile_row_of(r->row), b = tile_row_of(last);
    assert(b - a <= 1 && r->cols <= REGION_MAX_COLS);
    if (a == b) return fill_band(source, r);
    if (alike(r, a, b)) return fill_uniform(source, r);
    int north = (int)((int64_t)TILE_SIZE * b - r->row);
    region upper = rows_of(r, 0, north), lower = rows_of(r, north, r->rows - north);
    status s = fill_band(source, &upper), t;
    if (s && s != ERR_PENDING) return s;
    t = fill_band(source, &lower);
    return t ? t : s;
}
