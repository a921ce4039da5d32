// How much a zoom adds to its parent, measured on the tiles of an import.
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "planet/import_bounded.h"
#include "planet/synthesis.h"
#include "planet/upsample.h"

enum { TILES_A_ZOOM = 64, SAMPLES = TILE_SIZE * TILE_SIZE };

struct measure {
    struct planet_writer *writer;
    float *child, *parent, *around, *relief;
    double radius, residual2, relief2;
};

// The samples around a child, from its parent alone: what the parent's neighbours would give is
// NaN, and so is not measured.
static region around_child(const struct measure *m, const region *child, tile_id parent)
{
    region r = region_parent(child);
    r.data = m->around;
    int64_t north = (int64_t)TILE_SIZE * parent.row, west = (int64_t)TILE_SIZE * parent.col;
    for (int y = 0; y < r.rows; y++)
        for (int x = 0; x < r.cols; x++) {
            int64_t row = r.row + y - north, col = r.col + x - west;
            bool here = row >= 0 && row < TILE_SIZE && col >= 0 && col < TILE_SIZE;
            r.data[y * r.stride + x] = here ? m->parent[row * TILE_SIZE + col] : NAN;
        }
    return r;
}

static void measure_child(struct measure *m, const region *around, const region *child)
{
    synthesis_relief(around, m->relief);
    synthesis_temper(around, m->radius, m->relief);
    for (int row = 0; row < TILE_SIZE; row++) {
        float up[TILE_SIZE], relief[TILE_SIZE];
        bool flat[TILE_SIZE];
        upsample_child_row(around, child, row, up, flat);
        upsample_linear_row(around, m->relief, child, row, relief);
        for (int i = 0; i < TILE_SIZE; i++) {
            double residual = (double)m->child[row * TILE_SIZE + i] - (double)up[i];
            if (flat[i] || !isfinite(residual) || !isfinite(relief[i])) continue;
            m->residual2 += residual * residual;
            m->relief2 += (double)relief[i] * (double)relief[i];
        }
    }
}

static status measure_tile(struct measure *m, tile_id id)
{
    tile_id parent = tile_parent(id);
    status s = bounded_read(m->writer, parent, m->parent);
    if (s == ERR_NOT_FOUND) return OK;
    if (!s) s = bounded_read(m->writer, id, m->child);
    if (s) return s;
    region child = region_of_tile(id, 1, m->child), around = around_child(m, &child, parent);
    measure_child(m, &around, &child);
    return OK;
}

status planet_measure_gain(struct planet_writer *writer, double radius, double *gain)
{
    *gain = 0.0;
    struct measure m = {.writer = writer,
                        .radius = radius,
                        .child = NEW_ARRAY(float, SAMPLES),
                        .parent = NEW_ARRAY(float, SAMPLES),
                        .around = NEW_ARRAY(float, SAMPLES * 2),
                        .relief = NEW_ARRAY(float, SAMPLES * 2)};
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
    free(m.around);
    free(m.relief);
    if (!s && m.relief2 > 0.0)
        *gain = clamp_double(sqrt(m.residual2 / m.relief2), SYNTHESIS_GAIN_MIN, SYNTHESIS_GAIN_MAX);
    return s;
}
