// The workers that make the tiles of a zoom, of this process and of the team's others.
#ifndef PERIGEE_PLANET_IMPORT_CREW_H
#define PERIGEE_PLANET_IMPORT_CREW_H

#include "planet/import_plan.h"
#include "planet/import_store.h"
#include "planet/import_team.h"
#include "planet/import_tile.h"

struct crew;

typedef struct crew_params {
    struct import_store *store;
    const import_team *team; // NULL: alone
    int threads;             // 0: one for each processor
    bool (*progress)(void *user, const char *stage, double done);
    void *user;
} crew_params;

struct crew_counters {
    uint64_t made;    // tiles stored by this process
    uint64_t empty;   // looked at, and without data
    uint64_t uniform; // of `made`: one value throughout
    uint64_t kept;    // rank 0: there already
    uint64_t bytes;   // of the bodies made
};

struct crew *crew_create(const crew_params *params);
void crew_destroy(struct crew **crew);
int crew_threads(const struct crew *crew);

// Work that follows: its name in reports, how many tiles it is about, who makes them (borrowed).
void crew_begin(struct crew *crew, const char *stage, uint64_t tiles, struct workshop *workshop);

// Before tiles of a zoom are made: what all ranks have sealed can be read. alone: rank 0 makes all
// tiles until crew_seal, and the others wait there.
status crew_look(struct crew *crew, bool alone);
// Makes the tiles of a walk (owned from now on), over which all ranks must agree, only rank 0's
// being walked. ERR_CANCELLED when progress asked to stop.
status crew_make(struct crew *crew, struct plan_walk *walk);
// What was made stands in files that all can read. How all ranks fare.
status crew_seal(struct crew *crew);

struct crew_counters crew_count(const struct crew *crew);

#endif
