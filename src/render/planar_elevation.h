// The elevation maps of a geometry clipmap (Asirvatham & Hoppe 2005, 2.2.1): for each vertex of
// each level its height and that of the next coarser level's triangles, computed from the windows
// when these or the square change. Main only.
#ifndef PERIGEE_RENDER_PLANAR_ELEVATION_H
#define PERIGEE_RENDER_PLANAR_ELEVATION_H

#include <epoxy/gl.h>

#include "geo/nest.h"
#include "render/planar_regions.h"
#include "render/windows.h"

struct planar_elevation;

typedef struct planar_elevation_params {
    int n, levels;
    int kept;    // levels with a map of their own; the rest take turns with two
    bool packed; // whole metres, and the coarser height's difference in the fraction (2005, 2.4.1)
    const char *defines;
} planar_elevation_params;

// ERR_GPU.
status planar_elevation_create(const planar_elevation_params *params,
                               struct planar_elevation **out);
void planar_elevation_destroy(struct planar_elevation **elevation);
GLuint planar_elevation_texture(const struct planar_elevation *e);
size_t planar_elevation_bytes(const struct planar_elevation *e);

// The height windows' level of a square.
int planar_height_level(const nest_square *square);

// The vertices of the square whose heights are there in its window, so that they borrow no coarser
// level's (2004, 3: the clip region). May reach beyond the square.
planar_region planar_elevation_clip(const struct windows *w, const struct levels_block *block,
                                    const nest_square *square);

// The number of levels that are sampled from kept windows, of those there are.
int planar_elevation_kept(const struct windows *w, int levels, bool plane);

// Brings the maps of levels first .. last up to date, coarse to fine (the uniform blocks and the
// height windows are bound). coarsest: of the frame, which has no coarser one. A level that is not
// kept is computed anew, from its window made anew, and stays until the one after the next; they
// must come one by one in one sweep of the windows. Returns the number of vertices computed.
uint64_t planar_elevation_update(struct planar_elevation *e, struct windows *w,
                                 const nest_square *squares, int coarsest, int first, int last);

#endif
