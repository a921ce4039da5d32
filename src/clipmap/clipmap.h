// The windows of one layer at every level and their filling: plans which strips are new, has
// workers read and resample them, and hands finished strips to the owner of the textures in order,
// coarse to fine. No GL here. Main only, one owner; workers inside.
#ifndef PERIGEE_CLIPMAP_CLIPMAP_H
#define PERIGEE_CLIPMAP_CLIPMAP_H

#include <stddef.h>

#include "base/pool.h"
#include "clipmap/window.h"
#include "planet/pyramid.h"

enum { CLIPMAP_MAX_LEVELS = 24, CLIPMAP_MAX_ROWS = 64 }; // rows: of a strip

struct clipmap;

typedef struct clipmap_params {
    enum tile_layer layer; // LAYER_HEIGHT (samples are float) or LAYER_COLOR (samples are RGBA8)
    window_shape shape;
    int levels;           // 0 .. levels - 1
    double ring_bound;    // A/B of the ellipsoid
    size_t staging_bytes; // bound of strips finished or in work; 0: 32 MiB, at least one row of
                          // samples
    size_t samples_frame; // handed out in a frame at most, at least one row; 0: as many as a window
                          // has, the n^2 of Losasso & Hoppe 2004, 5
    bool residuals; // heights are rounded to whole quanta (clipmap/residual.h), and handed out
                    // as residuals where that can be
} clipmap_params;

// What a level holds now. `valid` is what may be sampled: complete, uploaded, inside window.rect.
typedef struct clipmap_level {
    window window;     // of the last clipmap_move
    window held;       // the window (zoom, share) the texture's samples belong to
    window_rect valid; // part of it that is uploaded; may be empty. With the share of `window` it
                       // lies inside window.rect; with another share it counts columns by
                       // held.share, until the first strip of the new share
    bool complete;     // valid == window.rect, the shares agree and no sample is recast: nothing is
                       // missing
    float min, max;    // heights: bounds of the valid samples; +inf, -inf when empty
} clipmap_level;

// A finished strip: upload rect (already split so that it does not wrap in the texture) to texture
// texels [tex_col, +cols) x [tex_row, +rows) of layer `level`. samples: rows * cols of float or
// RGBA8, row-major.
typedef struct clipmap_strip {
    int level;
    window window; // to which the rect belongs
    window_rect rect;
    int tex_row, tex_col, rows, cols;
    const void *samples;
    size_t bytes;
    bool again; // what was valid stood in for what could not be had, or was recast: it stays so
    // Of a derived window (window.derived > 0): `samples` holds nothing and bytes is 0. The owner
    // makes the rectangle from the texture of level - 1, in which now (not later) all is valid that
    // it is made of, and says in `ranges` what clip_bounds_reduce would say, before
    // clipmap_uploaded, which may be frames later.
    const struct clip_range *ranges;
    // Not NULL: rows * cols residuals instead of `samples`, over the texture of level - 1, in which
    // now (not later) all is valid that they add to. The sums have the bits of `samples`.
    const int16_t *residuals;
} clipmap_strip;

struct clipmap_counters {
    uint64_t strips, samples, bytes; // handed out since creation
    uint64_t residuals;              // of these samples
    uint64_t refills;                // levels filled from nothing
    uint64_t frames;                 // begun
    uint64_t frame_samples;          // handed out since the frame began
    uint64_t most_frame_samples;     // in a frame with a budget
    uint32_t yielded;     // bit i: in the frame before, level i was wanted, not complete,
                          // and held back by the budget or by the speed of the viewer
    size_t staging_bytes; // now
    int waiting;          // strips whose tiles are on their way, now
};

// pyramid and pool are borrowed and outlive the clipmap.
status clipmap_create(struct pyramid *pyramid, struct pool *pool, const clipmap_params *params,
                      struct clipmap **out);
void clipmap_destroy(struct clipmap **clipmap); // waits for its own work

// Levels may be derived: `derives` says whether all of a level's window can be made from the window
// of the level before, as a function of the two alone. Asked at each move; while it is so, the
// level's strips are derived (see clipmap_strip). Before the first move.
void clipmap_set_derives(struct clipmap *clipmap,
                         bool (*derives)(void *user, const window *w, const window *coarser),
                         void *user);

// Where a level's share doubles or halves, its samples may be recast: made samples of the new share
// in place, in the texture, so that what is valid stays so until all of the window has been filled
// anew. Without this nothing is valid from the first new strip to the last. `recast` is called in a
// move; before any later strip is uploaded the owner makes the rectangle `valid` of `to`
// (window_rect_recast) out of the samples of `from`: of two columns their mean; of one column two,
// heights at most by the cubic of weights -9, 111, 29, -3 in 128. Strips handed out earlier have to
// be in the texture by then, whether clipmap_uploaded has been told or not. Before the first move.
void clipmap_set_recast(struct clipmap *clipmap,
                        void (*recast)(void *user, const window *from, const window *to,
                                       window_rect valid),
                        void *user);

// Sets the focus (geodetic, rad) and the levels wanted [first, last]; level 0 and all coarser
// levels than `last` stay wanted as the fallback. Plans, queues work, never blocks. Strips of a
// plan that a newer move made useless are dropped. Call once a frame.
void clipmap_move(struct clipmap *clipmap, double lat, double lon, int last);

// Begins a frame. A level that is whole but partly made of stand-ins, whose time is over, is filled
// again, in place. Gives out the next budget of samples (params.samples_frame; `unbounded`: no end
// of it). Coarse levels have the first of it, so that the finest yield first. A level whose window
// will have left its place before its strips can have come (by how long they took of late) yields
// too, and all finer ones, instead of asking for what nobody will see. They come back when there is
// budget again and the viewer is slower. Without any call there is no budget.
void clipmap_begin_frame(struct clipmap *clipmap, bool unbounded);

// The next finished strip, coarse to fine, of at most `budget` bytes and the frame's samples (a
// longer one is handed out in parts, of whole rows); false when there is none. The strip's samples
// stay until clipmap_uploaded. From this call on, texels of the strip are no longer `valid` for
// older data. Upload strips in the order they were handed out; each must come back through
// clipmap_uploaded, even when a newer move has made it useless.
bool clipmap_next_strip(struct clipmap *clipmap, size_t budget, clipmap_strip *out);
void clipmap_uploaded(struct clipmap *clipmap, const clipmap_strip *strip);

clipmap_level clipmap_level_state(const struct clipmap *clipmap, int level);

// True when every wanted level is complete. `missing`, when not NULL, gets the number of strips
// outstanding.
bool clipmap_complete(const struct clipmap *clipmap, int *missing);

// Does a wanted level show what stands in for tiles that could not be had, or is it being filled
// again? It is complete all the same.
bool clipmap_provisional(const struct clipmap *clipmap);

// Blocks until some strip is ready or `timeout_s` has passed or nothing is outstanding; true when
// one is ready.
bool clipmap_wait(struct clipmap *clipmap, double timeout_s);

void clipmap_counters(const struct clipmap *clipmap, struct clipmap_counters *out);

// Resamples a rectangle of a window from the pyramid; what the workers do. samples: (row1-row0) *
// (col1-col0) of float or RGBA8. Window columns coarser than the tile's samples average them (at
// most 256 of them), finer ones interpolate linearly; colour (sRGB-encoded, A too) in linear light.
// ERR_MEMORY only. Any thread.
status clipmap_fill(struct pyramid *pyramid, enum tile_layer layer, const window_shape *shape,
                    const window *w, window_rect rect, void *samples);

// The same without waiting: ERR_PENDING when tiles are still on their way; the want has a share in
// each of them. *until_s: the samples stand until then (clock_now_s), INFINITY but for stand-ins.
status clipmap_try_fill(struct pyramid *pyramid, enum tile_layer layer, const window_shape *shape,
                        const window *w, window_rect rect, struct want *want, void *samples,
                        double *until_s);

#endif
