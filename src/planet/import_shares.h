// The tiles of a zoom, divided among the processes of a team so that each mostly makes the parents
// of tiles it has made, and has read the rows of rasters around. A share is a run of the walk. Who
// is done with its own takes half of what the longest other has left, so that none waits for a slow
// one. Main only.
#ifndef PERIGEE_PLANET_IMPORT_SHARES_H
#define PERIGEE_PLANET_IMPORT_SHARES_H

#include "planet/import_plan.h"

struct shares;

struct shares *shares_create(int ranks);
void shares_destroy(struct shares **shares);

// Divides another walk (owned from now on), whatever is left of the one before; in proportion to
// what each rank got of that, in turned order, since a zoom is walked from where the finer one
// ended. (Where a coarser raster joins in, so that the zoom holds more than the parents of the one
// before, who made those is not looked at.)
void shares_divide(struct shares *shares, struct plan_walk *walk);
// The next is a walk of another kind: equal shares.
void shares_forget(struct shares *shares);

// The next tile for a rank; false when none is left for any.
bool shares_next(struct shares *shares, int rank, tile_id *id);

// So many tiles may go to a rank at once without leaving others idle at the end: 1 to `most`.
int shares_batch(const struct shares *shares, int rank, int most);

#endif
