// Levels below the data that are not kept but made anew in each frame (Asirvatham & Hoppe 2005,
// 2.6.3): from the first level on that lies wholly below all data of the planet, levels take turns
// with two layers of heights, coarse to fine, each made from the one before (render/deepen.h). What
// is drawn or shaded with a level has to be so before the one after the next is made.
//
// A level is there when the one before is shown, whole and faded in, wherever it is made from it:
// so they fade in one after the other, and never more than two are blended. Main only.
#ifndef PERIGEE_RENDER_FLEETING_H
#define PERIGEE_RENDER_FLEETING_H

#include "render/deepen.h"
#include "render/shown.h"

// Layers that fleeting levels take turns with (shaders/lib/layers.glsl); of convexity, which is
// looked up four levels up as well, some more.
enum { FLEETING_LAYERS = 2, FLEETING_CONVEXITY_LAYERS = 5 };

struct fleeting {
    int kept, levels;                  // levels with a layer of their own; all levels
    int made;                          // the finest made in this sweep; kept - 1: none
    window window[CLIPMAP_MAX_LEVELS]; // of fleeting levels; without a share of the map they have
                                       // an empty rect
    float rise;                        // how far their heights can lie above all data's around, m,
    float rise_share;                  // and that as a share of the data's range
};

// The number of levels to keep of `levels`.
int fleeting_kept(const struct pyramid *pyramid, const window_shape *shape, int levels);
void fleeting_init(struct fleeting *f, const struct pyramid *pyramid, const window_shape *shape,
                   int kept, int levels);

// The windows for a focus. A level that cannot be made from the one before, and all finer ones, are
// not there: near a pole, and where tiles and windows are of different width.
void fleeting_move(struct fleeting *f, const struct deepen *deepen, const window_shape *shape,
                   double lat, double lon, double ring_bound);

// As clipmap_level_state(). before: what is shown of the level before; data: of the finest kept.
clipmap_level fleeting_state(const struct fleeting *f, const window_shape *shape, int level,
                             const struct shown *before, const clipmap_level *data);

#endif
