// The nearest stored samples, of all tiles around. Data finer by TILE_ZOOMS, which may be too small
// to have any of this zoom, count as one sample for each of their tiles.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "planet/pyramid_make.h"

enum { TILE_ZOOMS = 8 }; // a tile of a zoom finer by so many is a sample

// Tiles of one row that hold columns [west, east) of a rectangle.
static bool row_may_hold(const struct pyramid *p, const region *r, int row, int64_t west,
                         int64_t east)
{
    int cols = grid_cols(r->zoom, row);
    double across = (double)r->coalesce / grid_coalesce(r->zoom, row) / TILE_SIZE;
    int64_t first = (int64_t)floor((double)west * across),
            last = (int64_t)ceil((double)east * across) - 1;
    if (last - first >= cols) last = first + cols - 1;
    for (int64_t col = first; col <= last; col++) {
        tile_id id = {r->layer, r->zoom, row, (int)((col % cols + cols) % cols)};
        if (pyramid_may_hold(p, id)) return true;
    }
    return false;
}

bool pyramid_beside_stored(const struct pyramid *p, const region *r)
{
    if (r->zoom > p->own.max_zoom[r->layer]) return false;
    int reach = blend_reach(p->edges);
    int64_t rows = (int64_t)TILE_SIZE * grid_rows(r->zoom), north = r->row - PYRAMID_FADE_ROWS,
            south = r->row + r->rows + PYRAMID_FADE_ROWS;
    north = north < 0 ? 0 : north;
    south = south > rows ? rows : south;
    for (int64_t row = north / TILE_SIZE; row <= (south - 1) / TILE_SIZE; row++)
        if (row_may_hold(p, r, (int)row, r->col - reach, r->col + r->cols + reach)) return true;
    return false;
}

static void clear(unsigned char *mask, int i)
{
    mask[i / 8] &= (unsigned char)~(1u << (i % 8));
}

static void clear_finer(const struct pyramid *p, tile_id id, unsigned char *mask)
{
    int zoom = id.zoom + TILE_ZOOMS;
    if (zoom > p->own.max_zoom[id.layer]) return;
    for (int i = 0; i < PYRAMID_SAMPLES; i++) {
        int row = id.row * TILE_SIZE + i / TILE_SIZE;
        double across = (double)grid_cols(zoom, row) / TILE_SIZE / grid_cols(id.zoom, id.row);
        int col = (int)((id.col * TILE_SIZE + i % TILE_SIZE + 0.5) * across);
        if (pyramid_may_hold(p, (tile_id){id.layer, zoom, row, col})) clear(mask, i);
    }
}

// A blend_read: where nothing is stored.
static status read_gaps(void *user, int none, tile_id id, unsigned char *mask)
{
    struct making *m = user, own = {m->pyramid, m->want, INFINITY};
    (void)none;
    memset(mask, 0xff, BLEND_MASK_BYTES);
    if (!pyramid_may_hold(m->pyramid, id)) return OK;
    float *heights = malloc(sizeof *heights * PYRAMID_SAMPLES);
    if (!heights) return ERR_MEMORY;
    bool found;
    status s = pyramid_read_stored(&own, id, heights, &found);
    for (int i = 0; !s && found && i < PYRAMID_SAMPLES; i++)
        if (!isnan(heights[i])) clear(mask, i);
    free(heights);
    if (!s && found) clear_finer(m->pyramid, id, mask);
    m->until_s = fmin(m->until_s, own.until_s);
    return s ? s : own.until_s < (double)INFINITY ? ERR_IO : OK;
}

status pyramid_fade(struct making *m, const region *r, float *share)
{
    struct blend_room room = {0};
    status s = blend_region(m->pyramid->edges, r, 0, read_gaps, m, &room, share);
    blend_room_deinit(&room);
    return s;
}
