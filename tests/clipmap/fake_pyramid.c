#include "fake_pyramid.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <unistd.h>

enum { BODIES = 13, SAMPLES = TILE_SIZE * TILE_SIZE, LATE_MAX = 1 << 14 };

// A tile that was asked for before it was delivered, by one want; several may ask for one tile.
struct late {
    tile_id id;
    struct want *want; // NULL: delivered, or given up
    bool given_up;
    bool flying; // by fake_pyramid_tick
    int age;     // ticks in flight
};

struct pyramid {
    atomic_int refuse, microseconds, asked, held, stand_in;
    bool is_late;
    pthread_mutex_t lock;
    struct late late[LATE_MAX];
    int late_count;
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
    struct pyramid *p = calloc(1, sizeof *p);
    pthread_mutex_init(&p->lock, NULL);
    return p;
}

void fake_pyramid_destroy(struct pyramid **pyramid)
{
    for (int i = 0; i < (*pyramid)->late_count; i++)
        if ((*pyramid)->late[i].want) want_give_back(&(*pyramid)->late[i].want);
    pthread_mutex_destroy(&(*pyramid)->lock);
    free(*pyramid);
    *pyramid = NULL;
}

void fake_pyramid_refuse(struct pyramid *p, int count)
{
    p->refuse = count;
}

void fake_pyramid_stand_in(struct pyramid *p, bool stand_in)
{
    p->stand_in = stand_in;
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
    bool stand_in = p->stand_in;
    int body = (body_of(id.zoom, id.row, id.col) + stand_in) % BODIES;
    *t = (pyramid_tile){.id = id, .until_s = stand_in ? 0 : INFINITY};
    if (id.layer == LAYER_HEIGHT) t->heights = heights[body];
    else t->rgba = colors[body];
    p->held++;
    *out = t;
    return OK;
}

// Else notes who waits for it.
static bool was_delivered(struct pyramid *p, tile_id id, struct want *want)
{
    bool delivered = false;
    pthread_mutex_lock(&p->lock);
    for (int i = 0; i < p->late_count && !delivered; i++)
        delivered = tile_id_equal(p->late[i].id, id) && !p->late[i].want && !p->late[i].given_up;
    for (int i = 0; i < p->late_count && !delivered; i++)
        if (p->late[i].want == want && tile_id_equal(p->late[i].id, id)) {
            pthread_mutex_unlock(&p->lock);
            return false;
        }
    if (!delivered) {
        if (p->late_count == LATE_MAX) abort();
        p->late[p->late_count] = (struct late){.id = id, .want = want_take(want)};
        for (int i = 0; i < p->late_count; i++) // in flight already, for somebody else
            if (p->late[i].want && p->late[i].flying && tile_id_equal(p->late[i].id, id)) {
                p->late[p->late_count].flying = true;
                p->late[p->late_count].age = p->late[i].age;
            }
        p->late_count++;
    }
    pthread_mutex_unlock(&p->lock);
    return delivered;
}

status pyramid_try(struct pyramid *p, tile_id id, struct want *want, const pyramid_tile **out)
{
    *out = NULL;
    return p->is_late && !was_delivered(p, id, want) ? ERR_PENDING : pyramid_acquire(p, id, out);
}

void fake_pyramid_late(struct pyramid *p)
{
    p->is_late = true;
}

int fake_pyramid_deliver(struct pyramid *p, int count)
{
    int given = 0;
    pthread_mutex_lock(&p->lock);
    while (given < count) {
        struct late *best = NULL;
        for (int i = 0; i < p->late_count; i++) {
            struct late *l = &p->late[i];
            if (!l->want || want_cancelled(l->want)) continue;
            if (!best || want_priority(l->want) < want_priority(best->want)) best = l;
        }
        if (!best) break;
        tile_id id = best->id;
        for (int i = 0; i < p->late_count; i++)
            if (p->late[i].want && tile_id_equal(p->late[i].id, id))
                want_give_back(&p->late[i].want);
        given++;
    }
    pthread_mutex_unlock(&p->lock);
    return given;
}

static bool wanted(const struct pyramid *p, tile_id id)
{
    for (int i = 0; i < p->late_count; i++)
        if (p->late[i].want && tile_id_equal(p->late[i].id, id) && !want_cancelled(p->late[i].want))
            return true;
    return false;
}

// All who asked for the tile get an answer; `came`: the tile.
static void answer(struct pyramid *p, tile_id id, bool came)
{
    for (int i = 0; i < p->late_count; i++) {
        struct late *l = &p->late[i];
        if (!l->want || !tile_id_equal(l->id, id)) continue;
        want_give_back(&l->want);
        l->given_up = !came;
        l->flying = false;
    }
}

static void set_off(struct pyramid *p, tile_id id)
{
    for (int i = 0; i < p->late_count; i++)
        if (p->late[i].want && tile_id_equal(p->late[i].id, id)) p->late[i].flying = true;
}

// The one to be fetched next: the most wanted, or the first that was asked for.
static const struct late *next_in_line(const struct pyramid *p, bool first_come)
{
    const struct late *best = NULL;
    for (int i = 0; i < p->late_count; i++) {
        const struct late *l = &p->late[i];
        if (!l->want || l->flying) continue;
        if (!first_come && want_cancelled(l->want)) continue;
        if (!best || (!first_come && want_priority(l->want) < want_priority(best->want))) best = l;
    }
    return best;
}

// Distinct tiles in flight, into `ids` where it has room.
static int flying(const struct pyramid *p, tile_id *ids, int room)
{
    int count = 0;
    for (int i = 0; i < p->late_count; i++) {
        bool again = !p->late[i].want || !p->late[i].flying;
        for (int k = 0; k < i && !again; k++)
            again =
                p->late[k].want && p->late[k].flying && tile_id_equal(p->late[k].id, p->late[i].id);
        if (again) continue;
        if (count < room) ids[count] = p->late[i].id;
        count++;
    }
    return count;
}

// Answered entries are only kept for the tiles that came, once each.
static void forget(struct pyramid *p)
{
    int kept = 0;
    for (int i = 0; i < p->late_count; i++)
        if (p->late[i].want || !p->late[i].given_up) p->late[kept++] = p->late[i];
    p->late_count = kept;
}

void fake_pyramid_tick(struct pyramid *p, const struct fake_line *line, struct fake_traffic *t)
{
    pthread_mutex_lock(&p->lock);
    for (int i = 0; i < p->late_count; i++) {
        struct late *l = &p->late[i];
        if (!l->want || !l->flying || ++l->age < line->ticks) continue;
        t->came++;
        t->in_vain += !wanted(p, l->id);
        answer(p, l->id, true);
    }
    for (int i = 0; i < p->late_count && !line->first_come; i++) {
        tile_id id = p->late[i].id;
        if (!p->late[i].want || wanted(p, id)) continue;
        t->stopped += p->late[i].flying;
        answer(p, id, false);
    }
    const struct late *next;
    t->flying_count = flying(p, t->flying, FAKE_FLYING);
    while (t->flying_count < line->slots && (next = next_in_line(p, line->first_come))) {
        set_off(p, next->id);
        t->flying_count = flying(p, t->flying, FAKE_FLYING);
    }
    forget(p);
    pthread_mutex_unlock(&p->lock);
}

int fake_pyramid_under_way(struct pyramid *p, int *stale)
{
    int count = 0;
    *stale = 0;
    pthread_mutex_lock(&p->lock);
    for (int i = 0; i < p->late_count; i++) {
        if (!p->late[i].want) continue;
        count++;
        *stale += want_cancelled(p->late[i].want);
    }
    pthread_mutex_unlock(&p->lock);
    return count;
}

void pyramid_release(struct pyramid *p, const pyramid_tile **tile)
{
    p->held--;
    free((void *)*tile);
    *tile = NULL;
}
