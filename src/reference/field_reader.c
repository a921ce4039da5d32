// Reading single samples: a reader holds the few tiles it used last.
#include "reference/field.h"

#include <math.h>

#include "base/vec.h"

void field_reader_init(struct field_reader *reader, const struct field *field,
                       struct pyramid *pyramid)
{
    *reader = (struct field_reader){.field = field, .pyramid = pyramid};
}

void field_reader_deinit(struct field_reader *reader)
{
    for (int i = 0; i < FIELD_SLOTS; i++) {
        if (reader->heights[i]) pyramid_release(reader->pyramid, &reader->heights[i]);
        if (reader->colors[i]) pyramid_release(reader->pyramid, &reader->colors[i]);
    }
}

// The tile, or NULL once anything has failed. Neighbours in 4 x 4 tiles never share a slot.
static const pyramid_tile *reader_tile(struct field_reader *reader, tile_id id)
{
    const pyramid_tile **slot = id.layer == LAYER_HEIGHT ? reader->heights : reader->colors;
    slot += (id.row & 3) * 4 + (id.col & 3);
    if (*slot && tile_id_equal((*slot)->id, id)) return *slot;
    if (*slot) pyramid_release(reader->pyramid, slot);
    *slot = NULL;
    if (!reader->error) reader->error = pyramid_acquire(reader->pyramid, id, slot);
    return reader->error ? NULL : *slot;
}

// One sample row, linear between two of its samples.
struct piece {
    int zoom, row;
    int64_t width, west, east; // sample columns in [0, width)
    double lon0, lon1;         // longitudes of the two samples
};

// The piece of a row about a longitude; a row beyond a pole is the row as far before it on the
// opposite meridian.
static struct piece find_piece(int zoom, int64_t row, double lon)
{
    int64_t rows = (int64_t)grid_rows(zoom) * TILE_SIZE;
    double turn = 0;
    if (row < 0 || row >= rows) {
        row = row < 0 ? -1 - row : 2 * rows - 1 - row;
        turn = 180;
    }
    struct piece p = {.zoom = zoom, .row = (int)row};
    p.width = (int64_t)grid_cols(zoom, (int)(row / TILE_SIZE)) * TILE_SIZE;
    double width = (double)p.width, k = floor(((lon + turn) / 360 + 0.5) * width - 0.5);
    p.lon0 = ((k + 0.5) / width - 0.5) * 360 - turn;
    p.lon1 = ((k + 1.5) / width - 0.5) * 360 - turn;
    p.west = (int64_t)k % p.width;
    if (p.west < 0) p.west += p.width;
    p.east = p.west + 1 == p.width ? 0 : p.west + 1;
    return p;
}

static double sample(struct field_reader *reader, const struct piece *p, int64_t column)
{
    column = column < 0 ? column + p->width : column < p->width ? column : column - p->width;
    tile_id id = {LAYER_HEIGHT, p->zoom, p->row / TILE_SIZE, (int)(column / TILE_SIZE)};
    const pyramid_tile *tile = reader_tile(reader, id);
    return tile ? tile->heights[p->row % TILE_SIZE * TILE_SIZE + column % TILE_SIZE] : 0.0;
}

static patch_row row_of_piece(struct field_reader *reader, const struct piece *p, int order)
{
    int before = order / 2 - 1;
    patch_row row = {.step = p->lon1 - p->lon0};
    row.lon = p->lon0 - before * row.step;
    for (int i = 0; i < order; i++) row.sample[i] = sample(reader, p, p->west - before + i);
    return row;
}

// Rows of different widths meet: the patch is as wide as all of them allow.
field_patch field_patch_at(struct field_reader *reader, double lat, double lon)
{
    int zoom = field_zoom(reader->field), order = field_order(reader->field);
    double step = grid_step_lat(zoom) * (180 / M_PI);
    double y = floor((90 - lat) / step - 0.5);
    field_box box = {90 - (y + 1.5) * step, 90 - (y + 0.5) * step, -INFINITY, INFINITY};
    patch_row rows[PATCH_MAX];
    for (int i = 0; i < order; i++) {
        struct piece p = find_piece(zoom, (int64_t)y + i - (order / 2 - 1), lon);
        rows[i] = row_of_piece(reader, &p, order);
        box.west = fmax(box.west, p.lon0);
        box.east = fmin(box.east, p.lon1);
    }
    return patch_make(&box, order, rows);
}

double field_height(struct field_reader *reader, double lat, double lon)
{
    field_patch p = field_patch_at(reader, lat, lon);
    return patch_height(&p, lat, lon);
}

void field_gradient(struct field_reader *reader, double lat, double lon, double *per_lat,
                    double *per_lon)
{
    field_patch p = field_patch_at(reader, lat, lon);
    patch_gradient(&p, lat, lon, per_lat, per_lon);
}

static double linear_of_srgb(double c)
{
    return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
}

static void add_texel(struct field_reader *reader, const struct piece *p, int64_t column,
                      double weight, double rgba[4])
{
    tile_id id = {LAYER_COLOR, p->zoom, p->row / TILE_SIZE, (int)(column / TILE_SIZE)};
    const pyramid_tile *tile = reader_tile(reader, id);
    if (!tile) return;
    const uint8_t *t = tile->rgba + 4 * (p->row % TILE_SIZE * TILE_SIZE + column % TILE_SIZE);
    for (int i = 0; i < 3; i++) rgba[i] += weight * linear_of_srgb(t[i] / 255.0);
    rgba[3] += weight * t[3] / 255.0;
}

static void add_color(struct field_reader *reader, int zoom, double lat, double lon, double weight,
                      double rgba[4])
{
    double y = (90 - lat) / (grid_step_lat(zoom) * (180 / M_PI)) - 0.5, row = floor(y);
    for (int i = 0; i < 2; i++) {
        struct piece p = find_piece(zoom, (int64_t)row + i, lon);
        double w = weight * (i ? y - row : 1 - (y - row));
        double x = (lon - p.lon0) / (p.lon1 - p.lon0);
        add_texel(reader, &p, p.west, w * (1 - x), rgba);
        add_texel(reader, &p, p.east, w * x, rgba);
    }
}

void field_color(struct field_reader *reader, double zoom, double lat, double lon, double rgba[4])
{
    const struct planet_meta *m = pyramid_meta(reader->pyramid);
    int finest = m->max_zoom[LAYER_COLOR];
    if (m->max_zoom[LAYER_NIGHT] > finest) finest = m->max_zoom[LAYER_NIGHT];
    for (int i = 0; i < 4; i++) rgba[i] = 0;
    zoom = clamp_double(zoom, 0, finest < 0 ? 0 : finest); // without imagery: bare ground
    double whole = floor(zoom), share = zoom - whole;
    add_color(reader, (int)whole, lat, lon, 1 - share, rgba);
    if (share > 0) add_color(reader, (int)whole + 1, lat, lon, share, rgba);
}
