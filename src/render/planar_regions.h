// The regions of a level (Losasso & Hoppe 2004, 3 and 5), in vertices of its square, both ends
// included: the clip region has data, the active region is wanted and cropped to what there is, the
// render region is the active one less the next finer's. Between them hold the four constraints:
//
//     clip(l + 1) lies in clip(l) less 1 all around, active(l) in clip(l); the border of active(l)
//     lies on even vertices; active(l + 1) lies in active(l) less 2 all around.
//
// Pure functions. Any thread.
#ifndef PERIGEE_RENDER_PLANAR_REGIONS_H
#define PERIGEE_RENDER_PLANAR_REGIONS_H

#include <stdbool.h>

#include "geo/nest.h"

// Empty when row0 >= row1 or column0 >= column1.
typedef struct planar_region {
    int row0, row1, column0, column1;
} planar_region;

bool planar_region_empty(planar_region r);

// All of the square, or the part of it that `share` in (0, 1] of its side covers about the middle.
planar_region planar_region_wanted(const nest_square *s, double share);

// A finer level's region in the coarser one's vertices; its border is even.
planar_region planar_region_in_coarser(const nest_square *finer, const nest_square *coarser,
                                       planar_region r);

// Crops clip[first .. last] and from them active, coarse to fine; returns the finest level that is
// not empty. first's is drawn whatever there is of it.
int planar_regions_crop(const nest_square *squares, int first, int last, double share,
                        planar_region *clip, planar_region *active);

// min(n / 10, least distance from the border to the finer region, in steps); 2 at least
// (2004, 6.2). finer: in this level's vertices, may be empty.
double planar_region_transition(int n, planar_region active, planar_region finer);

// How far from the viewer (in vertices of the square) the transition begins: before the border by
// its width and what the viewer may be off the middle, and nowhere on the finer region, whose
// border has this level's heights as they are.
double planar_region_begin(const nest_square *s, planar_region active, planar_region finer);

// The render region as at most four rectangles of quads; returns their number.
int planar_region_frame(planar_region active, planar_region finer, planar_region out[4]);

#endif
