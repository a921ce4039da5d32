#include "planet/import_shares.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

// A piece of the walk that was divided, and whose it is.
struct run {
    struct plan_walk *walk; // of what is left
    int rank;
    uint64_t got; // tiles taken
};

struct shares {
    int ranks, count, room;
    struct run *runs; // in the order of the walk
};

struct shares *shares_create(int ranks)
{
    struct shares *s = NEW(struct shares);
    s->ranks = ranks;
    return s;
}

void shares_forget(struct shares *s)
{
    for (int i = 0; i < s->count; i++) plan_walk_end(&s->runs[i].walk);
    s->count = 0;
}

void shares_destroy(struct shares **shares)
{
    if (!*shares) return;
    shares_forget(*shares);
    free((*shares)->runs);
    free(*shares);
    *shares = NULL;
}

static void insert(struct shares *s, int at, struct run run)
{
    if (s->count == s->room) {
        s->room = 2 * s->room + 16;
        struct run *runs = NEW_ARRAY(struct run, (size_t)s->room);
        if (s->count) memcpy(runs, s->runs, (size_t)s->count * sizeof *runs);
        free(s->runs);
        s->runs = runs;
    }
    memmove(s->runs + at + 1, s->runs + at, (size_t)(s->count - at) * sizeof run);
    s->runs[at] = run;
    s->count++;
}

// What each rank got of the walk before, in turned order; without one the same for all.
static void turn(struct shares *s)
{
    int before = s->count;
    struct run *runs = s->runs;
    s->runs = NULL;
    s->count = s->room = 0;
    for (int i = before - 1; i >= 0; i--) {
        plan_walk_end(&runs[i].walk);
        struct run *last = s->count ? &s->runs[s->count - 1] : NULL;
        if (last && last->rank == runs[i].rank) last->got += runs[i].got;
        else if (runs[i].got) insert(s, s->count, runs[i]);
    }
    free(runs);
    for (int rank = 0; !before && rank < s->ranks; rank++)
        insert(s, rank, (struct run){.rank = rank, .got = 1});
}

void shares_divide(struct shares *s, struct plan_walk *walk)
{
    double got = 0;
    turn(s);
    for (int i = 0; i < s->count; i++) got += (double)s->runs[i].got;
    for (int i = 0; i < s->count; i++) {
        struct run *r = &s->runs[i];
        double part = (double)r->got / got;
        got -= (double)r->got;
        r->got = 0;
        r->walk = walk;
        if (i == s->count - 1) return;
        walk = plan_walk_split(walk, (uint64_t)((double)plan_walk_left(walk) * part + 0.5));
    }
    plan_walk_end(&walk); // there was nothing before, so there is nothing now
}

// The run that a rank takes its next tile from: its own first, else half of the longest one becomes
// its own. NULL: none is left.
static struct run *find(struct shares *s, int rank)
{
    int longest = 0;
    uint64_t most = 0;
    for (int i = 0; i < s->count; i++) {
        uint64_t left = plan_walk_left(s->runs[i].walk);
        if (left && s->runs[i].rank == rank) return &s->runs[i];
        if (left <= most) continue;
        longest = i;
        most = left;
    }
    if (most < 2) return most ? &s->runs[longest] : NULL;
    struct plan_walk *half = plan_walk_split(s->runs[longest].walk, most / 2);
    insert(s, longest + 1, (struct run){.walk = half, .rank = rank});
    return &s->runs[longest + 1];
}

bool shares_next(struct shares *s, int rank, tile_id *id)
{
    struct run *run = find(s, rank);
    if (!run) return false;
    run->got++;
    return plan_walk_next(run->walk, id);
}

int shares_batch(const struct shares *s, int rank, int most)
{
    uint64_t left = 0;
    for (int i = 0; i < s->count; i++)
        if (s->runs[i].rank == rank) left += plan_walk_left(s->runs[i].walk);
    return 1 + left / 4 < (uint64_t)most ? 1 + (int)(left / 4) : most;
}
