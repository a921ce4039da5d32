// The tile grid's arithmetic. Everything follows from grid_coalesce.
#include "planet/grid.h"

#include <assert.h>
#include <math.h>

#include "base/vec.h"

const char *tile_layer_name(enum tile_layer layer)
{
    static const char *const names[LAYER_COUNT] = {"height", "color", "night"};
    assert((unsigned)layer < LAYER_COUNT);
    return names[layer];
}

bool tile_id_equal(tile_id a, tile_id b)
{
    return a.layer == b.layer && a.zoom == b.zoom && a.row == b.row && a.col == b.col;
}

tile_id tile_parent(tile_id id)
{
    assert(id.zoom > 0);
    tile_id parent = {id.layer, id.zoom - 1, id.row / 2, 0};
    int64_t west = (int64_t)id.col * grid_coalesce(id.zoom, id.row); // in equator-width tiles
    parent.col = (int)(west / (2 * grid_coalesce(parent.zoom, parent.row)));
    return parent;
}

int grid_rows(int zoom)
{
    assert(zoom >= 0 && zoom <= GRID_MAX_ZOOM);
    return 1 << zoom;
}

int grid_coalesce(int zoom, int row)
{
    int rows = grid_rows(zoom);
    assert(row >= 0 && row < rows);
    if (zoom == 0) return 1;
    // Rows from the equator to the row's nearer edge, of rows / 2 to the pole.
    int half = rows / 2;
    int edge = row < half ? half - 1 - row : row - half;
    // cos(latitude) is never a power of two on an edge but the equator (Niven), so rounding cannot
    // move a row over a step.
    int coalesce = 1 << ilogb(1.0 / cos(M_PI / 2.0 * edge / half));
    return coalesce <= 2 * rows ? coalesce : 2 * rows;
}

int grid_cols(int zoom, int row)
{
    return (2 << zoom) / grid_coalesce(zoom, row);
}

double grid_step_lat(int zoom)
{
    assert(zoom >= 0 && zoom <= GRID_MAX_ZOOM);
    return ldexp(M_PI / TILE_SIZE, -zoom);
}

double grid_step_lon(int zoom, int row)
{
    return grid_step_lat(zoom) * grid_coalesce(zoom, row);
}

double grid_lat(int zoom, int64_t sample_row)
{
    // Counted from the equator, so that north and south mirror exactly.
    double from_equator = ldexp(TILE_SIZE / 2, zoom) - 0.5 - (double)sample_row;
    return from_equator * grid_step_lat(zoom);
}

void grid_bounds(tile_id id, double *west, double *south, double *east, double *north)
{
    double lat = TILE_SIZE * grid_step_lat(id.zoom);
    double lon = TILE_SIZE * grid_step_lon(id.zoom, id.row);
    int half_cols = grid_cols(id.zoom, id.row) / 2;
    double half_rows = 0.5 * grid_rows(id.zoom);
    *west = (id.col - half_cols) * lon;
    *east = (id.col + 1 - half_cols) * lon;
    *north = (half_rows - id.row) * lat;
    *south = (half_rows - id.row - 1) * lat;
}
