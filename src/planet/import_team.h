// Several processes that make one import together, as import.c sees them; app/team.h makes one of
// MPI. All functions: main only, of each process. Rank 0 gives out the tiles.
#ifndef PERIGEE_PLANET_IMPORT_TEAM_H
#define PERIGEE_PLANET_IMPORT_TEAM_H

#include "base/status.h"
#include "planet/grid.h"

enum { TEAM_BATCH = 64 };

typedef struct import_team {
    int rank, size;
    int here; // ranks on this host
    void *user;
    // Rank 0, does not wait: false when no rank asks for tiles; else which, and how it fares.
    bool (*asked)(void *user, int *rank, status *fares);
    // Rank 0: tiles for a rank that asked, at most TEAM_BATCH; none: this zoom is done.
    void (*answer)(void *user, int rank, const tile_id *ids, int count);
    // Other ranks: asks for tiles and waits for them.
    int (*ask)(void *user, status fares, tile_id ids[TEAM_BATCH]);
    // All ranks, waits for all: the first (by code) of the statuses that are not OK.
    status (*agree)(void *user, status mine);
    // All ranks, waits for all: the sum.
    uint64_t (*sum)(void *user, uint64_t mine);
} import_team;

#endif
