// How much a zoom adds to its parent, measured on the tiles of an import.
#include <math.h>
#include <stdlib.h>

#include "base/log.h"
#include "base/memory.h"
#include "planet/synthesis.h"
#include "planet/upsample.h"

enum { TILES_A_ZOOM = 64, SAMPLES = TILE_SIZE * TILE_SIZE };

struct measure {
    struct planet_writer *writer;
    tile_id parent_id;
    float *child, *parent, *relief;
    double residual2, relief2;
};

static status read_heights(struct planet_writer *writer, tile_id id, float *heights)
{
    codec_blob body;
    status s = planet_writer_get(writer, id, &body);
    if (s) return s;
    s = codec_height_decode(body.data, body.size, heights);
    codec_blob_deinit(&body);
    if (s == ERR_FORMAT)
        log_error("tile height/%d/%d/%d: corrupt in the file being written", id.zoom, id.row,
                  id.col);
    return s;
}

// What the parent's neighbours would give is NaN, and so is not measured.
static status fetch_parent(void *user, const patch_block *b)
{
    const struct measure *m = user;
    bool here = tile_id_equal(b->tile, m->parent_id);
    for (int r = 0; r < b->rows; r++)
        for (int i = 0; i < b->cols; i++)
            b->out[(size_t)r * b->stride + i] =
                here ? m->parent[(size_t)(b->row + r) * TILE_SIZE + b->col + i] : NAN;
    return OK;
}

static void measure_patch(struct measure *m, const struct patch *p)
{
    synthesis_relief(p, m->relief);
    for (int row = 0; row < TILE_SIZE; row++) {
        float up[TILE_SIZE], relief[TILE_SIZE];
        bool flat[TILE_SIZE];
        upsample_height_row(p, row, up, flat);
        upsample_linear_row(p, m->relief, row, relief);
        for (int i = 0; i < TILE_SIZE; i++) {
            double residual = (double)m->child[row * TILE_SIZE + i] - (double)up[i];
            if (flat[i] || !isfinite(residual) || !isfinite(relief[i])) continue;
            m->residual2 += residual * residual;
            m->relief2 += (double)relief[i] * (double)relief[i];
        }
    }
}

static status measure_tile(struct measure *m, tile_id child)
{
    m->parent_id = tile_parent(child);
    status s = read_heights(m->writer, m->parent_id, m->parent);
    if (s == ERR_NOT_FOUND) return OK;
    if (!s) s = read_heights(m->writer, child, m->child);
    struct patch p;
    if (!s) s = patch_init(&p, child, 1, fetch_parent, m);
    if (s) return s;
    measure_patch(m, &p);
    patch_deinit(&p);
    return OK;
}

status planet_measure_gain(struct planet_writer *writer, double *gain)
{
    *gain = 0.0;
    struct measure m = {.writer = writer,
                        .child = NEW_ARRAY(float, SAMPLES),
                        .parent = NEW_ARRAY(float, SAMPLES),
                        .relief = NEW_ARRAY(float, PATCH_ROWS *PATCH_MAX_COLS)};
    tile_id ids[TILES_A_ZOOM];
    int zoom = planet_writer_max_zoom(writer, LAYER_HEIGHT);
    status s = OK;
    for (int k = 0; !s && k < 3 && zoom - k > 0; k++) {
        int count = 0;
        s = planet_writer_sample(writer, LAYER_HEIGHT, zoom - k, TILES_A_ZOOM, ids, &count);
        for (int i = 0; !s && i < count; i++) s = measure_tile(&m, ids[i]);
    }
    free(m.child);
    free(m.parent);
    free(m.relief);
    if (!s && m.relief2 > 0.0)
        *gain = clamp_double(sqrt(m.residual2 / m.relief2), SYNTHESIS_GAIN_MIN, SYNTHESIS_GAIN_MAX);
    return s;
}
