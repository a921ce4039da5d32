// Where heights are, sample by sample: a coarse tile of a region's data is stored for its whole
// place, and says by its gaps where the region ends.
#include "planet/pyramid.h"

#include <math.h>
#include <stdlib.h>

#include "base/vec.h"
#include "planet/pyramid_make.h"

// The tile read last, of one source.
struct held {
    const struct source *source;
    tile_id id;
    bool found;
    float *heights;
};

static status hold(struct held *h, struct source *source, tile_id id)
{
    const double again_s = 0.1;
    double until_s;
    if (h->source == source && tile_id_equal(h->id, id)) return OK;
    struct want *want = want_create(-1);
    status s;
    while ((s = source_read(source, id, want, h->heights, &until_s)) == ERR_PENDING)
        want_wait(want, again_s);
    want_release(&want);
    h->source = source;
    h->id = id;
    h->found = s == OK;
    return s == ERR_MEMORY ? s : OK;
}

// The tile and sample nearest to a place.
static tile_id tile_of(int zoom, double lat, double lon, int *sample)
{
    int64_t rows = (int64_t)TILE_SIZE * grid_rows(zoom);
    double turn = lon / (2 * M_PI) + 0.5;
    int64_t line =
        (int64_t)clamp_double((M_PI / 2 - lat) / grid_step_lat(zoom), 0, (double)rows - 1);
    int row = (int)(line / TILE_SIZE);
    int64_t width = (int64_t)TILE_SIZE * grid_cols(zoom, row);
    int64_t col = (int64_t)((turn - floor(turn)) * (double)width) % width;
    *sample = (int)(line % TILE_SIZE * TILE_SIZE + col % TILE_SIZE);
    return (tile_id){LAYER_HEIGHT, zoom, row, (int)(col / TILE_SIZE)};
}

static status layer_knows(const struct pyramid *p, struct held *h, double lat, double lon,
                          bool *known)
{
    *known = false;
    for (int zoom = p->own.max_zoom[LAYER_HEIGHT]; zoom >= 0 && !*known; zoom--) {
        int sample;
        tile_id id = tile_of(zoom, lat, lon, &sample);
        if (!source_has(p->source, id)) continue;
        status s = hold(h, p->source, id);
        if (s) return s;
        *known = h->found && !isnan(h->heights[sample]);
        if (h->found && p->source->gaps_final) break;
    }
    return OK;
}

status pyramid_knows_any(struct pyramid *p, const double *lat_deg, const double *lon_deg,
                         size_t count, bool *known)
{
    struct held h = {.heights = malloc(PYRAMID_SAMPLES * sizeof *h.heights)};
    status s = h.heights ? OK : ERR_MEMORY;
    *known = false;
    for (int k = -1; k < p->over_count && !s && !*known; k++) {
        const struct pyramid *layer = k < 0 ? p : p->overs[k];
        for (size_t i = 0; i < count && !s && !*known; i++)
            if (isfinite(lat_deg[i]) && isfinite(lon_deg[i]))
                s = layer_knows(layer, &h, lat_deg[i] * (M_PI / 180), lon_deg[i] * (M_PI / 180),
                                known);
    }
    free(h.heights);
    return s;
}
