// The edges of a depth picture and how far the edges of two pictures lie apart. Any thread.
//
// Along a row or column of a plane 1/z is linear, so a pixel's plane says what the next pixel
// should show. Two surfaces that meet between two pixels disagree with both predictions in the same
// sense; an edge is where they disagree in opposite senses, by more than EDGE_STEP_PX.
#ifndef PERIGEE_REFERENCE_COMPARE_EDGES_H
#define PERIGEE_REFERENCE_COMPARE_EDGES_H

#include <stdbool.h>

#include "base/status.h"
#include "base/vec.h"

enum { EDGE_SEARCH_PX = 8 };
// Of a surface that faces the ray, in sizes of a pixel there.
#define EDGE_STEP_PX 0.5
// Where an edge of one picture is looked for in the other, steps of this size are edges too: one
// just above EDGE_STEP_PX is not lost because the other's is just below it.
#define EDGE_FAINT_PX 0.125
// Same edge: depths of the near side are no farther apart than this factor; against sky the other,
// as the ground runs away from the viewer just below the horizon.
#define EDGE_DEPTH_FACTOR 1.25
#define LIMB_DEPTH_FACTOR 3.0

typedef struct depth_picture {
    const float *z_m; // along the view axis, NaN: sky
    int width, height;
    double scale; // width of a pixel at z = 1
} depth_picture;

// 1 / z about a pixel: value and change for each pixel to the right and down, from the neighbours
// on both sides, or from one where they disagree as at an edge. z_m there is not NaN.
typedef struct depth_plane {
    double w, right, down;
} depth_plane;
depth_plane depth_plane_at(const depth_picture *p, int x, int y);

// The plane's unit normal in the eye's frame (right, up, forward), towards the viewer.
dvec3 depth_plane_normal(const depth_picture *p, const depth_plane *plane, int x, int y);

// Between a pixel and its neighbour: 0 none, 2 an edge whose near side is the pixel, -2 the
// neighbour; 1 and -1 faint ones, which are only looked for; 3 and -3 against ground of which only
// the last pixel before the sky shows, which are not counted, as half a pixel hides them.
typedef struct edge_picture {
    signed char *right, *below; // width * height each
} edge_picture;

// ERR_MEMORY, logged.
status edges_find(const depth_picture *p, edge_picture *out);
void edges_deinit(edge_picture *e);

// Sets mask to 1 in the 3 x 3 neighbourhoods that hold both sides of an edge.
void edges_mark(const depth_picture *p, const edge_picture *e, unsigned char *mask);

// Called for each edge of one picture that is counted: x, y the near pixel, whether the far one is
// sky, displacement in px, or NaN when the other picture has none such within the search. An edge
// is counted along rows when its normal is nearer to the row, else along columns; the displacement
// is the pixels along that row or column to the other picture's nearest edge with the same side
// near, times the cosine to the normal. As edges lie somewhere between two pixels each displacement
// is known to about a pixel, but the mean over many is not biased: a long edge moved by s px gives
// s. Edges so near to the picture's border that their like may be outside are not reported as not
// found.
typedef struct edge_sink {
    void (*found)(void *user, int x, int y, bool limb, double displacement_px);
    void *user;
} edge_sink;

// From the edges of b to those of a; mask (or NULL) is set to 1 between them.
void edges_match(const depth_picture *pb, const edge_picture *b, const depth_picture *pa,
                 const edge_picture *a, unsigned char *mask, const edge_sink *sink);

#endif
