#include "app/team.h"

#include <stdlib.h>

#include "base/log.h"

// How many processes the launcher says there are; 1 without a launcher.
static int launched(void)
{
    static const char *const names[] = {"OMPI_COMM_WORLD_SIZE", "PMIX_SIZE", "PMI_SIZE"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        const char *size = getenv(names[i]);
        if (size) return atoi(size);
    }
    return 1;
}

#ifndef PERIGEE_MPI

status team_begin(import_team **team, int *threads)
{
    *team = NULL;
    *threads = 0;
    if (launched() < 2) return OK;
    log_error("import: started as %d processes, but this perigee was built without MPI",
              launched());
    return ERR_UNSUPPORTED;
}

void team_end(import_team **team)
{
    *team = NULL;
}

#else

#include <mpi.h>
#include <time.h>
#include <unistd.h>

enum { TAG_ASK = 1, TAG_ANSWER = 2, ID_INTS = 4, ANSWER_INTS = 1 + TEAM_BATCH * ID_INTS };

// MPI waits by spinning, which would take the processor from the workers.
static void wait_for(MPI_Request *request)
{
    for (int done = 0; !done;) {
        MPI_Test(request, &done, MPI_STATUS_IGNORE);
        if (!done) nanosleep(&(struct timespec){0, 300 * 1000}, NULL);
    }
}

static bool asked(void *user, int *rank, status *fares)
{
    (void)user;
    int waiting = 0, code = 0;
    MPI_Status from;
    MPI_Iprobe(MPI_ANY_SOURCE, TAG_ASK, MPI_COMM_WORLD, &waiting, &from);
    if (!waiting) return false;
    MPI_Recv(&code, 1, MPI_INT, from.MPI_SOURCE, TAG_ASK, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    *rank = from.MPI_SOURCE;
    *fares = (status)code;
    return true;
}

static void answer(void *user, int rank, const tile_id *ids, int count)
{
    (void)user;
    int message[ANSWER_INTS] = {count};
    for (int i = 0; i < count; i++) {
        int *m = message + 1 + ID_INTS * i;
        m[0] = (int)ids[i].layer;
        m[1] = ids[i].zoom;
        m[2] = ids[i].row;
        m[3] = ids[i].col;
    }
    MPI_Send(message, ANSWER_INTS, MPI_INT, rank, TAG_ANSWER, MPI_COMM_WORLD);
}

static int ask(void *user, status fares, tile_id ids[TEAM_BATCH])
{
    (void)user;
    int code = (int)fares, message[ANSWER_INTS];
    MPI_Request request;
    MPI_Send(&code, 1, MPI_INT, 0, TAG_ASK, MPI_COMM_WORLD);
    MPI_Irecv(message, ANSWER_INTS, MPI_INT, 0, TAG_ANSWER, MPI_COMM_WORLD, &request);
    wait_for(&request);
    for (int i = 0; i < message[0]; i++) {
        const int *m = message + 1 + ID_INTS * i;
        ids[i] = (tile_id){(enum tile_layer)m[0], m[1], m[2], m[3]};
    }
    return message[0];
}

static status agree(void *user, status mine)
{
    (void)user;
    int own = (int)mine, all = 0;
    MPI_Request request;
    MPI_Iallreduce(&own, &all, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD, &request);
    wait_for(&request);
    return (status)all;
}

static uint64_t sum(void *user, uint64_t mine)
{
    (void)user;
    uint64_t all = 0;
    MPI_Request request;
    MPI_Iallreduce(&mine, &all, 1, MPI_UINT64_T, MPI_SUM, MPI_COMM_WORLD, &request);
    wait_for(&request);
    return all;
}

static int count_here(void)
{
    MPI_Comm host;
    int here = 1;
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &host);
    MPI_Comm_size(host, &here);
    MPI_Comm_free(&host);
    return here;
}

status team_begin(import_team **team, int *threads)
{
    static import_team all = {
        .asked = asked, .answer = answer, .ask = ask, .agree = agree, .sum = sum};
    *team = NULL;
    *threads = 0;
    if (launched() < 2) return OK;
    int provided = 0;
    if (MPI_Init_thread(NULL, NULL, MPI_THREAD_FUNNELED, &provided) != MPI_SUCCESS ||
        provided < MPI_THREAD_FUNNELED) {
        log_error("import: MPI cannot be used beside threads");
        return ERR_UNSUPPORTED;
    }
    MPI_Comm_rank(MPI_COMM_WORLD, &all.rank);
    MPI_Comm_size(MPI_COMM_WORLD, &all.size);
    all.here = count_here();
    *threads = (int)(sysconf(_SC_NPROCESSORS_ONLN) / all.here);
    if (*threads < 1) *threads = 1;
    *team = &all;
    return OK;
}

void team_end(import_team **team)
{
    if (*team) MPI_Finalize();
    *team = NULL;
}

#endif
