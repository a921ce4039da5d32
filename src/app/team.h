// The processes that mpirun started, as a team for an import (planet/import_team.h). Main only.
#ifndef PERIGEE_APP_TEAM_H
#define PERIGEE_APP_TEAM_H

#include "planet/import_team.h"

// *team: NULL in a process of its own, which then stays clear of MPI. ERR_UNSUPPORTED, logged,
// under mpirun when the program was built without MPI. threads: workers for each process when the
// user says nothing, so that those of one host share its processors; 0: all of them.
status team_begin(import_team **team, int *threads);
void team_end(import_team **team);

#endif
