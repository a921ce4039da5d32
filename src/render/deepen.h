// Heights of a level below the data on the GPU, from the next coarser level's window: what the
// pyramid makes of its tiles, without a tile, a worker, or a sample uploaded. Only where both
// levels' columns are those of the tiles. Main only.
#ifndef PERIGEE_RENDER_DEEPEN_H
#define PERIGEE_RENDER_DEEPEN_H

#include <epoxy/gl.h>

#include "clipmap/bounds.h"
#include "clipmap/clipmap.h"
#include "planet/pyramid.h"

struct deepen;

// The pyramid is borrowed. levels: of the heights; max_rows: of a strip; defines: text put before
// the shader, or NULL.
status deepen_create(struct pyramid *pyramid, const window_shape *shape, int levels, int max_rows,
                     const char *defines, struct deepen **out);
void deepen_destroy(struct deepen **deepen);
size_t deepen_gpu_bytes(const struct deepen *deepen);

// May a rectangle of a window be made from the window of the level before? It depends on place,
// zooms and shares alone. The coarser window must hold window_rect_parents() of it.
bool deepen_can(const struct deepen *deepen, const window *w, window_rect rect,
                const window *coarser);

// Begins to make a strip (its window and rect; the columns do not wrap in the texture) in the array
// of heights (GL_R32F), whose level before holds what it is made of; later commands may use it.
// Does not wait. Returns the bytes sent to the GPU; 0 when there is no room for another and
// nothing was done.
//   error   against the pyramid's tiles: bench/RESULTS-synthesis.md
size_t deepen_run(struct deepen *deepen, GLuint texture, const clipmap_strip *strip);
bool deepen_has_room(const struct deepen *deepen);
// The same without ranges, which needs no room and no release; the columns may wrap.
size_t deepen_make(struct deepen *deepen, GLuint texture, const window *w, window_rect rect);
bool deepen_busy(const struct deepen *deepen);

// The strip begun first of those not released, with its ranges, which stand until deepen_release;
// false while the GPU has not made it or there is none. Waits at most timeout_s.
bool deepen_finished(struct deepen *deepen, double timeout_s, clipmap_strip *out);
void deepen_release(struct deepen *deepen);

#endif
