#include "fake_pyramid.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <unistd.h>

enum { BODIES = 13, SAMPLES = TILE_SIZE * TILE_SIZE };

struct pyramid {
    atomic_int refuse, microseconds, asked, held;
};

static float heights[BODIES][SAMPLES];
static uint8_t colors[BODIES][4 * SAMPLES];
static pthread_once_t bodies_once = PTHREAD_ONCE_INIT;

static uint64_t mix(uint64_t x)
{
    x += 0x9E3779B97F4A7C15u;
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
    return x ^ (x >> 31);
}

static void make_bodies(void)
{
    for (int b = 0; b < BODIES; b++)
        for (int i = 0; i < SAMPLES; i++) {
            uint64_t r = mix((uint64_t)b << 32 | (uint64_t)i);
            // Each body has a level of its own, so that bounds differ from place to place.
            heights[b][i] = (float)(r % 512 + (uint64_t)b * 256);
            for (int c = 0; c < 4; c++) colors[b][4 * i + c] = (uint8_t)(r >> (16 + 8 * c));
        }
}

static int body_of(int zoom, int64_t row, int64_t col)
{
    static _Thread_local uint64_t last_key = UINT64_MAX;
    static _Thread_local int last_body;
    uint64_t key = (uint64_t)zoom << 58 ^ (uint64_t)row << 29 ^ (uint64_t)col;
    if (key == last_key) return last_body;
    pthread_once(&bodies_once, make_bodies);
    last_key = key;
    return last_body = (int)(mix(key) % BODIES);
}

static int place(int64_t row, int64_t index)
{
    return (int)(row % TILE_SIZE) * TILE_SIZE + (int)(index % TILE_SIZE);
}

float fake_height(int zoom, int64_t row, int64_t index)
{
    return heights[body_of(zoom, row / TILE_SIZE, index / TILE_SIZE)][place(row, index)];
}

void fake_color(int zoom, int64_t row, int64_t index, uint8_t rgba[4])
{
    int body = body_of(zoom, row / TILE_SIZE, index / TILE_SIZE);
    for (int c = 0; c < 4; c++) rgba[c] = colors[body][4 * place(row, index) + c];
}

struct pyramid *fake_pyramid_create(void)
{
    return calloc(1, sizeof(struct pyramid));
}

void fake_pyramid_destroy(struct pyramid **pyramid)
{
    free(*pyramid);
    *pyramid = NULL;
}

void fake_pyramid_refuse(struct pyramid *p, int count)
{
    p->refuse = count;
}

void fake_pyramid_slow(struct pyramid *p, int microseconds)
{
    p->microseconds = microseconds;
}

int fake_pyramid_asked(struct pyramid *p)
{
    return p->asked;
}

int fake_pyramid_held(struct pyramid *p)
{
    return p->held;
}

status pyramid_acquire(struct pyramid *p, tile_id id, const pyramid_tile **out)
{
    *out = NULL;
    p->asked++;
    if (p->microseconds) usleep((useconds_t)p->microseconds);
    if (p->refuse > 0 && p->refuse-- > 0) return ERR_MEMORY;
    if (id.zoom < 0 || id.zoom > GRID_MAX_ZOOM || id.row < 0 || id.row >= grid_rows(id.zoom) ||
        id.col < 0 || id.col >= grid_cols(id.zoom, id.row))
        abort();
    pyramid_tile *t = malloc(sizeof *t);
    int body = body_of(id.zoom, id.row, id.col);
    *t = (pyramid_tile){.id = id};
    if (id.layer == LAYER_HEIGHT) t->heights = heights[body];
    else t->rgba = colors[body];
    p->held++;
    *out = t;
    return OK;
}

void pyramid_release(struct pyramid *p, const pyramid_tile **tile)
{
    p->held--;
    free((void *)*tile);
    *tile = NULL;
}
