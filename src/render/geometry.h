// Support geometries: the ways to place vertices that sample the windows. A geometry contributes
// vertex placement and culling, nothing else: windows, streaming, shading and measures are shared,
// so that modes can be compared. Main only.
//
// A geometry draws into the framebuffer bound now (frame_begin_geometry has bound it, the uniform
// blocks and the height windows), for each pixel: reversed depth (view.clip_from_tangent of the
// position relative to the camera, tangent frame, m); the ring coordinates n~, e~ of the point on
// the unit sphere of reduced latitude about the focus; with `identify` the draw + 1 (0: nothing was
// drawn) and a number that no other triangle of the frame has; with `texcoord_vertex` the map
// coordinates relative to the focus. mesh/mesh.frag writes these from what any vertex shader gives
// it. Culled away may only be what cannot be seen: no pixel inside the limb stays empty.
#ifndef PERIGEE_RENDER_GEOMETRY_H
#define PERIGEE_RENDER_GEOMETRY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "perigee.h"
#include "render/gaze.h"
#include "render/projection.h"
#include "render/windows.h"

typedef struct geometry_params {
    const perigee_view_params *view; // complete; borrowed until `create` returns, as are the others
    const struct windows *windows;
    geo_ellipsoid body;
    const char *defines; // text put before every shader
} geometry_params;

// Of one frame; borrowed for a call.
typedef struct geometry_frame {
    const projection *projection;
    struct windows *windows; // of the frame before while levels are chosen
    gaze gaze;
    cell_view view;  // frustum, with room for the jitter, and horizon
    int finest;      // level up to which windows are loaded: the same in every mode
    int first, last; // levels; chosen by `levels` unless the user gave them
} geometry_frame;

typedef struct geometry_counts {
    uint64_t triangles_total; // before culling
    uint64_t triangles_drawn, vertices_placed, draws;
    bool map_edge; // a place is in sight that the mode cannot draw as it should
} geometry_counts;

// What every geometry begins with.
struct geometry {
    const struct geometry_mode *mode;
};

// One way to place vertices: a row of the table in geometry.c.
struct geometry_mode {
    const char *name; // of --mode
    bool outside;     // it cannot draw for a camera below the planet's lowest ground
    // Fills what is left 0 of the mode's own parameters and refuses (ERR_ARGUMENT, logged) what
    // cannot be, after the shared ones are complete. NULL: it has none.
    status (*complete)(perigee_view_params *params);
    // As perigee_view_params_resize. NULL: there is one size.
    void (*resize)(perigee_view_params *params, double size, uint64_t triangles);
    // ERR_GPU, ERR_MEMORY.
    status (*create)(const geometry_params *params, struct geometry **out);
    void (*destroy)(struct geometry *geometry);
    size_t (*gpu_bytes)(const struct geometry *geometry); // all taken at creation
    // The coarsest and finest level drawn.
    void (*levels)(const struct geometry *geometry, const geometry_frame *frame, int *first,
                   int *last);
    // What depends on the camera's position, the focus or the heights must be made again.
    void (*invalidate)(struct geometry *geometry);
    void (*draw)(struct geometry *geometry, const geometry_frame *frame, geometry_counts *counts);
    // Level (last + 1: inside the finest) and sector of a draw of the last frame, counted from 0.
    void (*identify)(const struct geometry *geometry, uint32_t draw, int *level, int *sector);
};

// NULL: there is no such mode.
const struct geometry_mode *geometry_mode_find(enum perigee_mode mode);

status geometry_create(enum perigee_mode mode, const geometry_params *params,
                       struct geometry **out);
void geometry_destroy(struct geometry **geometry);

// The rows.
extern const struct geometry_mode geometry_spherical;
extern const struct geometry_mode geometry_planar;
extern const struct geometry_mode geometry_grid;

#endif
