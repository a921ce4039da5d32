// What the two forms of the planar mode share: the squares of a frame, their tables, the elevation
// maps; and how each form draws. Main only.
#ifndef PERIGEE_RENDER_PLANAR_PARTS_H
#define PERIGEE_RENDER_PLANAR_PARTS_H

#include "render/geometry.h"
#include "render/planar_cull.h"
#include "render/planar_elevation.h"
#include "render/planar_regions.h"

struct planar_footprints; // Asirvatham & Hoppe 2005: instances of footprints
struct planar_rectangles; // Losasso & Hoppe 2004: rectangles cropped to the frustum

struct planar {
    struct geometry base;
    enum perigee_planar_form form;
    int n, levels, kept;     // kept: levels with an elevation map of their own
    uint64_t most_triangles; // 0: no bound
    bool cull, plane;
    bool stale, told; // tables are to be made again; the pole was spoken of
    struct planar_elevation *elevation;
    struct planar_footprints *footprints; // the form's own; the other is NULL
    struct planar_rectangles *rectangles;
    GLuint program, rows, columns, squares;
    size_t gpu_bytes;
    nest_row *row_table;
    nest_column *column_table;

    // Of the frame.
    int first, last; // levels drawn
    int together;    // the finest of those that are drawn at once; finer ones come one by one
    nest_square square[CLIPMAP_MAX_LEVELS];
    planar_region clip[CLIPMAP_MAX_LEVELS], active[CLIPMAP_MAX_LEVELS];
};

// In an instance's level: the triangles of its border.
enum { PLANAR_IS_BORDER = 0x100 };

// Footprint (row, column) and instance attributes of planar.vert.
GLuint planar_vertex_array(GLuint vertices, GLuint instances, GLuint indices);

// Can any terrain of the rectangle of a level's quads be seen?
bool planar_visible(const struct planar *p, const geometry_frame *f, int level, planar_region r);

// One of the two. GPU memory taken is added to p->gpu_bytes. ERR_GPU.
status planar_footprints_create(struct planar *p, struct planar_footprints **out);
void planar_footprints_destroy(struct planar_footprints **footprints);
void planar_footprints_select(struct planar_footprints *o, const struct planar *p,
                              const geometry_frame *f);
// The levels up to p->together, and each finer one: group 0, 1 and so on.
void planar_footprints_draw(const struct planar_footprints *o, int group, geometry_counts *counts);
void planar_footprints_identify(const struct planar_footprints *o, uint32_t number, int *level,
                                int *sector);

status planar_rectangles_create(struct planar *p, struct planar_rectangles **out);
void planar_rectangles_destroy(struct planar_rectangles **rectangles);
// Returns the triangles that the rectangles have.
uint64_t planar_rectangles_select(struct planar_rectangles *o, const struct planar *p,
                                  const geometry_frame *f);
void planar_rectangles_draw(struct planar_rectangles *o, const struct planar *p,
                            geometry_counts *counts);

#endif
