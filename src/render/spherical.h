// The spherical clipmap's support geometry: static rings, cells, placing by compute, one
// multi-draw. Main only. Contributes where the terrain is; what it looks like is the frame's
// full-screen pass.
#ifndef PERIGEE_RENDER_SPHERICAL_H
#define PERIGEE_RENDER_SPHERICAL_H

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"
#include "render/stride.h"
#include "render/windows.h"

struct spherical;

typedef struct spherical_params {
    ring_params rings;
    bool identify;       // the shaders write identifiers
    const char *defines; // text put before the shaders
    // The transform may be off by more than a level's window (the paper's are, near the ground), so
    // that a height can come from any coarser level.
    bool any_level;
} spherical_params;

// What of the rings is drawn.
struct ring_draw {
    cell_view view;
    ring_sight sight;
    int first, last; // levels
    bool cull;
};

struct spherical_counts {
    uint64_t triangles_total, triangles_drawn, vertices_placed, draws;
};

status spherical_create(const spherical_params *params, struct spherical **out);
void spherical_destroy(struct spherical **spherical);
size_t spherical_gpu_bytes(const struct spherical *s);

// Every vertex must be placed again: the camera's position, the focus or the heights changed.
void spherical_invalidate(struct spherical *s);

// Chooses the visible cells of levels first .. last, places those not placed yet (compute; the
// uniform blocks and the height texture are bound), and draws them with the mesh program into the
// framebuffer bound now.
void spherical_draw(struct spherical *s, const struct windows *w, const struct ring_draw *draw,
                    struct spherical_counts *counts);

// The cell that draw `draw` (from 0, as mesh.frag's identifiers count) of the last spherical_draw
// drew.
int spherical_drawn_cell(const struct spherical *s, uint32_t draw);

#endif
