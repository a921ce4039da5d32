#include "planet/import_blend.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/vec.h"

enum { MASK = BLEND_MASK_BYTES, MAX_MASKS = 96 };

struct slot {
    int mosaic;
    tile_id id;
    unsigned char *mask;
};

// Kept masks: a slot for each value of a hash, the newer one stays.
struct blend {
    int feather, slot_count;
    pthread_mutex_t lock;
    struct slot *slots;
};

// A rectangle of samples of the mosaic's own zoom: rows from row0, unwrapped columns of the width
// in tile row `tile_row`.
struct canvas {
    enum tile_layer layer;
    int zoom, tile_row, rows, cols;
    int64_t row0, col0;
    float least_width; // of a column, in rows
};

struct blend *blend_create(int feather, int masks)
{
    struct blend *b = NEW(struct blend);
    b->feather = feather;
    b->slot_count = masks;
    b->slots = NEW_ARRAY(struct slot, (size_t)masks);
    pthread_mutex_init(&b->lock, NULL);
    return b;
}

void blend_destroy(struct blend **blend)
{
    if (!*blend) return;
    for (int i = 0; i < (*blend)->slot_count; i++) free((*blend)->slots[i].mask);
    free((*blend)->slots);
    pthread_mutex_destroy(&(*blend)->lock);
    free(*blend);
    *blend = NULL;
}

void blend_room_deinit(struct blend_room *room)
{
    free(room->masks);
    free(room->valid);
    free(room->square);
    free(room->distance);
    *room = (struct blend_room){0};
}

static void *reserve(void **room, size_t *size, size_t need)
{
    if (need > *size) {
        free(*room);
        *room = calloc(need, 1);
        *size = *room ? need : 0;
    }
    return *room;
}

static bool reserve_all(struct blend_room *r, const struct canvas *c)
{
    size_t count = (size_t)c->rows * (size_t)c->cols;
    return reserve((void **)&r->masks, &r->masks_size, (size_t)MAX_MASKS * MASK) &&
           reserve((void **)&r->valid, &r->valid_size, count) &&
           reserve((void **)&r->square, &r->square_size, count * sizeof(float)) &&
           reserve((void **)&r->distance, &r->distance_size, count * sizeof(float));
}

static struct slot *slot_of(struct blend *b, int mosaic, tile_id id)
{
    uint64_t h = 0xcbf29ce484222325u;
    int parts[] = {mosaic, id.zoom, id.row, id.col};
    for (int i = 0; i < 4; i++) h = (h ^ (uint64_t)parts[i]) * 0x100000001b3u;
    return &b->slots[(h ^ h >> 32) % (uint64_t)b->slot_count];
}

static status get_mask(struct blend *b, int mosaic, tile_id id, blend_read read, void *user,
                       unsigned char *mask)
{
    struct slot *slot = slot_of(b, mosaic, id);
    pthread_mutex_lock(&b->lock);
    bool kept = slot->mask && slot->mosaic == mosaic && tile_id_equal(slot->id, id);
    if (kept) memcpy(mask, slot->mask, MASK);
    pthread_mutex_unlock(&b->lock);
    if (kept) return OK;
    memset(mask, 0, MASK);
    status s = read(user, mosaic, id, mask);
    if (s) return s == ERR_IO ? OK : s;
    pthread_mutex_lock(&b->lock);
    if (!slot->mask) slot->mask = NEW_ARRAY(unsigned char, MASK);
    slot->mosaic = mosaic;
    slot->id = id;
    memcpy(slot->mask, mask, MASK);
    pthread_mutex_unlock(&b->lock);
    return OK;
}

// Centre of sample 0 of the tile in own samples, and own samples in a step, of rows and of columns.
struct lattice {
    double u0, du, v0, dv;
};

static struct lattice lattice_of(int own, tile_id id)
{
    int up = id.zoom - own;
    double ratio = ldexp(1, -up);
    double across = (double)grid_coalesce(id.zoom, id.row) / grid_coalesce(own, id.row >> up);
    struct lattice l = {.du = ratio * across, .dv = ratio};
    l.u0 = ((double)id.col * TILE_SIZE + 0.5) * l.du - 0.5;
    l.v0 = ((double)id.row * TILE_SIZE + 0.5) * l.dv - 0.5;
    return l;
}

// Samples are no narrower than half their height but in the row at the pole.
static int columns_of(int feather)
{
    return 2 * feather + 2;
}

int blend_reach(const struct blend *b)
{
    return columns_of(b->feather);
}

static struct canvas plan_canvas(int own, tile_id id, int feather)
{
    struct lattice l = lattice_of(own, id);
    int reach = columns_of(feather);
    struct canvas c = {.layer = id.layer, .zoom = own, .tile_row = id.row >> (id.zoom - own)};
    c.row0 = (int64_t)floor(l.v0) - feather;
    c.rows = (int)((int64_t)floor(l.v0 + l.dv * (TILE_SIZE - 1)) + 1 + feather - c.row0 + 1);
    c.col0 = (int64_t)floor(l.u0) - reach;
    c.cols = (int)((int64_t)floor(l.u0 + l.du * (TILE_SIZE - 1)) + 1 + reach - c.col0 + 1);
    return c;
}

// One row of the canvas that stands in a tile row of the grid: where there is data.
struct mask_list {
    struct blend *blend;
    struct blend_room *room;
    blend_read read;
    void *user;
    int mosaic, count;
    tile_id ids[MAX_MASKS];
};

static status find_mask(struct mask_list *m, tile_id id, const unsigned char **mask)
{
    for (int i = m->count - 1; i >= 0; i--)
        if (tile_id_equal(m->ids[i], id)) {
            *mask = m->room->masks + (size_t)i * MASK;
            return OK;
        }
    if (m->count == MAX_MASKS) m->count = 0;
    unsigned char *room = m->room->masks + (size_t)m->count * MASK;
    *mask = room;
    status s = get_mask(m->blend, m->mosaic, id, m->read, m->user, room);
    if (!s) m->ids[m->count++] = id;
    return s;
}

static status fill_row(struct mask_list *m, const struct canvas *c, int y, unsigned char *valid)
{
    int64_t line = c->row0 + y;
    memset(valid, 1, (size_t)c->cols);
    if (line < 0 || line >= (int64_t)grid_rows(c->zoom) * TILE_SIZE) return OK; // beyond a pole
    tile_id id = {c->layer, c->zoom, (int)(line / TILE_SIZE), -1};
    int64_t period = (int64_t)grid_cols(c->zoom, c->tile_row) * TILE_SIZE;
    double across = (double)grid_coalesce(c->zoom, c->tile_row) / grid_coalesce(c->zoom, id.row);
    const unsigned char *mask = NULL;
    for (int x = 0; x < c->cols; x++) {
        int64_t column = ((c->col0 + x) % period + period) % period;
        int64_t there = (int64_t)(((double)column + 0.5) * across);
        if ((int)(there / TILE_SIZE) != id.col) {
            id.col = (int)(there / TILE_SIZE);
            status s = find_mask(m, id, &mask);
            if (s) return s;
        }
        int bit = (int)(line % TILE_SIZE) * TILE_SIZE + (int)(there % TILE_SIZE);
        valid[x] = mask[bit / 8] >> (bit % 8) & 1;
    }
    return OK;
}

// Squares of the distances along each row to the nearest sample without data, in rows, at most
// `most`.
static void square_row(const struct canvas *c, int y, const unsigned char *valid, float most,
                       float *square)
{
    double lat = M_PI / 2 - ((double)(c->row0 + y) + 0.5) * grid_step_lat(c->zoom);
    float width = (float)(grid_coalesce(c->zoom, c->tile_row) * fabs(cos(lat)));
    width = fmaxf(width, c->least_width);
    float d = most;
    for (int x = 0; x < c->cols; x++) {
        d = valid[x] ? fminf(most, d + width) : 0;
        square[x] = d * d;
    }
    d = most;
    for (int x = c->cols - 1; x >= 0; x--) {
        d = valid[x] ? fminf(most, d + width) : 0;
        square[x] = fminf(square[x], d * d);
    }
}

static void measure(const struct canvas *c, int feather, const float *square, float *distance)
{
    for (int y = feather; y < c->rows - feather; y++) {
        float *to = distance + (size_t)y * (size_t)c->cols;
        for (int x = 0; x < c->cols; x++) to[x] = INFINITY;
        for (int dy = -feather; dy <= feather; dy++) {
            const float *from = square + (size_t)(y + dy) * (size_t)c->cols;
            float add = (float)(dy * dy);
            for (int x = 0; x < c->cols; x++) {
                float v = from[x] + add;
                to[x] = v < to[x] ? v : to[x];
            }
        }
        for (int x = 0; x < c->cols; x++) to[x] = sqrtf(to[x]);
    }
}

static float weight_of(float distance, float feather)
{
    float t = (distance - 0.5f) / feather;
    t = t < 0 ? 0 : t > 1 ? 1 : t;
    return t * t * (3 - 2 * t);
}

static void read_weights(const struct canvas *c, int own, tile_id id, int feather,
                         const float *distance, float *weights)
{
    struct lattice l = lattice_of(own, id);
    for (int y = 0; y < TILE_SIZE; y++) {
        double v = l.v0 + l.dv * y - (double)c->row0;
        const float *row = distance + (size_t)v * (size_t)c->cols;
        float t = (float)(v - floor(v));
        for (int x = 0; x < TILE_SIZE; x++) {
            double u = l.u0 + l.du * x - (double)c->col0;
            const float *d = row + (int)u;
            float s = (float)(u - floor(u));
            float near = d[0] + s * (d[1] - d[0]);
            float far = d[c->cols] + s * (d[c->cols + 1] - d[c->cols]);
            float w = weight_of(near + t * (far - near), (float)feather);
            weights[y * TILE_SIZE + x] = fmaxf(w, BLEND_LEAST_WEIGHT);
        }
    }
}

// Distances over a canvas in room->distance; *any: there are samples without data.
static status measure_canvas(struct blend *b, int mosaic, const struct canvas *c, blend_read read,
                             void *user, struct blend_room *room, bool *any)
{
    *any = false;
    if (!reserve_all(room, c)) return ERR_MEMORY;
    struct mask_list *m = NEW(struct mask_list);
    *m = (struct mask_list){.blend = b, .room = room, .read = read, .user = user, .mosaic = mosaic};
    status s = OK;
    for (int y = 0; !s && y < c->rows; y++)
        s = fill_row(m, c, y, room->valid + (size_t)y * (size_t)c->cols);
    free(m);
    *any = !s && memchr(room->valid, 0, (size_t)c->rows * (size_t)c->cols);
    for (int y = 0; *any && y < c->rows; y++) {
        size_t at = (size_t)y * (size_t)c->cols;
        square_row(c, y, room->valid + at, (float)b->feather + 1, room->square + at);
    }
    if (*any) measure(c, b->feather, room->square, room->distance);
    return s;
}

status blend_weights(struct blend *b, int mosaic, int own, tile_id id, blend_read read, void *user,
                     struct blend_room *room, float *weights)
{
    struct canvas c = plan_canvas(own, id, b->feather);
    bool any;
    status s = measure_canvas(b, mosaic, &c, read, user, room, &any);
    if (s) return s;
    for (int i = 0; !any && i < TILE_SIZE * TILE_SIZE; i++) weights[i] = 1;
    if (any) read_weights(&c, own, id, b->feather, room->distance, weights);
    return OK;
}

status blend_region(struct blend *b, const region *r, float margin, blend_read read, void *user,
                    struct blend_room *room, float *weights)
{
    float width = (float)b->feather - margin;
    int reach = columns_of(b->feather);
    struct canvas c = {.layer = r->layer,
                       .zoom = r->zoom,
                       .tile_row = (int)(r->row / TILE_SIZE),
                       .rows = r->rows + 2 * b->feather,
                       .cols = r->cols + 2 * reach,
                       .row0 = r->row - b->feather,
                       .col0 = r->col - reach,
                       .least_width = 0.5f};
    bool any;
    status s = measure_canvas(b, 0, &c, read, user, room, &any);
    for (int y = 0; !s && y < r->rows; y++) {
        const float *from = room->distance + (size_t)(y + b->feather) * (size_t)c.cols + reach;
        for (int x = 0; x < r->cols; x++)
            weights[y * r->cols + x] = any ? weight_of(from[x] - margin, width) : 1;
    }
    return s;
}
