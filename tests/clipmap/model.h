// A texture of plain arrays fed by a clipmap, as the owner of the GPU's textures would do it, and
// what must hold of it after every step. Texels whose strip was handed out and not yet uploaded are
// poisoned, where they may not be sampled.
#ifndef PERIGEE_TESTS_MODEL_H
#define PERIGEE_TESTS_MODEL_H

#include "clipmap/clipmap.h"
#include "fake_pyramid.h"

enum { MODEL_PENDING = 512 };

struct model {
    struct pyramid *pyramid;
    struct pool *pool;
    struct clipmap *clipmap;
    clipmap_params params;
    float *texels[CLIPMAP_MAX_LEVELS];   // colour: the bytes of RGBA
    uint8_t *recast[CLIPMAP_MAX_LEVELS]; // texels: 1 where not as workers fill them
    int recasts;
    clipmap_strip pending[MODEL_PENDING]; // handed out, not uploaded, in order
    int first, count;
};

void model_init(struct model *m, const clipmap_params *params, int threads, int pool_capacity);
// From here on heights are recast where shares change. Before the first move.
void model_recast(struct model *m);
void model_deinit(struct model *m); // also with strips pending

// Takes one strip of at most `budget` bytes; false when there is none.
bool model_take(struct model *m, size_t budget);
// Uploads the oldest strip taken; false when there is none.
bool model_upload(struct model *m);

// Streams until everything wanted is complete; fails the test when that takes half a minute.
void model_finish(struct model *m);

// Every valid sample of every level is what the oracle says, or was recast and its level is not
// complete; lies in window and bounds, and
// `complete` is true exactly when all of the window is valid. Returns the number of samples looked
// at.
int64_t model_check(const struct model *m);
// The same for every third level, beginning with phase % 3.
int64_t model_check_third(const struct model *m, int phase);

// A hash of all texels of the complete levels 0 .. last.
uint64_t model_hash(const struct model *m, int last);

#endif
