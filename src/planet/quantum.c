#include "planet/quantum.h"

#include <math.h>

#include "planet/codec_grid.h"

enum { AUTO_SHARE = 2048, AUTO_MIN = -6, AUTO_MAX = 0 };

static int floor_log2(double v)
{
    int exponent;
    frexp(v, &exponent);
    return exponent - 1;
}

bool quantum_is_good(double quantum)
{
    if (quantum == 0 || quantum == QUANTUM_AUTO) return true;
    return quantum >= ldexp(1, GRID_EXPONENT_MIN) && quantum < ldexp(1, GRID_EXPONENT_MAX + 1);
}

int quantum_exponent(double quantum, int zoom, double radius)
{
    if (quantum > 0) return floor_log2(quantum);
    int exponent = floor_log2(radius * grid_step_lat(zoom) / AUTO_SHARE);
    return exponent < AUTO_MIN ? AUTO_MIN : exponent > AUTO_MAX ? AUTO_MAX : exponent;
}

int quantum_tile_exponent(double quantum, tile_id id, double radius)
{
    bool polar = id.row == 0 || id.row == grid_rows(id.zoom) - 1;
    return quantum == QUANTUM_AUTO && polar ? AUTO_MIN : quantum_exponent(quantum, id.zoom, radius);
}
